"""A law of only those regions that trajectories visit; it grows as new ones are met.

The notation is that of `lookup`. The law remembers active sets, and for each the sets that followed it. At a
new parameter it tries the last set and its followers, the latest first. A set is accepted only if the
optimality conditions hold with it. If none is accepted, the QP is solved and its set remembered. So every
answer is correct, and only its cost depends on what has been seen.
"""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_entry
from otolith.mpqp.law import Evaluation
from otolith.mpqp.leastdistance import LeastDistance, least_distance
from otolith.mpqp.lookup import (
    OPTIMAL,
    Answers,
    answers,
    certify,
    evaluate,
    scale,
    scratch,
    write,
)
from otolith.mpqp.packed import Packed, opened, pack, plain
from otolith.mpqp.problem import ParametricQp
from otolith.mpqp.prune import prune
from otolith.mpqp.region import inside_domain
from otolith.mpqp.sets import SetTable, enter, grown, set_table


@dataclass(frozen=True, slots=True)
class HitRate:
    """How often a partial law could answer without solving a QP."""

    asked: int  # number of feasible parameters asked for
    predicted: int  # answered by a remembered set, without solving a QP
    known: int  # of those solved, how many had a set that was already remembered

    @property
    def predicted_share(self) -> float:
        """Share of the answers found without a QP."""
        return self.predicted / max(1, self.asked)

    @property
    def known_share(self) -> float:
        """Share of the answers whose region the law already contained, predicted or not."""
        return (self.predicted + self.known) / max(1, self.asked)


class PartialLaw:
    """Explicit law of the regions met so far; at most `tries` sets are tried before the QP is solved.

    An object must not be used by several threads at once.

    Parameters
    ----------
    pruned : set to True if every constraint is known to bind somewhere. The search for redundant constraints,
        which takes most of the time of making a law, is then skipped.
    """

    def __init__(self, problem: ParametricQp, *, tries: int = 8, pruned: bool = False) -> None:
        self.problem = problem
        form = least_distance(problem)
        self._form = (form if pruned else prune(form).form).unsymmetric()
        f, m = self._form, self._form.sizes[0]
        self._sets: SetTable = set_table(m, np.array(f.mirror))
        self._packed = _without_facets(f, self._sets)
        self._followers: list[list[int]] = []
        self._tries = tries
        self._asked = self._predicted = self._known = 0

    def __len__(self) -> int:
        """Number of regions remembered."""
        return int(self._sets.used[0])

    @property
    def hit_rate(self) -> HitRate:
        """How often the law knew the answer since it was made, or since `forget_hits`."""
        return HitRate(self._asked, self._predicted, self._known)

    def forget_hits(self) -> None:
        """Reset the hit rate, for instance after training."""
        self._asked = self._predicted = self._known = 0

    def learn(self, thetas: Mat) -> None:
        """Remember the regions that a trajectory (N, p) visits."""
        region = -1
        for theta in thetas:
            region = self.evaluate(theta, region).region

    def evaluate(self, theta: Vec, start: int = -1) -> Evaluation:
        """Return the minimiser at `theta` (p,); `start` is the region of the last answer. A miss adds a
        region.

        `region` is the number of the remembered set, in the order in which sets were met.
        """
        answer = answers(1, len(self.problem.f))
        point, block = np.array(theta, dtype=np.float64), self._packed.block
        tried = np.array([start, *self._followers[start]] if start >= 0 else [], dtype=np.int64)
        region = int(try_sets(block, tried, point, answer.reals, answer.ints))
        if region < 0:
            evaluate(block, point, -1, answer.reals, answer.ints)
            if answer.size[0] < 0:
                return Evaluation(answer.z[0], int(answer.region[0]), tried[:0], answer.lam[0, :0], False)
            region = self._remember(answer)
        else:
            self._predicted += 1
        self._asked += 1
        self._follow(start, region)
        A, lam = answer.A[0, : answer.size[0]], answer.lam[0, : answer.size[0]]
        return Evaluation(answer.z[0], region, self._form.rows[A], self._form.weights[A] * lam, True)

    def _remember(self, answer: Answers) -> int:
        """Return the number of the set that the QP just found; a new set is added."""
        before = len(self)
        larger = grown(self._sets, before + 2)
        if larger is not self._sets:
            self._sets = larger
            self._packed = _without_facets(self._form, larger)
        code = int(enter(self._sets, answer.A[0], answer.size[0]))
        if len(self) > before:
            self._followers.append([])
        else:
            self._known += 1
        return code >> 1

    def _follow(self, start: int, region: int) -> None:
        """Record that `region` came after `start`, so that it is tried first next time."""
        if start < 0 or start == region:
            return
        followers = [region, *(r for r in self._followers[start] if r != region)]
        self._followers[start] = followers[: self._tries]


def _without_facets(form: LeastDistance, sets: SetTable) -> Packed:
    """Tables with room for all sets of `sets`; they share its keys, but do not find a set by its rows."""
    none, unlisted = np.zeros(0, dtype=np.int32), np.full(1, -1, dtype=np.int32)
    return pack(
        form, sets._replace(slots=unlisted), np.zeros(len(sets.keys) + 1, dtype=np.int32),
        np.zeros((0, len(form.half) + 1), dtype=np.float32), none, 0, plain(form, form.centre, form.half),
    )  # fmt: skip


@jit_entry
def try_sets(block: Ints, tried: Ints, theta: Vec, reals: Vec, ints: Ints) -> int:
    """Return the first of the sets `tried` that is optimal at θ, and write its answer; -1 when none is."""
    tables = opened(block)
    w = scratch(block, tables)
    if not scale(tables, theta, w.tau) or not inside_domain(tables.form.fixed, w.tau):
        return -1
    for r in tried:
        k, violation = certify(tables, r, w)
        if violation <= OPTIMAL:
            write(tables, w, r, k, reals, ints)
            return int(r)
    return -1
