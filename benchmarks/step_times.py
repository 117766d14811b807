"""Thread CPU time of a decision, of one source tree or of two that take turns.

    python benchmarks/step_times.py [OTHER_SRC]

Every algorithm decides along one reference of 20 s three times, on the plant of its model; of each decision
the least time counts. With OTHER_SRC, the `src` folder of another version with the same interface, both run
alternately, twice each, in processes of their own, and the ratio of this one to the other is printed.
"""

import json
import os
import subprocess
import sys
import time
from functools import reduce
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.design import Design
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.interfaces import PlatformState, Reference
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.registry import make_cueing
from otolith.scenarios import Scenario, scenario

ALGORITHMS = ("implicit", "implicit-sensed")
FORMS = {"full": MpcSettings(), "blocked": MpcSettings(horizon=sum(BLOCKS), blocks=BLOCKS)}
DOFS: tuple[tuple[Dof, ...], ...] = ((SURGE_PITCH,), (SURGE_PITCH, SWAY_ROLL))
REFERENCE = "multisine:seed=7,amplitude=1.5,duration=20"
PASSES, TURNS = 3, 2
Times = dict[str, tuple[float, float, float]]  # median, p99, max [µs]


def times_of(name: str, dofs: tuple[Dof, ...], settings: MpcSettings) -> tuple[float, float, float]:
    platform, plant = load("thesis"), Ideal()
    cueing = make_cueing(name, Design(platform=platform, dofs=dofs, mpc=settings))
    wanted = reduce(Scenario.combined_with, [scenario(REFERENCE, axis=dof.along) for dof in dofs])
    steps = round(wanted.duration / cueing.period)
    forces = wanted.specific_force(np.arange(float(steps)) * cueing.period)
    least = np.full(steps, np.inf)
    with threadpool_limits(limits=1):
        for _ in range(PASSES):
            state = PlatformState()
            cueing.reset(state)
            plant.reset(state)
            for i, force in enumerate(forces):
                reference, began = Reference(specific_force=force), time.thread_time_ns()
                command = cueing.step(state, reference)
                least[i] = min(least[i], 1e-3 * (time.thread_time_ns() - began))
                state = plant.step(command, cueing.period)
    return float(np.median(least)), float(np.percentile(least, 99)), float(least.max())


def all_times() -> Times:
    return {
        f"{name}, {2 * len(dofs)} DOF, {form}": times_of(name, dofs, settings)
        for name in ALGORITHMS
        for dofs in DOFS
        for form, settings in FORMS.items()
    }


def of_tree(src: str) -> Times:
    environment = os.environ | {"PYTHONPATH": src}
    run = subprocess.run(  # noqa: S603 (this very file)
        [sys.executable, __file__, "--json"], env=environment, capture_output=True, text=True, check=True
    )
    times: Times = json.loads(run.stdout)
    return times


def main(arguments: list[str]) -> None:
    if arguments == ["--json"]:
        print(json.dumps(all_times()))
        return
    trees = [*arguments, str(Path(__file__).parents[1] / "src")]
    turns = [[of_tree(tree) for tree in trees] for _ in range(TURNS)]
    for name in turns[0][0]:
        best = [np.min([turn[i][name] for turn in turns], axis=0) for i in range(len(trees))]
        text = "   ".join("/".join(f"{value:.1f}" for value in one) for one in best)
        ratio = f"   ratio of medians {best[-1][0] / best[0][0]:.3f}" if len(trees) > 1 else ""
        print(f"{name:32} {text} us (median/p99/max){ratio}")


if __name__ == "__main__":
    main(sys.argv[1:])
