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

Several threads examine sets at the same time, a few hundred each, and hand over what they have found; what is
found about a set does not depend on when and by whom it is examined. The regions are sorted by their active
sets in the end, so the law is the same, bit for bit, for any number of threads.

Memory: per active set 8·words bytes and 16 bytes of index, both doubled while the table grows; per region
8·(p + 1) + 8 bytes, and 6 per facet. The half-spaces are computed at the end, where they are stored.
"""

import os
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.mpqp.assemble import Regions, assemble, half_spaces
from otolith.mpqp.bench import CHUNK, Batch, Bench, Block
from otolith.mpqp.expand import merge, seed_many
from otolith.mpqp.law import Law
from otolith.mpqp.leastdistance import LeastDistance, least_distance
from otolith.mpqp.problem import NoRegions, ParametricQp
from otolith.mpqp.prune import flat_directions, prune
from otolith.mpqp.region import Form, kernel_form
from otolith.mpqp.sets import SetTable, Words, grown, set_table

_AHEAD: Final = 2  # chunks per thread that are handed out in advance
_SEEDS: Final = 2000  # random parameters per round
_ROUNDS: Final = 50


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
    workers: int | None = None,
) -> Law:
    """Compute the explicit solution of `problem`: all regions whose scaled Chebyshev radius reaches
    `tolerance`.

    `progress` is called between batches; an exception or KeyboardInterrupt ends the work and leaves nothing
    behind. `symmetry=False` ignores central symmetry (the law is the same). `workers` is the number of
    threads, by default the number of processors that this process may use; the law does not depend on it.

    Raises
    ------
    NoRegions : the problem is infeasible, or feasible only on a flat set of parameters.
    InputError : `workers` is less than 1.
    """
    threads = processors() if workers is None else workers
    if threads < 1:
        raise InputError("workers", threads, "at least 1")
    compile_seconds = _compile()
    start = time.perf_counter()

    def report(regions: int, waiting: int) -> None:
        if progress is not None:
            progress(Progress(regions, waiting, time.perf_counter() - start))

    pruned = prune(least_distance(problem))
    form = pruned.form if symmetry else pruned.form.unsymmetric()
    regions = _found(form, pruned.inside, tolerance, threads, report)
    if len(regions.radius) == 0:
        raise NoRegions(_why_flat(form))
    rows = half_spaces(form, regions)
    return Law(
        problem=problem, form=form, rows=rows, tolerance=tolerance, seconds=time.perf_counter() - start,
        compile_seconds=compile_seconds, **regions._asdict(),
    )  # fmt: skip


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _why_flat(form: LeastDistance) -> str:
    """Explain in one sentence why a problem has no full-dimensional region."""
    fixed = flat_directions(form)
    if len(fixed) == 0:
        return "the feasible parameters form a flat set; substitute the equations that hold between them"
    names = ", ".join(str(i) for i in fixed)
    return f"the feasible set leaves no room for parameter {names}; fix it and leave it out"


def _found(
    form: LeastDistance, inside: Vec, tolerance: float, threads: int, report: Callable[[int, int], None]
) -> Regions:
    """Find all regions and sort them; the memory of the search is free afterwards."""
    with _Search(form, tolerance, threads) as search:
        search.run(inside, report)
    return assemble(form, search.table, search.blocks)


class _Search:
    """The active sets and regions found so far, and the threads that look for more."""

    def __init__(self, form: LeastDistance, tolerance: float, threads: int) -> None:
        self.form, self.tolerance, self.threads = form, tolerance, threads
        self.kernel: Form = kernel_form(form)
        self.table: SetTable = set_table(len(form.rows), np.array(form.mirror))
        self.blocks: list[Block] = []
        self.examined = 0  # sets, in the order of the table
        self._idle = deque(Bench(form, self.kernel) for _ in range(threads))
        self._pool = ThreadPoolExecutor(threads)

    def __enter__(self) -> "_Search":
        return self

    def __exit__(self, *_: object) -> None:
        self._pool.shutdown(cancel_futures=True)

    @property
    def regions(self) -> int:
        """Number of regions found, mirror images included."""
        return (2 if len(self.form.mirror) else 1) * sum(len(block.radius) for block in self.blocks)

    @property
    def waiting(self) -> int:
        """Number of sets found that have not been examined."""
        return int(self.table.used[0]) - self.examined

    def run(self, inside: Vec, progress: Callable[[int, int], None]) -> None:
        """Seed and expand until a round of random parameters finds no new set."""
        rng, p = np.random.default_rng(0), len(self.form.half)
        points = np.vstack([inside, np.zeros(p), rng.uniform(-1, 1, (20, p))])
        for _ in range(_ROUNDS):
            self._seed(points)
            if self.waiting == 0:
                return
            self._expand_all(progress)
            points = rng.uniform(-1, 1, (_SEEDS, p))

    def _seed(self, points: Mat) -> None:
        """Solve the QP at τ (N, p) and enter its optimal sets."""
        self.table = grown(self.table, int(self.table.used[0]) + len(points))
        seed_many(self.kernel, self._idle[0].work, self.table, points)

    def _expand_all(self, progress: Callable[[int, int], None]) -> None:
        """Let the threads examine sets until none is left; enter what they find in the order of the sets."""
        jobs: deque[Future[Batch]] = deque()
        given = self.examined
        while self.waiting:
            for _ in range(_AHEAD * self.threads - len(jobs)):
                keys = self._some(given)
                if len(keys):
                    jobs.append(self._pool.submit(self._examine, keys))
                    given += len(keys)
            self._enter(jobs.popleft().result())
            progress(self.regions, self.waiting)

    def _some(self, given: int) -> Words:
        """Copy the next sets to be examined; few when few are left, so that every thread has some."""
        left = int(self.table.used[0]) - given
        share = -(-left // (_AHEAD * self.threads))
        return self.table.keys[given : given + min(CHUNK, share)].copy()

    def _examine(self, keys: Words) -> Batch:
        bench = self._idle.pop()
        try:
            return bench.examine(keys, self.tolerance)
        finally:
            self._idle.append(bench)

    def _enter(self, batch: Batch) -> None:
        """Enter what a thread has found about the sets that come next."""
        self.table = grown(self.table, int(self.table.used[0]) + len(batch.sets))
        merge(self.table, batch.sets, np.empty(len(batch.sets), dtype=np.int32), batch.block.beyond)
        self.blocks.append(batch.block._replace(owner=batch.block.owner + np.int32(self.examined)))
        self.examined += batch.examined


def _compile() -> float:
    """Compile the engine, or load it from the cache; return the time this took [s]."""
    start = time.perf_counter()
    one = np.ones((1, 1))
    tiny = ParametricQp(
        H=one, F=-one, f=np.zeros(1), G=np.vstack([one, -one]), w=np.ones(2), S=np.zeros((2, 1)),
        lower=np.array([-2.0]), upper=np.array([2.0]),
    )  # fmt: skip
    pruned = prune(least_distance(tiny))
    regions = _found(pruned.form, pruned.inside, 1e-7, 1, lambda *_: None)
    law = Law(
        problem=tiny, form=pruned.form, rows=half_spaces(pruned.form, regions), tolerance=1e-7,
        **regions._asdict(),
    )  # fmt: skip
    law.evaluate(law.evaluate_many(np.zeros((2, 1))).z[0])
    return time.perf_counter() - start
