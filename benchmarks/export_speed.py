"""Time and size of exported C beside numba's kernels, in one run.

    python benchmarks/export_speed.py [CUEING ...]

In turns, a drive in Python (a compiled loop, which times each decision) and the exported program on what
these decisions saw, both in thread CPU time. Then the same program without guesses: every problem is solved
by the interior point, as the first one is. From the times and the counted rounds follows an estimate of the
worst case: the largest number of rounds that the engine's settings allow, each as long as measured here. It
is an estimate, no proof: caches, interrupts and other processors are not in it.
"""

import ctypes
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from tests.export.in_c import COMPILER

from otolith import files, registry
from otolith.core.arrays import Mat, Vec
from otolith.core.frames import dofs_named
from otolith.cueing.design import Design, mpcs_of
from otolith.export.make import Kind, program_of
from otolith.export.program import Program
from otolith.export.vectors import drive, simulated
from otolith.qp.structured.generate import INFO, SETTINGS

# Sums may be fused and reordered, as numba's are; NaN and infinity are respected
FLAGS = (
    *("-std=gnu99", "-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno"),
    *("-fno-trapping-math", "-fno-signed-zeros", "-fassociative-math", "-freciprocal-math"),
)
STEPS, TURNS = 3000, 5
TIMED = """
#define _POSIX_C_SOURCE 200809L
#define TIMED_IMPLEMENTATION
#include "timed.h"
#include <time.h>
static double now(void) {{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}}
unsigned long size_of_it(void) {{ return sizeof(timed); }}
static timed instance __attribute__((aligned(64)));
void run(int n, const double *in, double *out, double *seconds, double *rounds, int guesses) {{
    timed *const me = &instance;
    timed_init(me);
    {no_guesses}
    for (int k = 0; k < n; k++) {{
        const double began = now();
        timed_step(me, in + k * TIMED_INPUTS, out + k * TIMED_OUTPUTS);
        seconds[k] = now() - began;
        for (int i = 0; i < {counts}; i++) rounds[k * {counts} + i] = {info};
    }}
}}
"""


class Timed:
    """A program that times its steps."""

    def __init__(self, program: Program, design: Design, cueing: str, folder: Path) -> None:
        controllers = mpcs_of(registry.make_cueing(cueing, design))
        info, setting = "0.0", ""
        if controllers:
            solver = controllers[0].engine._solver  # type: ignore[attr-defined]
            room = re.findall(r"double (\w*workspace\w*)\[", program.header)[0]
            base = solver.vector.ctypes.data
            at = [(solver.part(name).ctypes.data - base) // 8 for name in ("INFO", "SETTING")]
            info = f"me->{room}[{at[0]} + i]"
            setting = f"if (!guesses) me->{room}[{at[1] + SETTINGS.index('EXCHANGES')}] = 0.0;"
        (folder / "timed.h").write_text(program.header)
        text = TIMED.format(no_guesses=setting or "(void)guesses;", counts=len(INFO), info=info)
        (folder / "timed.c").write_text(text)
        line = [str(COMPILER), *FLAGS, "-shared", "-fPIC", str(folder / "timed.c"), "-o"]
        subprocess.run([*line, str(folder / "timed.so"), "-lm"], check=True)  # noqa: S603
        self.library = ctypes.CDLL(str(folder / "timed.so"))
        self.library.size_of_it.restype = ctypes.c_ulong
        self.size = int(self.library.size_of_it())
        self._outputs = len(program.outputs)

    def run(self, inputs: Mat, *, guesses: bool = True) -> tuple[Vec, Mat]:
        """Return the time of each step [s] (n,), and what the engine counted (n, INFO)."""
        n = len(inputs)
        out, seconds, rounds = np.zeros((n, self._outputs)), np.zeros(n), np.zeros((n, len(INFO)))
        given = [ctypes.c_void_p(one.ctypes.data) for one in (inputs, out, seconds, rounds)]
        self.library.run(n, *given, int(guesses))
        return seconds, rounds


def code_size(folder: Path, name: str, *flags: str) -> int:
    """Return the bytes of code and constants of a program."""
    (folder / "size.c").write_text(f'#define {name.upper()}_IMPLEMENTATION\n#include "{name}.h"\n')
    line = [str(COMPILER), "-std=c99", *flags, "-c", str(folder / "size.c"), "-o", str(folder / "size.o")]
    subprocess.run(line, check=True)  # noqa: S603
    told = subprocess.run(["size", str(folder / "size.o")], check=True, capture_output=True, text=True)  # noqa: S603, S607
    return int(told.stdout.splitlines()[1].split()[0])


def describe(label: str, seconds: Vec) -> str:
    median, high, most = (1e6 * x for x in (np.median(seconds), np.percentile(seconds, 99), seconds.max()))
    return f"{label} median {median:.1f}, p99 {high:.1f}, max {most:.1f} µs"


def measure(cueing: str, dofs: str) -> None:
    """Print the figures of one algorithm."""
    design = Design(platform=files.read_platform("thesis"), dofs=dofs_named(dofs.split(",")))
    program = program_of(design, cueing, "timed", Kind.COMMAND)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        timed = Timed(program, design, cueing, folder)
        of_python, of_c, counts, cold, cold_counts = [], [], [], [], []
        for seed in range(TURNS):
            run, checks = simulated(design, cueing, Kind.COMMAND, drive(STEPS * program.period, seed))
            of_python.append(run.step_time[100:])
            seconds, rounds = timed.run(checks.inputs)
            of_c.append(seconds[100:])
            counts.append(rounds[100:])
            seconds, rounds = timed.run(checks.inputs, guesses=False)
            cold.append(seconds[100:])
            cold_counts.append(rounds[100:])
        python, c, without = (np.concatenate(one) for one in (of_python, of_c, cold))
        print(f"{cueing}, {dofs}: {describe('numba', python)}; {describe('C', c)}")
        ratio = [np.median(a) / np.median(b) for a, b in zip(of_c, of_python, strict=True)]
        print(f"  ratio of medians C / numba in each turn: {', '.join(f'{one:.2f}' for one in ratio)}")
        small, middle, large = (code_size(folder, "timed", flag) / 1e3 for flag in ("-Os", "-O2", "-O3"))
        print(
            f"  code -Os {small:.0f}, -O2 {middle:.0f}, -O3 {large:.0f} kB; struct {timed.size / 1e3:.0f} kB"
        )
        if mpcs_of(registry.make_cueing(cueing, design)):
            print(f"  {describe('without guesses', without)}")
            worst_case(np.vstack(counts), c, np.vstack(cold_counts), without)


def worst_case(counts: Mat, seconds: Vec, cold_counts: Mat, cold: Vec) -> None:
    """Print the estimate of the worst case."""
    factors, refined, iterations = (
        INFO.index(one) for one in ("FACTORISATIONS", "REFINEMENTS", "ITERATIONS")
    )
    both = np.vstack([counts, cold_counts])
    rows = np.column_stack([np.ones(len(both)), both[:, [factors, refined, iterations]]])
    found, *_ = np.linalg.lstsq(rows, np.concatenate([seconds, cold]), rcond=None)
    exchanges, polish, limit, steps = 20, 3 * 12, 60, 20
    most = found @ np.array([1.0, exchanges + polish, (exchanges + polish) * steps, limit])
    base, factor, step, iteration = 1e6 * found
    seen = ", ".join(str(int(both[:, column].max())) for column in (factors, refined, iterations))
    print(
        f"  fitted: {base:.1f} µs + {factor:.2f} per factorisation, {step:.2f} per multiplier step, "
        f"{iteration:.2f} per interior-point step; seen at most {seen}; allowed {exchanges + polish}, "
        f"{(exchanges + polish) * steps}, {limit}: {1e3 * most:.2f} ms at worst"
    )


def main() -> None:
    cases = {
        "classical": "surge-pitch",
        "implicit": "surge-pitch",
        "predictive": "surge-pitch",
        "implicit 4 DOF": "surge-pitch,sway-roll",
    }
    for label in sys.argv[1:] or cases:
        measure(label.split()[0], cases[label])


if __name__ == "__main__":
    main()
