"""CPU time of a decision in Python and of a period of a closed loop, of one source tree or of two in turns.

    python benchmarks/loop_speed.py [OTHER_SRC] [--turns N] [--only WORDS] [--json FILE]

A decision is `Cueing.step`, called from Python along a reference of 20 s. A period is the whole of `simulate`
divided by its periods: decision, plant, record. Every case runs three times in one process, and of every
decision, and of the loops, the least time counts. With OTHER_SRC, the `src` folder of another version with
the same interface, both run in turns, in processes of their own, and the ratio of the other one to this one
is printed: how many times faster this one is. Every tree has a folder of generated kernels of its own.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from functools import reduce
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from otolith import registry
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.ahead import Ahead
from otolith.cueing.design import Design
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.interfaces import Cueing, Plant, PlatformState, Reference
from otolith.loop import simulate
from otolith.platforms import Platform, load
from otolith.scenarios import Scenario, scenario
from rows import Row, write_rows

REFERENCE = "multisine:seed=7,amplitude=1.5,duration=20"
TWO: tuple[Dof, ...] = (SURGE_PITCH,)
FOUR: tuple[Dof, ...] = (SURGE_PITCH, SWAY_ROLL)
FULL, BLOCKED = MpcSettings(), MpcSettings(horizon=sum(BLOCKS), blocks=BLOCKS)
WASHOUTS = ("classical", "optimal", "optimal-nonlinear", "adaptive")
CASES: dict[str, tuple[str, str, str, tuple[Dof, ...], MpcSettings]] = {
    "implicit, 2 DOF, ideal": ("implicit", "thesis", "ideal", TWO, FULL),
    "implicit, 2 DOF, blocked, ideal": ("implicit", "thesis", "ideal", TWO, BLOCKED),
    "predictive, 2 DOF, ideal": ("predictive", "thesis", "ideal", TWO, FULL),
    "predictive, 2 DOF, actuator": ("predictive", "thesis", "actuator", TWO, FULL),
    "implicit-trajectory, 2 DOF, ideal": ("implicit-trajectory", "thesis", "ideal", TWO, FULL),
    "implicit, 4 DOF, ideal": ("implicit", "thesis", "ideal", FOUR, FULL),
    "implicit, 4 DOF, actuator": ("implicit", "thesis", "actuator", FOUR, FULL),
    "predictive, 4 DOF, ideal": ("predictive", "thesis", "ideal", FOUR, FULL),
    **{f"{name}, 4 DOF, ideal": (name, "thesis", "ideal", FOUR, FULL) for name in WASHOUTS},
    "classical, 4 DOF, actuator": ("classical", "thesis", "actuator", FOUR, FULL),
    "classical, 2 DOF, hexapod": ("classical", "davsi", "hexapod", TWO, FULL),
    "predictive, 2 DOF, hexapod": ("predictive", "davsi", "hexapod", TWO, FULL),
}
PASSES, TURNS = 3, 2
Floats = NDArray[np.float64]
Times = dict[str, list[float]]  # decision: median, p99, max; loop: per period [µs]


def made(case: str) -> tuple[Platform, Cueing, Plant, Scenario]:
    """The parts of a case."""
    name, platform_name, plant_name, dofs, settings = CASES[case]
    platform = load(platform_name)
    plant = registry.make_plant(plant_name, platform)
    cueing = registry.make_cueing(name, Design(platform=platform, dofs=dofs, mpc=settings))
    if plant.dead_time is not None:
        cueing = Ahead(cueing, lag=platform.actuators.lag_s, dead_time=plant.dead_time)
    wanted = reduce(Scenario.combined_with, [scenario(REFERENCE, axis=dof.along) for dof in dofs])
    return platform, cueing, plant, wanted


def decisions(cueing: Cueing, plant: Plant, wanted: Scenario) -> list[float]:
    """Median, p99 and maximum of the time of a decision in Python [µs]."""
    steps = round(wanted.duration / cueing.period)
    forces = wanted.specific_force(np.arange(float(steps)) * cueing.period)
    least = np.full(steps, np.inf)
    for _ in range(PASSES):
        state = PlatformState()
        cueing.reset(state)
        plant.reset(state)
        for i, force in enumerate(forces):
            reference, began = Reference(specific_force=force), time.thread_time_ns()
            command = cueing.step(state, reference)
            least[i] = min(least[i], 1e-3 * (time.thread_time_ns() - began))
            state = plant.step(command, cueing.period)
    return [float(np.median(least)), float(np.percentile(least, 99)), float(least.max())]


def period(
    platform: Platform, cueing: Cueing, plant: Plant, wanted: Scenario, dofs: tuple[str, ...]
) -> float:
    """Time of `simulate` per period [µs], the least of several."""
    times = []
    for _ in range(PASSES + 1):
        began = time.thread_time()
        simulate(cueing, plant, wanted, platform=platform, dofs=dofs)
        times.append(1e6 * (time.thread_time() - began))
    return float(min(times)) / round(wanted.duration / cueing.period)


def all_times(only: str) -> Times:
    """The figures of all cases whose names contain `only`."""
    times: Times = {}
    with threadpool_limits(limits=1):
        for case in CASES:
            if only in case:
                platform, cueing, plant, wanted = made(case)
                loop = period(platform, cueing, plant, wanted, tuple(dof.name for dof in CASES[case][3]))
                times[case] = [*decisions(cueing, plant, wanted), loop]
    return times


def kernels_of(src: str) -> Path:
    """Folder of the kernels that a source tree generates: trees would remove each other's machine code."""
    mark = hashlib.sha256(str(Path(src).resolve()).encode()).hexdigest()[:8]
    folder = Path(tempfile.gettempdir()) / f"otolith-loop-speed-{mark}"
    folder.mkdir(exist_ok=True)
    return folder


def of_tree(src: str, only: str) -> Times:
    """The figures of a source tree, from a process of its own."""
    run = subprocess.run(  # noqa: S603 (this very file)
        [sys.executable, __file__, "--times", "--only", only],
        env=os.environ | {"PYTHONPATH": src, "OTOLITH_CACHE": str(kernels_of(src))},
        capture_output=True,
        text=True,
        check=True,
    )
    times: Times = json.loads(run.stdout)
    return times


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("other", nargs="?", metavar="OTHER_SRC")
    parser.add_argument("--turns", type=int, default=TURNS)
    parser.add_argument("--only", default="")
    parser.add_argument("--times", action="store_true", help="Print this tree's own times as JSON.")
    parser.add_argument("--json", type=Path, help="File for the rows of the table of speed.")
    chosen = parser.parse_args()
    if chosen.times:
        print(json.dumps(all_times(chosen.only)))
        return
    trees = [*([chosen.other] if chosen.other else []), str(Path(__file__).parents[1] / "src")]
    turns = [[of_tree(tree, chosen.only) for tree in trees] for _ in range(chosen.turns)]
    rows: list[Row] = []
    print(f"{'':34}  decision, median/p99/max us       whole period, us")
    for case in turns[0][0]:
        best = np.array([np.min([turn[i][case] for turn in turns], axis=0) for i in range(len(trees))])
        steps = "   ".join("/".join(f"{value:.1f}" for value in one[:3]) for one in best)
        loops = "   ".join(f"{one[3]:.1f}" for one in best)
        faster = best[0] / best[-1]
        ratio = f"   x {faster[0]:.1f} (p99 {faster[1]:.1f}), x {faster[3]:.1f}" if len(trees) > 1 else ""
        print(f"{case:34}  {steps}   {loops}{ratio}")
        rows += rows_of(case, best)
    if chosen.json:
        write_rows(chosen.json, rows)


def rows_of(case: str, best: Floats) -> list[Row]:
    """The rows of one case; `best` has the figures of both trees, the other one's first."""
    goal = 10.0 if "hexapod" in case else 20.0
    rows = [
        Row(what=f"period of a closed loop, {case}", before=best[0, 3], now=best[-1, 3], unit="us", goal=goal)
    ]
    if case.startswith("implicit,"):
        goal = 5.0 if "2 DOF" in case else 4.0
        for name, k, aim in (("median", 0, goal), ("p99", 1, 4.0)):
            what = f"decision in Python, {case}, {name}"
            rows.append(Row(what=what, before=best[0, k], now=best[-1, k], unit="us", goal=aim))
    return rows


if __name__ == "__main__":
    main()
