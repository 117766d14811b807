"""Enumerate every full-dimensional region of a parametric QP.

Method: start where the problem is feasible, cross every facet of every region found (breadth first), then
test random parameters until a whole round finds nothing new. When the problem is centrally symmetric, only
one region of each mirror pair is examined. See `expand`, `region`.

Where several active sets give the same solution throughout a region (more constraints bind than there are
independent ones) only one of them is counted, see `dualqp`: regions never overlap.

The count depends on the tolerance: a set is a region when the largest ball in it, with the parameter box
scaled to [-1, 1]^p, has at least that radius.

Limit: rows whose distance from the span of the active ones is below 1e-5 (`dualqp.DEPENDENT`, squared) count
as dependent. Very fine discretisations have many of these: with N = 50, Ts = 0.01 s and two blocks a few of
70,721 regions are missed and answers have errors of up to 1e-7, which `verify` reports.

Memory: 8·(words + 4) bytes per active set found and about 12 facets of 4·(p + 2) + 2 bytes per region, all
doubled while buffers grow.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Mat, Vec
from otolith.mpqp.assemble import assemble
from otolith.mpqp.expand import NOWHERE, UNKNOWN, Found, Ints32, expand_many, found_memory, insert_many
from otolith.mpqp.law import Law
from otolith.mpqp.leastdistance import LeastDistance, least_distance
from otolith.mpqp.lookup import UNSOLVED, answers, evaluate
from otolith.mpqp.packed import Packed, pack, plain
from otolith.mpqp.problem import NoRegions, ParametricQp
from otolith.mpqp.prune import flat_directions, prune
from otolith.mpqp.region import Form, Work, kernel_form, work_memory
from otolith.mpqp.sets import SetTable, grown, set_table

T = TypeVar("T", bound=np.generic)
_BATCH = 2000  # sets examined between two checks of the clock and the keyboard
_SEEDS = 2000  # random parameters per round
_ROUNDS = 50


@dataclass(frozen=True, slots=True)
class Progress:
    """The progress of an enumeration."""

    regions: int  # regions found so far, mirror images included
    open: int  # active sets waiting to be examined
    seconds: float  # [s] since the start


Report = Callable[[Progress], None]


def enumerate_regions(
    problem: ParametricQp,
    *,
    tolerance: float = 1e-7,
    progress: Report | None = None,
    symmetry: bool = True,
) -> Law:
    """Compute the explicit solution of `problem`: all regions whose scaled Chebyshev radius reaches
    `tolerance`.

    `progress` is called between batches; an exception or KeyboardInterrupt ends the work and leaves nothing
    behind. `symmetry=False` ignores central symmetry (the law is the same).

    Raises
    ------
    NoRegions : the problem is infeasible, or feasible only on a flat set of parameters.
    """
    compile_seconds = _compile()
    start = time.perf_counter()
    pruned = prune(least_distance(problem))
    form = pruned.form if symmetry else pruned.form.unsymmetric()
    search = _Search(form, tolerance)
    search.run(pruned.inside, lambda regions, waiting: _report(progress, regions, waiting, start))
    if search.found.used[0] == 0:
        raise NoRegions(_why_flat(form))
    return assemble(
        problem, form, search.table, search.found, tolerance=tolerance,
        seconds=time.perf_counter() - start, compile_seconds=compile_seconds,
    )  # fmt: skip


def _why_flat(form: LeastDistance) -> str:
    """Explain in one sentence why a problem has no full-dimensional region."""
    fixed = flat_directions(form)
    if len(fixed) == 0:
        return "the feasible parameters form a flat set; substitute the equations that hold between them"
    names = ", ".join(str(i) for i in fixed)
    return f"the feasible set leaves no room for parameter {names}; fix it and leave it out"


def _report(progress: Report | None, regions: int, waiting: int, start: float) -> None:
    if progress is not None:
        progress(Progress(regions, waiting, time.perf_counter() - start))


class _Search:
    """The growing memory of one enumeration."""

    def __init__(self, form: LeastDistance, tolerance: float) -> None:
        self.form: Form = kernel_form(form)
        self.work: Work = work_memory(self.form)
        m, _, p = form.sizes
        self.table: SetTable = set_table(m, np.array(form.mirror))
        self.found: Found = found_memory(p, 1 << 10, 1 << 14)
        self.oracle = _oracle(form)
        self.refused = np.zeros(8, dtype=np.int64)
        self.unsolved = 0
        self.tolerance, self.p = tolerance, p
        self.images = 2 if len(form.mirror) else 1
        self.examined = np.zeros(2, dtype=np.int64)  # next set to examine, end of the batch

    def run(self, inside: Vec, progress: Callable[[int, int], None]) -> None:
        """Seed and expand until a round of random parameters finds no new set."""
        rng = np.random.default_rng(0)
        points = np.vstack([inside, np.zeros(self.p), rng.uniform(-1, 1, (20, self.p))])
        for _ in range(_ROUNDS):
            before = int(self.table.used[0])
            self._solve(points)
            if self.table.used[0] == before:
                return
            self._expand_all(progress)
            points = rng.uniform(-1, 1, (_SEEDS, self.p))

    def _solve(self, points: Mat) -> Ints32:
        """Solve the QP at τ (N, p) and enter its optimal sets; return their codes, or NOWHERE, or UNKNOWN."""
        self.table = grown(self.table, int(self.table.used[0]) + len(points))
        found = answers(len(points), self.form.n)
        evaluate(self.oracle, points, -1, found)
        self.unsolved += int((found.region == UNSOLVED).sum())
        codes = np.where(found.region == UNSOLVED, UNKNOWN, NOWHERE).astype(np.int32)
        insert_many(self.table, np.ascontiguousarray(found.A), np.ascontiguousarray(found.size), codes)
        return codes

    def _expand_all(self, progress: Callable[[int, int], None]) -> None:
        while self.examined[0] < self.table.used[0]:
            self.examined[1] = self.examined[0] + _BATCH
            self._make_room()
            expand_many(
                self.form, self.work, self.table, self.found, self.examined, self.tolerance, self.refused
            )
            self._settle()
            progress(self.images * int(self.found.used[0]), int(self.table.used[0] - self.examined[0]))

    def _settle(self) -> None:
        """Solve the QPs that the last batch postponed, and record what lies beyond those facets."""
        waiting = int(self.found.used[2])
        points = np.clip(self.found.point[:waiting], -1.0, 1.0)
        self.found.beyond[self.found.facet[:waiting]] = self._solve(points)
        self.found.used[2] = 0

    def _make_room(self) -> None:
        rows = len(self.work.ids)
        self.table = grown(self.table, int(self.table.used[0]) + 2 * rows * (self.form.n + 2))
        self.found = _grown(self.found, 2 * rows)


def _oracle(form: LeastDistance) -> Packed:
    """Make a law without regions: evaluating it, in τ, always solves the QP."""
    m, _, p = form.sizes
    none = np.zeros(0, dtype=np.int32)
    return pack(
        form, set_table(m, np.array(form.mirror)), np.zeros(1, dtype=np.int32),
        np.zeros((0, p + 1), dtype=np.float32), none, 0, plain(form, np.zeros(p), np.ones(p)),
    )  # fmt: skip


def _grown(found: Found, facets: int) -> Found:
    """Copy the regions into arrays with room for more."""
    regions, used = int(found.used[0]), int(found.used[1])
    if regions + 2 >= len(found.radius):
        found = found._replace(
            owner=_doubled(found.owner), centre=_doubled(found.centre),
            radius=_doubled(found.radius), start=_doubled(found.start),
        )  # fmt: skip
    if used + facets > len(found.beyond):
        found = found._replace(
            rows=_doubled(found.rows, facets), constraint=_doubled(found.constraint, facets),
            beyond=_doubled(found.beyond, facets), point=_doubled(found.point, facets),
            facet=_doubled(found.facet, facets),
        )  # fmt: skip
    return found


def _doubled(array: NDArray[T], extra: int = 1) -> NDArray[T]:
    larger = np.zeros((2 * len(array) + extra, *array.shape[1:]), dtype=array.dtype)
    larger[: len(array)] = array
    return larger


def _compile() -> float:
    """Compile the engine, or load it from the cache; return the time this took [s]."""
    start = time.perf_counter()
    one = np.ones((1, 1))
    tiny = ParametricQp(
        H=one, F=-one, f=np.zeros(1), G=np.vstack([one, -one]), w=np.ones(2), S=np.zeros((2, 1)),
        lower=np.array([-2.0]), upper=np.array([2.0]),
    )  # fmt: skip
    form = prune(least_distance(tiny)).form
    search = _Search(form, 1e-7)
    search.run(np.zeros(1), lambda *_: None)
    law = assemble(tiny, form, search.table, search.found, tolerance=1e-7, seconds=0.0, compile_seconds=0.0)
    law.evaluate(law.evaluate_many(np.zeros((2, 1))).z[0])
    return time.perf_counter() - start
