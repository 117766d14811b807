"""Step times of all QP engines on the same recorded problems, measured in one run.

The closed loop is recorded once. Each engine then replays the same states, plans and wanted forces, so all
engines solve identical problems, each from its own previous working set. A step is what a controller does per
period: predict, linearise, write the problem, solve and certify it. Times are thread CPU time, the least of
several passes over the whole sequence, because every pass does exactly the same work.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, Final, cast

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.errors import MissingExtra
from otolith.core.frames import Dof
from otolith.core.threads import one_thread
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.decide import Program
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.loop import simulate
from otolith.plant import Ideal
from otolith.platforms import Platform
from otolith.qp import Status
from otolith.qp.blocked import Lengths
from otolith.qp.engines import CondensedEngine, StageEngine, StructuredEngine
from otolith.qp.stage import OnRequest, StageProblem, StageSolution
from otolith.registry import SOLVERS
from otolith.scenarios import TABLE_5_1, Scenario, scenario

SCENARIOS: Final = (*TABLE_5_1, "multisine:seed=7,amplitude=1.5,duration=20")
SPARSE: Final = 40


@dataclass(frozen=True, slots=True)
class Step:
    """One recorded decision: everything from which its problem is written."""

    x: Vec
    plan: Mat
    wanted: Mat


@dataclass(frozen=True, slots=True, kw_only=True)
class Timing:
    """The results of one engine on one recording."""

    dofs: str
    form: str  # a key of FORMS
    engine: str  # a key of ENGINES
    times: Vec  # (steps,) [s]
    certified: Bools  # (steps,)
    changes: Vec  # (steps,)
    residual: Vec  # (steps,) certificates
    first: Mat  # (steps, 2P) first inputs of the plans

    def every(self, n: int) -> "Timing":
        """Keep only every n-th problem."""
        series = ("times", "certified", "changes", "residual", "first")
        return replace(self, **{name: getattr(self, name)[::n] for name in series})

    def account(self, reference: "Timing") -> dict[str, Any]:
        """Return plain figures; `reference` is the dense engine on the same recording."""
        micro = 1e6 * self.times
        both = self.certified & reference.certified
        return {
            "dofs": self.dofs,
            "form": self.form,
            "engine": self.engine,
            "steps": len(micro),
            "median_us": float(np.median(micro)),
            "p99_us": float(np.percentile(micro, 99)),
            "p999_us": float(np.percentile(micro, 99.9)),
            "max_us": float(np.max(micro)),
            "certified": float(np.mean(self.certified)),
            "residual_max": float(np.max(self.residual, initial=0.0)),
            "unchanged": float(np.mean(self.changes == 0)),
            "changes_mean": float(np.mean(self.changes)),
            "first_input_gap": float(np.max(np.abs(self.first - reference.first)[both], initial=0.0)),
            "times_faster_than_dense": float(np.median(reference.times) / np.median(self.times)),
        }


Engines = dict[str, Callable[..., StageEngine]]
ENGINES: Final[Engines] = {
    "structured": StructuredEngine,
    "structured-cold": partial(StructuredEngine, guesses=False),
    "dense": CondensedEngine,
}
FORMS: Final = {
    "full": MpcSettings(),
    "blocked": MpcSettings(horizon=sum(BLOCKS), blocks=BLOCKS),
}


class _Recorder:
    """The structured engine, which records every problem of one controller before it solves it."""

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: Lengths = ()) -> None:
        self._engine = StructuredEngine(problem, tolerance=tolerance, blocks=blocks)
        self.memory, self.steps = self._engine.memory, list[Step]()
        self.program: Program | None = None  # of the controller whose problems are recorded

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Record what the problem in the memory was written from, and solve it."""
        if (p := self.program) is not None:
            self.steps.append(Step(p.x.copy(), p.about.copy(), p.wanted.copy()))
        return self._engine.run(start, hint)

    def reset(self) -> None:
        """Forget the last answer."""
        self._engine.reset()


def record(
    platform: Platform, pairs: Sequence[Dof], names: Sequence[str], settings: MpcSettings
) -> tuple[Problem, list[Step]]:
    """Simulate the scenarios along all axes, and keep the problem of every decision."""
    cueing = Mpc(platform, pairs, replace(settings, engine=_Recorder))
    recorder = cast(_Recorder, cueing.engine)
    recorder.program = cueing.program
    for name in names:
        simulate(cueing, Ideal(), _along(name, pairs), platform=platform, dofs=tuple(p.name for p in pairs))
    return cueing.problem, recorder.steps


def _along(name: str, pairs: Sequence[Dof]) -> Scenario:
    """Return a scenario along every axis, with a different seed for each axis."""
    first, *others = (
        scenario(name.replace("seed=7", f"seed={7 + i}"), axis=pair.along) for i, pair in enumerate(pairs)
    )
    for other in others:
        first = first.combined_with(other)
    return first


def replay(
    name: str, make: Callable[..., StageEngine], problem: Problem, steps: Sequence[Step], *, passes: int
) -> Timing:
    """Let an engine solve a recording `passes` times."""
    settings = problem.settings
    engine = make(problem.structure, tolerance=settings.tolerance, blocks=settings.blocks)
    problem.begin(engine.memory)
    clock = time.thread_time
    times = np.full(len(steps), np.inf)
    certified = np.zeros(len(steps), dtype=np.bool_)
    changes, residual = np.zeros(len(steps)), np.zeros(len(steps))
    first = np.zeros((len(steps), problem.structure.inputs))
    with one_thread():
        engine.run()  # compiles and allocates on first use
        for _ in range(passes):
            engine.reset()
            for i, step in enumerate(steps):
                started = clock()
                problem.write(engine.memory, step.x, step.plan, step.wanted, None)
                solution = engine.run()
                times[i] = min(times[i], clock() - started)
                certified[i] = solution.status is Status.OPTIMAL
                changes[i], first[i] = solution.changes, solution.U[0]
                residual[i] = solution.residual if certified[i] else 0.0
    return Timing(
        dofs=",".join(pair.name for pair in problem.dofs),
        form="blocked" if settings.blocks else "full",
        engine=name,
        times=times,
        certified=certified,
        changes=changes,
        residual=residual,
        first=first,
    )


def bench(
    platform: Platform,
    pair_sets: Sequence[Sequence[Dof]],
    *,
    names: Sequence[str] = SCENARIOS,
    passes: int = 3,
    engines: Engines = ENGINES,
    peers: Engines | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> list[tuple[Timing, dict[str, Any]]]:
    """Time every engine for every set of pairs and every form, relative to the dense engine.

    Parameters
    ----------
    engines : by name; must include "dense".
    peers : by name. They handle hard rows only, and their adapters build a solver for every call. So they
        check the answers of every `SPARSE`-th problem of the full form, and their times measure the adapters.
    """
    done = []
    for pairs, (form, settings) in product(pair_sets, FORMS.items()):
        what = f"{form} form, {','.join(pair.name for pair in pairs)}"
        progress(f"recording, {what}")
        problem, steps = record(platform, pairs, names, settings)
        timings = []
        for name, make in engines.items():
            progress(f"{name} on {len(steps)} problems, {what}")
            timings.append(replay(name, make, problem, steps, passes=passes))
        reference = next(timing for timing in timings if timing.engine == "dense")
        done += [(timing, timing.account(reference)) for timing in timings]
        sparse = reference.every(SPARSE)
        for name, make in (peers or {}).items() if form == "full" else ():
            progress(f"{name} on {len(sparse.times)} problems, {what}")
            timing = replay(name, make, problem, steps[::SPARSE], passes=1)
            done.append((timing, timing.account(sparse)))
    return done


def installed_peers(report: Callable[[str], None]) -> Engines:
    """Return the installed engines of other projects by name; `report` is called for missing ones."""
    found: Engines = {}
    for name in ("casadi-hpipm", "casadi-qpoases"):
        try:
            found[name] = SOLVERS[name].load()
        except MissingExtra as missing:
            report(f"without {name}: {missing}")
    return found
