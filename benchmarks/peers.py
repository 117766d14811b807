"""What the comparisons with other QP solvers share: problems, clock, certificates, and one form of table.

The problems are those that the closed loops of `otolith bench` pose (full horizon, hard rows), in stretches
of consecutive problems from all its signals, so that a solver may start each from its last answer. Stretch by
stretch the engines take turns, several times over; of every problem the least thread CPU time counts. The
first problem of a stretch only gives the others a start and is not counted, nor are problems at rest, whose
answer is zero: there the certificate, which knows no absolute sizes, has nothing to compare with.

Ours is timed as a controller runs it: predict, linearise and write (its "update"), then check the data, solve
and certify. Of a peer the time of its solve call counts. The matrices in the form that it takes are made
outside the clock, and its memory is allocated beforehand. Where its interface hands data over in a call of
its own, the time of that call is shown, too. Every answer is judged by the same `stage_residual`, whatever
its engine says of it.
"""

import argparse
import json
import platform as machine
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from time import thread_time
from typing import Any, Final, Protocol

import numpy as np
from threadpoolctl import threadpool_limits

from otolith.bench import SCENARIOS, Step, record
from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import load
from otolith.qp import Qp, Status
from otolith.qp.engines import StructuredEngine, empty_memory, expand
from otolith.qp.stage import StageQp, StageSolution, condense, stage_residual

PAIR_SETS: Final[tuple[tuple[Dof, ...], ...]] = ((SURGE_PITCH,), (SURGE_PITCH, SWAY_ROLL))
LENGTH, EVERY, PASSES = 50, 910, 3  # problems of a stretch, from one stretch to the next, turns
TOLERANCE: Final = MpcSettings().tolerance
OURS: Final = "otolith, structured"
ENOUGH: Final = 0.99  # share of certified answers from which a setting may be a solver's best


@dataclass(frozen=True, slots=True)
class Answer:
    """Inputs and signed multipliers as `stage_residual` takes them, and the engine's own word on them."""

    U: Mat  # (N, nu)
    y: Mat  # (N, rows)
    solved: bool


class Engine(Protocol):
    """A solver with its memory; only `update` and `solve` are timed."""

    hands_over: bool  # False where the solver reads what `prepare` has written, and `update` does nothing

    def prepare(self, i: int) -> None:
        """Form the data of problem i as the solver takes them."""

    def update(self) -> None:
        """Hand these data to the solver."""

    def solve(self) -> None:
        """Solve, from the last answer where the solver can."""

    def answer(self) -> Answer:
        """Read the answer."""


@dataclass(frozen=True, slots=True)
class Recording:
    """Stretches of consecutive problems of one set of axes: what wrote them, and as stage QPs."""

    problem: Problem
    steps: list[Step]
    qps: list[StageQp]
    _condensed: dict[int, Qp] = field(default_factory=dict)

    @property
    def stretches(self) -> Iterator[range]:
        """The places of the problems of every stretch."""
        return (range(first, first + LENGTH) for first in range(0, len(self.steps), LENGTH))

    @property
    def bounded(self) -> tuple[Ints, Ints]:
        """Places of the rows, and of the inputs, of a stage that have a bound in any problem."""
        sides = [side for qp in self.qps for side in (qp.lower, qp.upper)]
        found = np.any([np.isfinite(side).any(axis=0) for side in sides], axis=0)
        nr = len(found) - self.problem.structure.inputs
        return np.flatnonzero(found[:nr]), np.flatnonzero(found[nr:])

    def condensed(self, i: int) -> Qp:
        """Return problem i in its inputs alone, kept while its stretch is in turn."""
        if i not in self._condensed:
            if len(self._condensed) >= LENGTH:
                self._condensed.clear()
            self._condensed[i] = condense(self.qps[i])
        return self._condensed[i]


Makers = Mapping[str, Callable[[Recording], Engine]]


def places(n: int, every: int = EVERY) -> Ints:
    """Return the places of the problems that are kept of n recorded ones: a stretch out of `every`."""
    starts = np.arange(every // 2, n - LENGTH, every)
    return (starts[:, None] + np.arange(LENGTH)).ravel()


def recorded(pairs: Sequence[Dof], every: int = EVERY) -> Recording:
    """Record the closed loops, and keep a stretch of problems out of `every`."""
    problem, steps = record(load("thesis"), pairs, SCENARIOS, MpcSettings())
    kept = [steps[i] for i in places(len(steps), every)]
    memory = empty_memory(problem.structure)
    problem.begin(memory)
    qps = []
    for step in kept:
        problem.write(memory, step.x, step.plan, step.wanted, None)
        qps.append(expand(problem.structure, memory))
    return Recording(problem, kept, qps)


class Ours:
    """The structured engine, as the controllers run it."""

    hands_over = True

    def __init__(self, recording: Recording) -> None:
        self.recording, self.step = recording, recording.steps[0]
        self.engine = StructuredEngine(recording.problem.structure, tolerance=TOLERANCE)
        recording.problem.begin(self.engine.memory)
        self.solution: StageSolution

    def prepare(self, i: int) -> None:
        self.step = self.recording.steps[i]

    def update(self) -> None:
        step = self.step
        self.recording.problem.write(self.engine.memory, step.x, step.plan, step.wanted, None)

    def solve(self) -> None:
        self.solution = self.engine.run()

    def answer(self) -> Answer:
        solution = self.solution
        return Answer(solution.U, solution.y, solution.status is Status.OPTIMAL)


@dataclass(frozen=True, slots=True)
class Result:
    """What one engine did with one recording; (n,) each, of its problems in their order."""

    update: Vec  # [s]
    solve: Vec  # [s]
    solved: Vec  # 1 where the engine says so
    residual: Vec
    first: Mat  # (n, nu) first inputs

    def of(self, kept: Bools) -> "Result":
        """Keep some of the problems, (n,)."""
        series = (self.update, self.solve, self.solved, self.residual, self.first)
        return Result(*(values[kept] for values in series))


def measured(
    recording: Recording, makers: Makers, at_turn: Callable[[], None] = lambda: None
) -> dict[str, Result]:
    """Let all engines solve the recording in turns, stretch by stretch.

    Parameters
    ----------
    at_turn : is called at the start of every turn, for what is timed beside these engines.
    """
    n, nu = len(recording.steps), recording.problem.structure.inputs
    engines = {name: make(recording) for name, make in makers.items()}
    results = {
        name: Result(np.full(n, np.inf), np.full(n, np.inf), np.zeros(n), np.zeros(n), np.zeros((n, nu)))
        for name in engines
    }
    with threadpool_limits(limits=1):
        for turn in range(PASSES):
            at_turn()
            for stretch in recording.stretches:
                for name, engine in engines.items():
                    _run(engine, recording, stretch, results[name], judge=turn == PASSES - 1)
    return results


def counted(results: Mapping[str, Result]) -> Bools:
    """Return which problems count (n,): not the first of a stretch, and none at rest."""
    first = results[OURS].first
    kept: Bools = (np.abs(first).max(axis=1) > 0.0) & (np.arange(len(first)) % LENGTH > 0)
    return kept


def _run(engine: Engine, recording: Recording, stretch: range, into: Result, *, judge: bool) -> None:
    for i in stretch:
        engine.prepare(i)
        began = thread_time()
        engine.update()
        between = thread_time()
        engine.solve()
        ended = thread_time()
        into.update[i] = min(into.update[i], between - began) if engine.hands_over else 0.0
        into.solve[i] = min(into.solve[i], ended - between)
        found = engine.answer()
        if judge:
            into.solved[i], into.first[i] = found.solved, found.U[0]
            into.residual[i] = stage_residual(recording.qps[i], found.U, found.y)


def account(dofs: str, results: Mapping[str, Result]) -> list[dict[str, Any]]:
    """Rows of figures of the counted problems, ours first; ratios are to our whole step."""
    kept = counted(results)
    ours = results[OURS].of(kept)
    return [_row(dofs, name, ours if name == OURS else one.of(kept), ours) for name, one in results.items()]


def _row(dofs: str, name: str, one: Result, ours: Result) -> dict[str, Any]:
    step = 1e6 * (ours.update + ours.solve)
    both = 1e6 * (one.update + one.solve)
    times = step if one is ours else 1e6 * one.solve
    certified = one.residual < TOLERANCE
    comparable = certified & (ours.residual < TOLERANCE)
    return {
        "dofs": dofs,
        "engine": name,
        "problems": len(times),
        "median_us": float(np.median(times)),
        "p99_us": float(np.percentile(times, 99)),
        "max_us": float(times.max()),
        "update_us": 1e6 * float(np.median(one.update)),
        "solved": float(one.solved.mean()),
        "certified": float(certified.mean()),
        "residual_median": float(np.median(one.residual)),
        "first_input_gap": float(np.abs(one.first - ours.first)[comparable].max(initial=0.0)),
        "first_input_gap_all": float(np.abs(one.first - ours.first).max(initial=0.0)),
        "ratio_median": float(np.median(times) / np.median(step)),
        "ratio_p99": float(np.percentile(times, 99) / np.percentile(step, 99)),
        "ratio_median_with_update": float(np.median(both) / np.median(step)),
    }


HEAD: Final = ("DOF", "engine", "median", "p99", "max", "update", "solved", "certified")
RATIOS: Final = ("first input off", "× ours", "× at p99", "× with update")


def best_of(rows: Sequence[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """Return the row of the fastest peer whose answers hold, if there is one."""
    held = [row for row in rows if row["engine"] != OURS and row["certified"] >= ENOUGH]
    return min(held, key=lambda row: float(row["median_us"] + row["update_us"]), default=None)


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Write the rows of one recording in Markdown; a star marks the fastest peer whose answers hold."""
    lines = [f"| {' | '.join((*HEAD, *RATIOS))} |", "|---|---|" + "---:|" * (len(HEAD) + len(RATIOS) - 2)]
    best = best_of(rows)
    for row in rows:
        cells = [row["dofs"], row["engine"] + (" \\*" if row is best else "")]
        cells += [f"{row[name]:.0f}" for name in ("median_us", "p99_us", "max_us")]
        cells += [f"{row['update_us']:.0f}" if row["update_us"] else ""]
        cells += [f"{100 * row[name]:.1f} %" for name in ("solved", "certified")]
        cells += [f"{row['first_input_gap_all']:.0e}"]
        cells += [f"{row[name]:.1f}" for name in ("ratio_median", "ratio_p99", "ratio_median_with_update")]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def compare(makers: Makers, versions: Mapping[str, str], chosen: argparse.Namespace) -> None:
    """Measure ours and the peers on all sets of axes, print the table, and store it where asked to."""
    print(heading(versions))
    rows: list[dict[str, Any]] = []
    for pairs in PAIR_SETS:
        results = measured(recorded(pairs), {OURS: Ours, **makers})
        found = account(str(2 * len(pairs)), results)
        print(f"\n{found[0]['problems']} problems, µs of thread CPU\n\n{table(found)}", flush=True)
        rows += found
    if chosen.json:
        told = {"date": _today(), "machine": _machine(), "versions": dict(versions), "rows": rows}
        chosen.json.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")


def heading(versions: Mapping[str, str]) -> str:
    """Return one line of day, machine and versions."""
    return ", ".join([_today(), _machine(), *(f"{name} {version}" for name, version in versions.items())])


def _today() -> str:
    return f"{datetime.now(UTC):%Y-%m-%d}"


def _machine() -> str:
    model = ""
    cpu = Path("/proc/cpuinfo")
    if cpu.exists():
        named = [line for line in cpu.read_text().splitlines() if line.startswith("model name")]
        model = f" ({named[0].split(':')[1].strip()})" if named else ""
    return f"{machine.machine()}{model}, Python {machine.python_version()}"


def arguments(what: str) -> argparse.ArgumentParser:
    """Options that all comparisons have."""
    parser = argparse.ArgumentParser(description=what)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the table here, too")
    return parser
