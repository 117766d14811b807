"""How long commands take to start, this checkout beside another one: CPU seconds and seconds.

    git worktree add /tmp/before 6f24dd5
    python benchmarks/start_up.py /tmp/before [--rounds 5] [--cold-rounds 1]

The two sides take turns, and the least of all rounds counts: on a busy machine the others measure its
neighbours. `cached` has caches that a run before has filled, `cold` empty ones, those of drawing included.
Where `tools/ship_kernels.py` has been called, this checkout's cold run takes its code from the archive.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final, NamedTuple

from rows import Row, write_rows

HERE: Final = Path(__file__).resolve().parents[1]
PROGRAM: Final = "from otolith.cli import main; main()"
CACHED: Final = (
    ("--help",),
    ("list", "cueing"),
    ("list", "roads"),
    ("platform", "show", "thesis"),
    ("platform", "show", "davsi"),
    ("run", "sine-1"),
)
COLD: Final = (("run", "sine-1"),)
GOALS: Final = {
    ("cold", ("run", "sine-1")): 10.0,
    ("cached", ("run", "sine-1")): 3.0,
    ("cached", ("list", "cueing")): 3.0,
    ("cached", ("platform", "show", "davsi")): 4.0,
}


class Cost(NamedTuple):
    """What one call of a command takes."""

    cpu: float  # [s] user and system
    wall: float  # [s]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=Path, help="Folder of the other checkout.")
    parser.add_argument("--rounds", type=int, default=5, help="Calls of each command with caches; 0: none.")
    parser.add_argument("--cold-rounds", type=int, default=1, help="Calls with empty caches; 0: none.")
    parser.add_argument("--json", type=Path, help="File for the rows of the table of speed.")
    given = parser.parse_args()
    rows: list[Row] = []
    sides = (given.before.resolve(), HERE)
    shipped = (HERE / "src" / "otolith" / "kernels.zip").is_file()
    print(f"before: {sides[0]}; now: {HERE}, {'with' if shipped else 'without'} machine code that came along")
    print(f"{'command':34}{'CPU s: before':>15}{'now':>8}{'ratio':>8}{'s: before':>14}{'now':>8}{'ratio':>8}")
    with tempfile.TemporaryDirectory() as folder:
        caches = [Path(folder) / name for name in ("before", "now")]
        for command in CACHED if given.rounds else ():
            for side, cache in zip(sides, caches, strict=True):
                cost_of(command, side, cache)  # fills the caches
            rows.append(tell("cached", command, least(command, sides, caches, given.rounds)))
        for command in COLD if given.cold_rounds else ():
            rounds = [
                [Path(folder) / f"{name}-{number}" for name in ("before", "now")]
                for number in range(given.cold_rounds)
            ]
            costs = [least(command, sides, empty, 1) for empty in rounds]
            rows.append(tell("cold", command, [least_of([one[side] for one in costs]) for side in range(2)]))
    if given.json:
        write_rows(given.json, rows)


def least(command: tuple[str, ...], sides: tuple[Path, Path], caches: list[Path], rounds: int) -> list[Cost]:
    """Least cost of a command on both sides, which take turns."""
    costs = [[cost_of(command, *one) for one in zip(sides, caches, strict=True)] for _ in range(rounds)]
    return [least_of([one[side] for one in costs]) for side in range(2)]


def least_of(costs: list[Cost]) -> Cost:
    return Cost(min(one.cpu for one in costs), min(one.wall for one in costs))


def cost_of(command: tuple[str, ...], side: Path, cache: Path) -> Cost:
    """Call a command of a checkout in a process of its own, with caches in a folder of its own."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(side / "src"),
        "XDG_CACHE_HOME": str(cache),
        "NUMBA_CACHE_DIR": str(cache / "numba"),
        "OTOLITH_CACHE": str(cache / "kernels"),
    }
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # an installed package has its modules compiled
    writes = command[0] in {"run", "platform"}
    out = ("--out", str(cache / "out"), "--force") if writes else ()
    line = [sys.executable, "-c", PROGRAM, *command, *out]
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(line, env=environment, check=True, capture_output=True)  # noqa: S603
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Cost(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall)


def tell(kind: str, command: tuple[str, ...], costs: list[Cost]) -> Row:
    """Print the cost of a command on both sides, and return it as a row."""
    name, (before, now) = f"{' '.join(command)} ({kind})", costs
    cells = (before.cpu, now.cpu, before.cpu / now.cpu, before.wall, now.wall, before.wall / now.wall)
    print(
        f"{name:34}{cells[0]:15.2f}{cells[1]:8.2f}{cells[2]:8.1f}{cells[3]:14.2f}{cells[4]:8.2f}{cells[5]:8.1f}"
    )
    return Row(
        what=f"otolith {name}", before=before.cpu, now=now.cpu, unit="CPU s", goal=GOALS.get((kind, command))
    )


if __name__ == "__main__":
    main()
