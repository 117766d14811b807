"""What two processes gain: `compare`, `tune`, `hint build` and `reproduce` with --jobs 1 and 2, in turns.

    python benchmarks/two_cores.py [--only WORD] [--rounds 2] [--json FILE]

Wall time needs an idle machine with two cores; of all rounds the least counts. On a busy one, the CPU time
says what can be reached: that with one process, over that of the parent (what it does alone) and of the
busiest worker together. It is read from Linux's /proc. The results must be equal, or the script ends with an
error.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

HERE: Final = Path(__file__).resolve().parents[1]
SOURCES: Final = os.pathsep.join(str(HERE / one) for one in ("src", "thesis/src"))
PROGRAM: Final = "from otolith.cli import main; main()"
GOAL: Final = 1.7
DRIVES: Final = tuple(f"multisine:seed={seed},amplitude=1.5,duration=600" for seed in (1, 2))
ALGORITHMS: Final = ("--cueing", "predictive", "--cueing", "implicit")
PAIRS: Final = ("--dofs", "surge-pitch,sway-roll")
EVERY: Final = 0.02  # [s] between two looks at the processes
TICKS: Final = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Case:
    """A command, where it writes, and what of that must not depend on the number of processes."""

    words: tuple[str, ...]
    out: str  # name of the folder or file to write to; empty: it writes none
    result: Callable[[str, Path], Any]  # of what is printed, and of what is written


def of_compare(printed: str, _: Path) -> Any:
    """Return the key figures, without times."""
    scenarios = json.loads(printed)["scenarios"]
    return {
        scenario: {
            name: {key: value for key, value in one.items() if key != "step_time_us"}
            for name, one in of_one.items()
        }
        for scenario, of_one in scenarios.items()
    }


def of_hint(_: str, path: Path) -> Any:
    """Return the arrays of a hint."""
    import h5py

    with h5py.File(path) as file:
        return {
            name: file[name][()].tobytes() for name in sorted(file) if isinstance(file[name], h5py.Dataset)
        }


def of_reproduce(printed: str, _: Path) -> Any:
    """Return the names of what was computed; tables hold times of steps."""
    return sorted(json.loads(printed)["items"])


CASES: Final = {
    "compare": Case(
        (
            "compare",
            *DRIVES,
            *PAIRS,
            "--cueing",
            "predictive",
            "--cueing",
            "implicit",
            "--no-optimum",
            "--json",
        ),
        "compared",
        of_compare,
    ),
    "tune": Case(("tune", "--evaluations", "20", "--json"), "", lambda printed, _: json.loads(printed)),
    "hint build": Case(("hint", "build", *PAIRS, "--json"), "hint.h5", of_hint),
    "reproduce": Case(("reproduce", "table-5.5", "table-5.6", "--json"), "reproduced", of_reproduce),
}


@dataclass
class Cost:
    """What a command took."""

    wall: float  # [s]
    parent: float  # [s] CPU time of the process itself
    workers: list[float]  # [s] CPU time of every process that it started


def cpu_of(process: int) -> float | None:
    """Return the CPU time of a process [s], or None when it has ended."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return None
    return (int(fields[11]) + int(fields[12])) / TICKS


def children_of(process: int) -> list[int]:
    """Return the processes that a process has started and that run."""
    try:
        text = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8")
    except (FileNotFoundError, ProcessLookupError):
        return []
    return [int(word) for word in text.split()]


def cost_of(case: Case, jobs: int, folder: Path) -> tuple[Cost, Any]:
    """Call a command in a process of its own, and watch it and its workers."""
    out = folder / f"{jobs}-{case.out}"
    where = ("--out", str(out)) if case.out else ()
    force = ("--force",) if case.out and not out.suffix else ()
    line = [sys.executable, "-c", PROGRAM, *case.words, *where, *force, "--jobs", str(jobs)]
    began, seen = time.perf_counter(), dict[int, float]()
    with tempfile.TemporaryFile("w+") as printed:
        process = subprocess.Popen(  # noqa: S603
            line, env={**os.environ, "PYTHONPATH": SOURCES}, stdout=printed, stderr=subprocess.DEVNULL
        )
        while process.poll() is None:
            for one in (process.pid, *children_of(process.pid)):
                seen[one] = cpu_of(one) or seen.get(one, 0.0)
            time.sleep(EVERY)
        wall = time.perf_counter() - began
        if process.returncode:
            raise SystemExit(f"{' '.join(line)} ended with {process.returncode}")
        printed.seek(0)
        result = case.result(printed.read(), out)
    return Cost(wall, seen.pop(process.pid, 0.0), list(seen.values())), result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="Part of the command's name.")
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rows = []
    print(f"{'':12}{'1: wall':>10}{'cpu':>8}{'2: wall':>10}{'cpu':>8}{'parent':>8}{'workers':>16}"
          f"{'ratio':>8}{'reachable':>11}")  # fmt: skip
    for name, case in CASES.items():
        if given.only not in name:
            continue
        with tempfile.TemporaryDirectory() as folder:
            cost_of(case, 1, Path(folder))  # compiles what is missing
            turns = [[cost_of(case, jobs, Path(folder)) for jobs in (1, 2)] for _ in range(given.rounds)]
        if any(one != two for (_, one), (_, two) in turns):
            raise SystemExit(f"{name}: two processes found something else than one")
        one, two = (min((turn[k][0] for turn in turns), key=lambda cost: cost.wall) for k in range(2))
        workers = "/".join(f"{cpu:.1f}" for cpu in two.workers)
        ratio = one.wall / two.wall
        print(f"{name:12}{one.wall:10.1f}{one.parent:8.1f}{two.wall:10.1f}"
              f"{two.parent + sum(two.workers):8.1f}{two.parent:8.1f}{workers:>16}{ratio:8.2f}"
              f"{one.parent / (two.parent + max(two.workers, default=0.0)):11.2f}", flush=True)  # fmt: skip
        what = f"otolith {name} with two processes"
        rows.append(
            {"what": what, "before": one.wall, "now": two.wall, "unit": "s", "ratio": ratio, "goal": GOAL}
        )
    if given.json is not None:
        given.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
