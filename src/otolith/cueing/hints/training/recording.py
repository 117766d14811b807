"""Closed loops recorded as problems and solutions, to which hints are fitted and on which they are judged."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.frames import Dof
from otolith.core.jobs import Workers
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.settings import MpcSettings
from otolith.loop import simulate
from otolith.plant import Ideal
from otolith.platforms import Platform
from otolith.qp import Status
from otolith.qp.blocked import Lengths
from otolith.qp.engines import StageEngine, StructuredEngine
from otolith.qp.stage import OnRequest, StageProblem, StageSolution
from otolith.scenarios import Scenario

SHARES: Final = 4  # of the work for each process: few, as each makes its controller anew


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """The decisions of several consecutive runs, n in all."""

    x: Mat  # (n, 6P) states
    wanted: Mat  # (n, P) forces of the first step
    ahead: NDArray[np.float64]  # (n, N, P) forces over the horizon, as predicted; (n, 0, 0) if not kept
    plan: NDArray[np.float64]  # (n, N, 2P) about which the problem was linearised; (n, 0, 0) if not kept
    sets: NDArray[np.int8]  # (n, M, rows) optimal working sets
    first: Mat  # (n, 2P) optimal first inputs
    solved: Bools  # (n,)
    begins: Bools  # (n,) whether it is the first decision of a run

    def __len__(self) -> int:
        return len(self.x)

    def changed(self, rows: Bools) -> Bools:
        """Return (n,) where the set of these rows of the horizon differs from that of the previous decision.

        First decisions count as changed.

        Parameters
        ----------
        rows : (M·rows,) which rows are compared.
        """
        sets = self.sets.reshape(len(self.sets), -1)[:, rows]
        changed: Bools = self.begins.copy()
        changed[1:] |= (sets[1:] != sets[:-1]).any(axis=1)
        return changed


class _Witness:
    """An engine and a hint that records every problem and every solution without changing them."""

    engine: StageEngine

    def __init__(self, *, plans: bool) -> None:
        self._plans = plans
        self.ahead: Mat = np.empty((0, 0))  # (N, P) forces over the horizon, which the controller writes
        self.questions: list[tuple[Vec, Vec, Mat, Mat]] = []
        self.answers: list[tuple[NDArray[np.int8], Vec, bool]] = []

    def __call__(self, problem: StageProblem, *, tolerance: float, blocks: Lengths = ()) -> "_Witness":
        self.engine = StructuredEngine(problem, tolerance=tolerance, blocks=blocks)
        self.memory = self.engine.memory
        return self

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Record the problem."""
        kept = slice(None if self._plans else 0)
        ahead, about = self.ahead[kept, kept].copy(), plan[kept, kept].copy()
        self.questions.append((x.copy(), wanted.copy(), ahead, about))
        return None

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Record the solution, and the problem even if the engine would not request a hint."""
        if hint is not None:
            hint()
        solution = self.engine.run(start)
        solved = solution.status is Status.OPTIMAL
        self.answers.append((solution.working_set.astype(np.int8), solution.U[0].copy(), solved))
        return solution

    def forget(self) -> None:
        """Discard the records."""
        self.questions.clear()
        self.answers.clear()

    def reset(self) -> None:
        """Begin a new run, before its first decision."""
        self.engine.reset()


def record(
    platform: Platform,
    pairs: Sequence[Dof],
    settings: MpcSettings,
    scenarios: Sequence[Scenario],
    *,
    plans: bool = False,
    jobs: int = 1,
    progress: Callable[[float], None] = lambda _: None,
) -> Recording:
    """Simulate the scenarios with one Gauss-Newton step per period, on the plant of the model.

    Parameters
    ----------
    plans : whether plans and predictions are kept, without which the problems cannot be written again.
    jobs : number of processes that share the scenarios; the result is the same.
    """
    witnessed = Witnessed(platform, tuple(pairs), settings, tuple(scenarios), plans)
    if jobs > 1:
        witnessed.cueing()  # compiles what is missing, once for all processes
    lengths = [scenario.duration for scenario in scenarios]
    edges = np.linspace(0.0, sum(lengths), len(scenarios) if jobs < 2 else SHARES * jobs)
    share = np.searchsorted(edges, np.cumsum(lengths) - 0.5 * np.array(lengths))
    parts = [np.flatnonzero(share == k).tolist() for k in np.unique(share)]
    ran = 0

    def done(part: list[int]) -> None:
        nonlocal ran
        ran += len(part)
        progress(ran / len(scenarios))

    with Workers(jobs, witnessed) as workers:
        found = workers.each(_recorded, parts, done)
    return Recording(
        **{one.name: np.concatenate([getattr(part, one.name) for part in found]) for one in fields(Recording)}
    )


@dataclass(frozen=True)
class Witnessed:
    """What is recorded: scenarios, and the controller that cues them."""

    platform: Platform
    pairs: tuple[Dof, ...]
    settings: MpcSettings
    scenarios: tuple[Scenario, ...]
    plans: bool

    def cueing(self) -> tuple[Mpc, _Witness]:
        """Return the controller and what records it."""
        witness = _Witness(plans=self.plans)
        watched = replace(self.settings, iterations=1, engine=witness)
        cueing = Mpc(self.platform, self.pairs, watched, hint=witness)
        witness.ahead = cueing.program.wanted
        witness.forget()  # discard the problem that only served to compile
        return cueing, witness


def _recorded(of: Witnessed, numbers: Sequence[int]) -> Recording:
    """Record some of the scenarios, by number."""
    cueing, witness = of.cueing()
    names = tuple(pair.name for pair in of.pairs)
    begins = []
    for number in numbers:
        begins.append(len(witness.questions))
        simulate(
            cueing,
            Ideal(),
            of.scenarios[number],
            platform=of.platform,
            dofs=names,
            plant_period=of.settings.period,
        )
    x, wanted, ahead, plan = (np.array(column) for column in zip(*witness.questions, strict=True))
    sets, first, solved = (np.array(column) for column in zip(*witness.answers, strict=True))
    starts = np.zeros(len(x), dtype=np.bool_)
    starts[begins] = True
    return Recording(
        x=x, wanted=wanted, ahead=ahead, plan=plan, sets=sets, first=first, solved=solved, begins=starts
    )
