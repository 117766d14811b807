"""CPU time of the structured solver per decision, of one source tree or of two in turns; its growth with N.

    python benchmarks/solver_speed.py [OTHER_SRC] [--turns N] [--only WORDS] [--json FILE]

Closed loops over signals with jumps, sines and a multisine are recorded once, by this tree. Then each tree
writes and solves the same problems in a process of its own, and the trees take turns; of every decision the
least thread CPU time of the solver alone counts, without the writing of its problem. `growth` divides the
mean times of two horizons, each on its own recorded loop; blocks are nine at every horizon. Ratios are those
of OTHER_SRC to this tree: how many times faster this one is. A first run compiles every structure in both.
"""

import argparse
import hashlib
import json
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from otolith.bench import SCENARIOS, record
from otolith.core.arrays import Vec
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.platforms import load
from otolith.qp.blocked import Lengths
from otolith.qp.engines import StructuredEngine
from otolith.qp.structured.generate import CODES
from rows import Row, as_lines, write_rows

HERE = str(Path(__file__).parents[1] / "src")
TWO: tuple[Dof, ...] = (SURGE_PITCH,)
FOUR: tuple[Dof, ...] = (SURGE_PITCH, SWAY_ROLL)
NINE: dict[int, Lengths] = {  # blocks of the first kind, stretched to a horizon
    50: (1, 1, 2, 4, 5, 7, 8, 10, 12),
    100: (1, 1, 2, 6, 9, 13, 18, 22, 28),
    200: (1, 1, 2, 8, 15, 27, 38, 48, 60),
}
CASES: dict[str, tuple[tuple[Dof, ...], int, Lengths]] = {
    "2 DOF, full": (TWO, 50, ()),
    "2 DOF, blocked": (TWO, sum(BLOCKS), BLOCKS),
    "4 DOF, full": (FOUR, 50, ()),
    "4 DOF, blocked": (FOUR, sum(BLOCKS), BLOCKS),
    "4 DOF, full, N = 100": (FOUR, 100, ()),
    "4 DOF, full, N = 200": (FOUR, 200, ()),
    **{f"4 DOF, nine blocks, N = {N}": (FOUR, N, blocks) for N, blocks in NINE.items()},
}
GROWTHS = {  # short and long horizon
    "growth full, N = 50 to 100": ("4 DOF, full", "4 DOF, full, N = 100"),
    "growth full, N = 50 to 200, at most 5": ("4 DOF, full", "4 DOF, full, N = 200"),
    "growth nine blocks, N = 50 to 200, at most 1.5": (
        "4 DOF, nine blocks, N = 50",
        "4 DOF, nine blocks, N = 200",
    ),
}
GOALS = {"2 DOF, full": 1.92, "4 DOF, full": 1.82}  # of the p99
FIGURES: dict[str, Callable[[Vec], float]] = {
    "median": lambda times: float(np.median(times)),
    "p99": lambda times: float(np.percentile(times, 99)),
    "max": lambda times: float(np.max(times)),
    "mean": lambda times: float(np.mean(times)),
}
PASSES, TURNS, LIMIT = 3, 2, CODES.index("LIMIT")


def record_case(case: str, file: Path) -> None:
    """Record a case's closed loop: states, plans and wanted forces of all decisions."""
    dofs, N, blocks = CASES[case]
    _, steps = record(load("thesis"), dofs, SCENARIOS, MpcSettings(horizon=N, blocks=blocks))
    file.write_bytes(pickle.dumps([(one.x, one.plan, one.wanted) for one in steps]))


def times_of(case: str, file: Path) -> Vec:
    """Least time of the solver for every recorded decision [µs]."""
    dofs, N, blocks = CASES[case]
    problem = Problem(load("thesis"), dofs, MpcSettings(horizon=N, blocks=blocks))
    engine = StructuredEngine(problem.structure, tolerance=1e-6, blocks=blocks)
    problem.begin(engine.memory)
    solver, clock = engine._solver, time.thread_time_ns
    solve, workspace = solver.kernels.solve, solver.vector
    steps = pickle.loads(file.read_bytes())  # noqa: S301 (written by this very script)
    least = np.full(len(steps), np.inf)
    engine.run()
    with threadpool_limits(limits=1):
        for _ in range(PASSES):
            engine.reset()
            for i, (x, plan, wanted) in enumerate(steps):
                problem.write(engine.memory, x, plan, wanted, None)
                began = clock()
                code = solve(workspace)
                least[i] = min(least[i], 1e-3 * (clock() - began))
                if code == LIMIT:
                    engine._decide(solver.solution())
    return least


def kernels_of(src: str) -> Path:
    """Folder of the kernels that a source tree generates: trees would remove each other's machine code."""
    mark = hashlib.sha256(str(Path(src).resolve()).encode()).hexdigest()[:8]
    folder = Path(tempfile.gettempdir()) / f"otolith-solver-speed-{mark}"
    folder.mkdir(exist_ok=True)
    return folder


def of_tree(src: str, cases: list[str], folder: Path) -> dict[str, Vec]:
    """The times of a source tree, from a process of its own."""
    run = subprocess.run(  # noqa: S603 (this very file)
        [sys.executable, __file__, "--replay", str(folder), "--only", "|".join(cases)],
        env=os.environ | {"PYTHONPATH": src, "OTOLITH_CACHE": str(kernels_of(src))},
        capture_output=True,
        text=True,
        check=True,
    )
    return {case: np.array(times) for case, times in json.loads(run.stdout).items()}


def file_of(folder: Path, case: str) -> Path:
    """Where a case is recorded."""
    return folder / f"{case.replace(' ', '-')}.pickle"


def rows_of(of_trees: list[dict[str, Vec]]) -> list[Row]:
    """What is told: the distribution of every case, then the growths whose cases were both measured; `before`
    is NaN where there is one tree only.
    """
    rows = []
    for case in of_trees[-1]:
        for name, figure in FIGURES.items():
            goal = GOALS.get(case) if name == "p99" else None
            both = [float(figure(tree[case])) for tree in of_trees]
            rows.append(row(f"{case}, {name}", both, "µs", goal))
    for what, (short, long) in GROWTHS.items():
        if {short, long} <= set(of_trees[-1]):
            both = [float(np.mean(tree[long]) / np.mean(tree[short])) for tree in of_trees]
            rows.append(row(what, both, "", None))
    return rows


def row(what: str, of_trees: list[float], unit: str, goal: float | None) -> Row:
    """One line of the table of speed."""
    before = of_trees[0] if len(of_trees) > 1 else np.nan
    return Row(what=what, before=before, now=of_trees[-1], unit=unit, goal=goal)


def measured(trees: list[str], cases: list[str], turns: int) -> list[dict[str, Vec]]:
    """The least times of every tree, which take turns on the same recordings."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case in cases:
            record_case(case, file_of(folder, case))
        rounds = [[of_tree(tree, cases, folder) for tree in trees] for _ in range(turns)]
    return [
        {case: np.min([one[i][case] for one in rounds], axis=0) for case in cases} for i in range(len(trees))
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("other", nargs="?", metavar="OTHER_SRC")
    parser.add_argument("--turns", type=int, default=TURNS)
    parser.add_argument(
        "--only", default="", help="Words in the names of cases, or whole names separated by |."
    )
    parser.add_argument("--json", type=Path)
    parser.add_argument("--replay", type=Path, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    exact = [case for case in CASES if case in chosen.only.split("|")]
    cases = exact or [case for case in CASES if chosen.only in case]
    if chosen.replay:
        found = {case: times_of(case, file_of(chosen.replay, case)).tolist() for case in cases}
        print(json.dumps(found))
        return
    os.environ["OTOLITH_CACHE"] = str(kernels_of(HERE))  # recording compiles what is measured
    trees = [*([chosen.other] if chosen.other else []), HERE]
    rows = rows_of(measured(trees, cases, chosen.turns))
    print("\n".join(as_lines(rows)))
    if chosen.json:
        write_rows(chosen.json, rows)


if __name__ == "__main__":
    main()
