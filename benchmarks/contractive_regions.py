"""Explicit laws with limits at every node, and with a contractive set at the first: regions and what is felt.

    python benchmarks/contractive_regions.py [--horizon N] [--control M ...] [--platform NAME ...]

Munir, Hovd, Fang, Olaru & Kemeny (2017) replace the constraints over the horizon by one on the next state: it
must lie in a contractive set, from each of whose states some input leads back into it. They did not get to a
control horizon of 2. Here the set is that of docs/terminal.md for the explicit model (hardly any lag, the
law's own period). The cost, the inputs' limits and the parameters are the same in all laws.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

import otolith
from otolith import registry
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.explicit import Explicit, ExplicitLaw
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_platform, explicit_problem
from otolith.cueing.mpc.rows import BrakingRows
from otolith.interfaces import Status
from otolith.loop import Run
from otolith.mpqp import Law, ParametricQp, enumerate_regions
from otolith.platforms import Platform, load

SCENARIOS: Final = ("sine-1", "step-1", "sine-2")
KINDS: Final = {
    "limits at all nodes": BrakingRows.NONE,
    "and braking rows": BrakingRows.POSITION,
    "the set at all nodes": BrakingRows.LEADING,
}


@dataclass(frozen=True, slots=True)
class Found:
    """One explicit law and what the driver feels of it."""

    constraints: int
    regions: int
    rmse: tuple[float, ...]  # [m/s²] of every scenario
    unanswered: int  # decisions of all scenarios for which the law has no region, so that the platform braked
    violations: int  # limits passed


def problem(platform: Platform, settings: ExplicitSettings) -> ParametricQp:
    """The mpQP of surge and pitch as an explicit law sees them."""
    seen = explicit_platform(platform, (SURGE_PITCH,))
    return explicit_problem(SURGE_PITCH, seen.limits(SURGE_PITCH), seen.braking, settings)


def at_the_first_node(of: ParametricQp, horizon: int) -> ParametricQp:
    """The same without the rows on all states but x_1; those on inputs, which do not depend on ϑ, stay."""
    of_states = of.S.any(axis=1)
    first = np.zeros(len(of.w), dtype=bool)
    for begin in range(0, int(of_states.sum()), 2 * horizon):  # row by row, node by node, side by side
        first[begin : begin + 2] = True
    kept = first | ~of_states
    return replace(of, G=of.G[kept], w=of.w[kept], S=of.S[kept])


def judged(platform: Platform, of: ParametricQp, settings: ExplicitSettings) -> Found:
    """Enumerate a law, and let it cue the scenarios."""
    law = enumerate_regions(of)
    runs = [simulated(platform, law, settings, name) for name in SCENARIOS]
    summaries = [otolith.summarise(run) for run in runs]
    return Found(
        constraints=len(of.w),
        regions=len(law),
        rmse=tuple(float(one["rmse_per_pair"][SURGE_PITCH.name]) for one in summaries),
        unanswered=sum(status != Status.DECIDED for run in runs for status in run.status),
        violations=sum(int(one["violations"]) for one in summaries),
    )


def simulated(platform: Platform, law: Law, settings: ExplicitSettings, name: str) -> Run:
    """One closed loop on a platform that moves as the explicit model says."""
    seen = explicit_platform(platform, (SURGE_PITCH,))
    cueing = Explicit(seen, (SURGE_PITCH,), [ExplicitLaw(law, SURGE_PITCH, settings)])
    design = otolith.Design(platform=platform, dofs=(SURGE_PITCH,))
    return otolith.simulate(
        cueing,
        registry.make_plant("ideal-no-lag", platform),
        otolith.Wanted(scenario=name).along(design),
        platform=platform,
        dofs=(SURGE_PITCH.name,),
    )


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--horizon", type=int, default=5)
    parser.add_argument("--control", type=int, nargs="*", default=[1, 2, 3])
    parser.add_argument("--platform", nargs="*", default=["thesis", "davsi"])
    chosen = parser.parse_args(arguments)
    scenarios = " | ".join(SCENARIOS)
    print(
        f"| platform | control horizon | constraints | rows | regions | {scenarios} | unanswered | passed |"
    )
    print("|---|---|---|---|---|" + "---|" * (len(SCENARIOS) + 2))
    for name in chosen.platform:
        for control in chosen.control:
            table(load(name), chosen.horizon, control)


def table(platform: Platform, horizon: int, control: int) -> None:
    """Print the rows of one platform and control horizon."""
    for label, kind in KINDS.items():
        settings = ExplicitSettings(horizon=horizon, block_from=control, braking=kind)
        of = problem(platform, settings)
        cases = {label: of}
        if kind is BrakingRows.LEADING:
            cases["the set at the first node"] = at_the_first_node(of, horizon)
        for case, one in cases.items():
            found = judged(platform, one, settings)
            rmse = " | ".join(f"{value:.3f}" for value in found.rmse)
            cells = f"{case} | {found.constraints} | {found.regions} | {rmse}"
            ends = f"{found.unanswered} | {found.violations}"
            print(f"| {platform.name} | {control} | {cells} | {ends} |", flush=True)


if __name__ == "__main__":
    main()
