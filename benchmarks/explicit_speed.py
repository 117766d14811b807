"""Speed of explicit laws, this version beside another one: enumeration, lookup, exported C.

    git worktree add /tmp/before 6f24dd5
    python benchmarks/explicit_speed.py /tmp/before/src [--turns 2] [--horizon 9] [--json FILE]

Both versions run in turns, in processes of their own, and the least of all turns counts.

Enumeration: the explicit MPC of the thesis with N = 9 (178,079 regions). Before, one thread; now, one per
processor. On a busy machine the wall time says little, so the processor time is split, too: `on free cores`
is the time of the thread that shares out the work, plus that of the others divided by the number of
processors. Peak memory is what the process takes in addition, divided by the number of regions.

Lookup: the law with N = 5 (11,089 regions) along closed loops. `kernel` is the time per query in compiled
code, going there and back between consecutive parameters; `Python` that of a call. `first two` asks for the
command alone, with the certificate and without multipliers; before, there was no such call, and everything
had to be asked for.

C: the exported law, compiled with -O2, at random parameters, each from the region of the one before, and
along the closed loops. Every query is repeated and the least time taken.
"""

import argparse
import ctypes
import inspect
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from loop_speed import kernels_of
from mpqp_lookup import best, feasible, in_kernel, in_python, trajectory
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_problem
from otolith.files import read_platform
from otolith.mpqp import Law, ParametricQp, enumerate_regions
from otolith.mpqp.export_c import export_c
from rows import Row, as_lines, write_rows

COMMAND: Final = 2  # components of the minimiser that an MPC applies
CALLS: Final = 30
PERCENTILES: Final = {"median": 50, "p99": 99, "max": 100}
GOALS: Final = {
    "enumeration, wall": 1.8,
    "enumeration, on free cores": 1.8,
    "enumeration, peak": 1.65,
    "kernel": 3.0,
    "Python": 3.0,
    "C after jumps, p99": 20.0,
    "C after jumps, max": 20.0,
}
CLOCK: Final = """
#define _POSIX_C_SOURCE 199309L
#include <time.h>
#include "law.h"
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}
void timed(const double *theta, const int *start, int count, int calls, double *least)
{
    double z[LAW_OUTPUTS];
    for (int i = 0; i < count; i++) {
        least[i] = 1e300;
        for (int turn = 0; turn < 5; turn++) {
            double began = now();
            for (int c = 0; c < calls; c++) law_evaluate(theta + i * LAW_PARAMETERS, start[i], z);
            double taken = (now() - began) / calls;
            if (taken < least[i]) least[i] = taken;
        }
    }
}
"""
Figures = dict[str, float]


def problem(horizon: int) -> ParametricQp:
    """The explicit MPC of the thesis, without move blocking."""
    thesis = read_platform("thesis")
    settings = ExplicitSettings(horizon=horizon, period=0.1, block_from=None)
    return explicit_problem(SURGE_PITCH, thesis.limits(SURGE_PITCH), thesis.braking, settings)


def enumeration(horizon: int) -> Figures:
    """Times [s] and peak memory [bytes] per region."""
    enumerate_regions(problem(2))  # compiles, and imports what is imported on use
    asked = problem(horizon)
    threads = (
        len(os.sched_getaffinity(0)) if "workers" in inspect.signature(enumerate_regions).parameters else 1
    )
    Path("/proc/self/clear_refs").write_text("5")  # forgets the peak so far
    before, own, cpu, wall = memory("VmRSS"), time.thread_time(), time.process_time(), time.perf_counter()
    law = enumerate_regions(asked)
    wall, cpu, own = time.perf_counter() - wall, time.process_time() - cpu, time.thread_time() - own
    return {
        "enumeration, wall, s": wall,
        "enumeration, processor time, s": cpu,
        "enumeration, on free cores, s": own + (cpu - own) / threads,
        "enumeration, peak per region, B": (memory("VmHWM") - before) / len(law),
    }


def memory(name: str) -> float:
    """A size of this process [bytes]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024.0 * int(next(line for line in lines if line.startswith(name)).split()[1])


def spread(name: str, times: Vec) -> Figures:
    return {f"{name}, {key}, us": float(np.percentile(times, q)) for key, q in PERCENTILES.items()}


def lookup(law: Law, along: Mat) -> Figures:
    """Times of a query along closed loops [µs]."""
    alone = first_in_kernel if hasattr(law, "first") else in_kernel
    return {
        **spread("kernel, all", in_kernel(law, along)),
        **spread("kernel, first two", alone(law, along)),
        **spread("Python, all", in_python(law, along, True)),
        **spread("Python, first two", first_in_python(law, along)),
    }


def first_in_kernel(law: Law, thetas: Mat) -> Vec:
    """As `mpqp_lookup.in_kernel`, for the command alone."""
    from otolith.mpqp import lookup as kernels  # the other version has another interface

    times, block, none = [], law._packed.block, np.empty(0, dtype=np.int64)
    call = best(partial(kernels.evaluate, block, np.empty(0), -1, np.empty(0), none))
    for i in range(1, len(thetas), 3):
        many, start = np.tile(thetas[i - 1 : i + 1], (100, 1)), law.evaluate(thetas[i]).region
        z = np.empty(COMMAND * len(many))
        taken = best(partial(kernels.evaluate, block, many.reshape(-1), start, z, none))
        times.append((taken - call) / len(many))
    return np.array(times)


def first_in_python(law: Law, thetas: Mat) -> Vec:
    times = []
    for i in range(1, len(thetas), 3):
        start = law.evaluate(thetas[i - 1]).region
        if hasattr(law, "first"):
            ask: Callable[[], Any] = partial(law.first, thetas[i], COMMAND, start)
        else:
            ask = partial(law.evaluate, thetas[i], start)
        times.append(best(partial(repeated, ask)) / CALLS)
    return np.array(times)


def repeated(ask: Callable[[], Any]) -> None:
    """One call alone is too short for the clock."""
    for _ in range(CALLS):
        ask()


def in_c(law: Law, along: Mat, anywhere: Mat) -> Figures:
    """Times of a query of the exported law [µs]; none without a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        return {}
    with tempfile.TemporaryDirectory() as name:
        folder, text = Path(name), export_c(law, "law", outputs=COMMAND)
        (folder / "law.h").write_text(text.header)
        (folder / "law.c").write_text(text.source)
        (folder / "clock.c").write_text(CLOCK)
        files = [str(folder / file) for file in ("law.so", "law.c", "clock.c")]
        subprocess.run([compiler, "-std=c99", "-O2", "-shared", "-fPIC", "-o", *files], check=True)  # noqa: S603
        library = ctypes.CDLL(files[0])
        return {
            **spread("C after jumps", timed_in_c(library, law, anywhere, 5)),
            **spread("C along loops", timed_in_c(library, law, along, 50)),
        }


def timed_in_c(library: ctypes.CDLL, law: Law, thetas: Mat, calls: int) -> Vec:
    """Least time [µs] of each query; the walk begins in the region of the one before."""
    start: Ints = np.roll(law.evaluate_many(thetas).region, 1).astype(np.int32)
    least = np.empty(len(thetas))
    pointers = [ctypes.c_void_p(array.ctypes.data) for array in (thetas, start, least)]
    library.timed(*pointers[:2], len(thetas), calls, pointers[2])
    return least


def of_this(horizon: int) -> Figures:
    """All figures of the version that this process imports."""
    figures = enumeration(horizon)
    law = enumerate_regions(problem(5))
    along, anywhere = trajectory(law, 6000, 0), feasible(law, 4000, 1)
    return figures | lookup(law, along) | in_c(law, along, anywhere)


def of_tree(src: str, horizon: int) -> Figures:
    """The figures of a source tree, from a process of its own."""
    run = subprocess.run(  # noqa: S603 (this very file)
        [sys.executable, __file__, "--one", "--horizon", str(horizon)],
        env=os.environ | {"PYTHONPATH": src, "OTOLITH_CACHE": str(kernels_of(src))},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    figures: Figures = json.loads(run.stdout)
    return figures


def rows_of(before: Figures, now: Figures) -> list[Row]:
    """Rows of the table of speed."""
    rows = []
    for name in (name for name in before if name in now):
        what, unit = name.rsplit(", ", 1)
        goal = next((goal for start, goal in GOALS.items() if what.startswith(start)), None)
        rows.append(Row(what=f"explicit: {what}", before=before[name], now=now[name], unit=unit, goal=goal))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("other", nargs="?", help="The `src` folder of another version.")
    parser.add_argument("--turns", type=int, default=2)
    parser.add_argument("--horizon", type=int, default=9, help="Steps of the law that is enumerated.")
    parser.add_argument("--json", type=Path, help="File for the rows of the table of speed.")
    parser.add_argument("--one", action="store_true", help="Print this version's figures as JSON.")
    chosen = parser.parse_args()
    if chosen.one or chosen.other is None:
        print(json.dumps(of_this(chosen.horizon), indent=2))
        return
    trees = (chosen.other, str(Path(__file__).parents[1] / "src"))
    turns = [[of_tree(tree, chosen.horizon) for tree in trees] for _ in range(chosen.turns)]
    least = [{name: min(turn[i][name] for turn in turns) for name in turns[0][i]} for i in range(2)]
    rows = rows_of(*least)
    print("\n".join(as_lines(rows)))
    if chosen.json:
        write_rows(chosen.json, rows)


if __name__ == "__main__":
    main()
