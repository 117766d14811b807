"""Decisions without a solution, and limits passed, on every shipped plant, platform and scenario.

    python benchmarks/dead_time.py [ALGORITHM ...]

Prints a line per platform, plant and algorithm over all scenarios, in 2 and in 4 DOF: decisions that were not
optimal, nodes beyond a hard limit, and how far the rate of tilt passed its own. `actuator ±50 %` are plants
whose lag and dead time are half or half as much again of what the controller is told, in all combinations.
"""

import itertools
import sys
from collections.abc import Iterator

import numpy as np

from otolith import metrics, registry
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.design import Design
from otolith.interfaces import Plant, Status
from otolith.loop import Run, simulate
from otolith.plant.actuator import Actuator
from otolith.platforms import Platform, load
from otolith.scenarios import SCENARIOS, scenario

PLATFORMS = ("davsi", "davsi-4dof", "thesis")
DOFS = {"2 DOF": (SURGE_PITCH,), "4 DOF": (SURGE_PITCH, SWAY_ROLL)}


def plants(platform: Platform) -> Iterator[tuple[str, float | None, list[Plant]]]:
    """Name, dead time that the controller is told, and the plants that go by the name."""
    for name in ("ideal", "actuator", "hexapod"):
        plant = registry.PLANTS[name].load()(platform)
        yield name, plant.dead_time, [plant]
    stated = platform.actuators
    wrong = itertools.product((0.5, 1.5), repeat=2)
    off: list[Plant] = [
        Actuator(of_lag * stated.lag_s, of_dead * stated.dead_time_s) for of_lag, of_dead in wrong
    ]
    yield "actuator ±50 %", stated.dead_time_s, off


def drive(algorithm: str, platform: Platform, pairs: tuple[Dof, ...], stated: float | None, plant: Plant):  # type: ignore[no-untyped-def]
    """Runs over all scenarios."""
    cueing = registry.make_cueing(algorithm, Design(platform=platform, dofs=pairs), dead_time=stated)
    for name in SCENARIOS:
        wanted = scenario(name)
        if len(pairs) == 2:
            wanted = wanted.combined_with(scenario(name, axis="lateral"))
        yield simulate(cueing, plant, wanted, platform=platform, dofs=tuple(pair.name for pair in pairs))


def judged(runs: list[Run]) -> tuple[int, int, int, float]:
    """Decisions, those not optimal, nodes beyond a hard limit, largest excess of the tilt rate [deg/s]."""
    decisions = sum(len(run.status) for run in runs)
    failed = sum(status != Status.DECIDED for run in runs for status in run.status)
    excesses = [excess for run in runs for excess in metrics.excesses(run)]
    rate = max((excess.at_nodes for excess in excesses if "tilt_rate" in excess.quantity), default=0.0)
    hard = sum(excess.violations for excess in excesses if "tilt_rate" not in excess.quantity)
    return decisions, failed, hard, float(np.degrees(rate))


def main(algorithms: list[str]) -> None:
    print("dofs   platform    plant           algorithm         decisions  failed  beyond  tilt rate deg/s")
    for dofs, pairs in DOFS.items():
        for platform in map(load, PLATFORMS):
            for name, stated, which in plants(platform):
                for algorithm in algorithms:
                    runs = [run for one in which for run in drive(algorithm, platform, pairs, stated, one)]
                    decisions, failed, hard, rate = judged(runs)
                    print(
                        f"{dofs}  {platform.name:11} {name:15} {algorithm:17} {decisions:9}  {failed:6}"
                        f"  {hard:6}  {rate:.3f}",
                        flush=True,
                    )


if __name__ == "__main__":
    main(sys.argv[1:] or ["implicit"])
