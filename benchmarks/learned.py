"""A network that has learned what `predictive` decides, behind the certificate: how often right, what saved?

    python benchmarks/learned.py [--every N]

The network of `hybrid-learned` (docs/hybrid.md) is fitted to closed loops of `predictive` in 2 DOF: from
the state and the force wanted it says which limits are active in the optimal plan. The solver starts there
where the set of the period before is not optimal, and certifies the answer, so the command is that of
`predictive` whatever the network says. Every Nth manoeuvre is used, of those for training and of those that
are held out.
"""

import argparse
from collections.abc import Sequence

import numpy as np

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.hints.features import braking_forms
from otolith.cueing.hints.network import Learned, Network
from otolith.cueing.hints.training.fit import Effort, fit_network
from otolith.cueing.hints.training.manoeuvres import along, training, unseen
from otolith.cueing.hints.training.recording import record
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.predictive import predictive_settings
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import MpcSettings
from otolith.loop import Run, simulate
from otolith.plant import Ideal
from otolith.platforms import load


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--every", type=int, default=1)
    every: int = parser.parse_args().every
    platform, pairs = load("thesis"), (SURGE_PITCH,)
    settings = predictive_settings(MpcSettings(), platform, pairs, 0.5)
    lessons = record(platform, pairs, settings, along(training()[::every], pairs))
    network, loss = fit_network(
        platform, pairs, settings, 0, recording=lessons, effort=Effort(), progress=lambda _: None
    )
    print(f"fitted to {len(lessons)} decisions: {network.numbers.nbytes / 1e3:.0f} kB, loss {loss:.3f}")
    print("start      right at once  changes mean, p99, max  step median, p99, max [us]   apart [m/s2]")
    runs: dict[str, list[Run]] = {}
    for name in ("previous", "learned"):
        mpc = Mpc(platform, pairs, settings, hint=_hint(network, settings) if name == "learned" else None)
        runs[name] = [
            simulate(mpc, Ideal(), scenario, platform=platform, dofs=("surge-pitch",))
            for scenario in along(unseen()[::every], pairs)
        ]
        print(f"{name:10s} {_figures(runs[name])} {_apart(runs[name], runs['previous']):14.0e}")


def _figures(runs: Sequence[Run]) -> str:
    """The share of decisions without a change of the working set, the changes, and the steps' times."""
    changes = np.concatenate([run.changes for run in runs])
    step = 1e6 * np.concatenate([run.step_time for run in runs])
    hits, most = np.mean(changes == 0), np.percentile(changes, 99)
    times = f"{np.median(step):14.1f}, {np.percentile(step, 99):.1f}, {step.max():.0f}"
    return f"{hits:13.3f} {changes.mean():12.3f}, {most:.0f}, {changes.max()} {times}"


def _apart(runs: Sequence[Run], others: Sequence[Run]) -> float:
    """The largest difference between the commands of two lots of runs [m/s², rad/s²]."""
    pairs = zip(runs, others, strict=True)
    return max(float(np.abs(one.command - other.command).max()) for one, other in pairs)


def _hint(network: Network, settings: MpcSettings) -> Learned:
    """The network at work."""
    platform, pairs = load("thesis"), (SURGE_PITCH,)
    structure = Problem(platform, pairs, settings).structure
    return Learned([network], braking_forms(platform, pairs), (len(settings.lengths), structure.rows))


if __name__ == "__main__":
    main()
