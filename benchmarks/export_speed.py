"""Time and size of exported C beside numba's kernels, in one run.

    python benchmarks/export_speed.py [CASE ...]
    python benchmarks/export_speed.py --acados PATH

In turns, a drive in Python (a compiled loop, which times each decision) and the exported program on what
these decisions saw, both in thread CPU time. Then the same program without guesses: every problem is solved
by the interior point, as the first one is. From the times and the counted rounds follows an estimate of the
worst case: the largest number of rounds that the engine's settings allow, each as long as measured here. It
is an estimate, no proof: caches, interrupts and other processors are not in it.

With `--acados`, `implicit` in 2 DOF with N = 50 is compared with the QP solvers of acados, see
`peers_acados.py`, which says what PATH is and how they are called. All take turns on the closed loops of
`otolith bench`, and are judged by the same stretches of decisions, of each the least of three turns. A step
of the program, and of numba's kernels, is the whole decision: predict, linearise, write, solve, certify, and
check that the platform could stop. Of acados the solve call alone counts; its QP is that of the decision.
"""

import argparse
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
from otolith.bench import SCENARIOS
from otolith.core.arrays import Mat, Vec
from otolith.core.frames import SURGE_PITCH, dofs_named
from otolith.cueing.design import Design, mpcs_of
from otolith.export.make import Kind, program_of
from otolith.export.program import Program
from otolith.export.vectors import drive, simulated
from otolith.loop import Run
from otolith.qp.structured.generate import INFO, SETTINGS
from otolith.scenarios import scenario
from peers import OURS, Ours, Result, account, best_of, counted, heading, measured, places, recorded
from peers_acados import makers_of

# Sums may be fused and reordered, as numba's are; NaN and infinity are respected
FLAGS = (
    *("-std=gnu99", "-O3", "-march=native", "-ffp-contract=fast", "-fno-math-errno"),
    *("-fno-trapping-math", "-fno-signed-zeros", "-fassociative-math", "-freciprocal-math"),
)
STEPS, TURNS = 3000, 5
SAME = 1e-4  # [m/s² or rad/s²] between first inputs of sides that solve the same problem to a certificate
CASES = {
    "classical": "surge-pitch",
    "implicit": "surge-pitch",
    "predictive": "surge-pitch",
    "implicit 4 DOF": "surge-pitch,sway-roll",
}
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

    def run(self, inputs: Mat, *, guesses: bool = True) -> tuple[Vec, Mat, Mat]:
        """Return the time of each step [s] (n,), what the engine counted (n, INFO), and the outputs."""
        n = len(inputs)
        out, seconds, rounds = np.zeros((n, self._outputs)), np.zeros(n), np.zeros((n, len(INFO)))
        given = [ctypes.c_void_p(one.ctypes.data) for one in (inputs, out, seconds, rounds)]
        self.library.run(n, *given, int(guesses))
        return seconds, rounds, out


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
            seconds, rounds, _ = timed.run(checks.inputs)
            of_c.append(seconds[100:])
            counts.append(rounds[100:])
            seconds, rounds, _ = timed.run(checks.inputs, guesses=False)
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


class Loops:
    """The closed loops of `otolith bench`, decided by numba's kernels, and their decisions by the program."""

    def __init__(self, design: Design, folder: Path) -> None:
        self.design = design
        self.timed = Timed(program_of(design, "implicit", "timed", Kind.COMMAND), design, "implicit", folder)
        self.numba = self.c = np.array(np.inf)  # (n,) least time of every decision so far [s]
        self.outputs = np.empty((0, 0))  # (n, outputs) of the program

    def turn(self) -> None:
        """Let both decide all that there is."""
        loops = [self._loop(name) for name in SCENARIOS]
        self.numba = np.minimum(self.numba, np.concatenate([run.step_time for run, _ in loops]))
        answers = [self.timed.run(inputs) for _, inputs in loops]
        self.c = np.minimum(self.c, np.concatenate([seconds for seconds, _, _ in answers]))
        self.outputs = np.vstack([out for _, _, out in answers])

    def _loop(self, name: str) -> tuple[Run, Mat]:
        reference = scenario(name, axis=SURGE_PITCH.along)
        run, checks = simulated(self.design, "implicit", Kind.COMMAND, reference, plant="ideal")
        return run, checks.inputs


def beside_acados(root: Path) -> None:
    """Print the times of the program, of numba's kernels and of acados on the same decisions.

    Raises
    ------
    FileNotFoundError : there is no acados.
    """
    makers, versions = makers_of(root)
    recording = recorded([SURGE_PITCH])
    with tempfile.TemporaryDirectory() as name:
        loops = Loops(Design(platform=files.read_platform("thesis"), dofs=(SURGE_PITCH,)), Path(name))
        results = measured(recording, {OURS: Ours, **makers}, loops.turn)
    best = best_of(account("2", results))
    if best is None:
        raise RuntimeError("no setting of acados certifies enough answers to be compared")
    name, kept, at = best["engine"], counted(results), places(len(loops.c))
    print(f"{heading(versions)}\n{kept.sum()} decisions of implicit, 2 DOF, N = 50")
    check_same(loops.outputs[at], {one: results[one] for one in (OURS, name)})
    c = loops.c[at][kept]
    print(f"  {describe('exported C, whole decision:', c)}")
    beside("numba, whole decision", loops.numba[at][kept], c)
    beside(f"{name}, QP alone", results[name].solve[kept], c)


def beside(label: str, seconds: Vec, c: Vec) -> None:
    """Print the times of one side, and how many times those of the program they are."""
    median, high, most = (
        f(seconds) / f(c) for f in (np.median, lambda times: np.percentile(times, 99), np.max)
    )
    print(f"  {describe(f'{label}:', seconds)}; times C's: {median:.2f}, {high:.2f}, {most:.2f}")


def check_same(outputs: Mat, results: dict[str, Result]) -> None:
    """Print how far the first inputs of others, for the same decisions, are from the program's commands.

    Raises
    ------
    RuntimeError : they are so far apart that the sides did not decide the same.
    """
    pitch, surge = outputs[:, SURGE_PITCH.rotation], outputs[:, SURGE_PITCH.translation]
    commands = np.column_stack([SURGE_PITCH.sign * pitch, surge])
    gaps = {name: np.abs(one.first - commands).max() for name, one in results.items()}
    for name, gap in gaps.items():
        print(f"  first inputs of {name} differ from C's commands by at most {gap:.0e} m/s² or rad/s²")
    if max(gaps.values()) > SAME:
        raise RuntimeError(f"the sides decide different problems: more than {SAME} m/s² or rad/s² apart")


def case(label: str) -> str:
    """Return a label of `CASES`; another one is refused."""
    if label not in CASES:
        raise argparse.ArgumentTypeError(f"{label!r} is none of {', '.join(CASES)}")
    return label


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("cases", nargs="*", metavar="CASE", type=case, help=", ".join(CASES))
    parser.add_argument("--acados", type=Path, metavar="PATH", help="compare with acados, installed there")
    chosen = parser.parse_args()
    if chosen.acados and chosen.cases:
        parser.error("--acados compares `implicit` in 2 DOF: name no case beside it")
    if chosen.acados:
        try:
            beside_acados(chosen.acados)
        except FileNotFoundError as absent:
            print(absent, file=sys.stderr)
            return 2
        return 0
    for label in chosen.cases or CASES:
        measure(label.split()[0], CASES[label])
    return 0


if __name__ == "__main__":
    sys.exit(main())
