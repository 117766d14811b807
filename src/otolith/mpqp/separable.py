"""Separable problems: find independent sub-problems from the data and solve them one by one.

Notation: variables are the nodes of a graph; H joins two of them, and every constraint joins those it
involves. The connected components are the parts. A parameter that several parts read belongs to each of them:
their minimisers are still independent.

The regions of the whole problem are products of the parts' regions: n1·n2·… of them, never stored (fewer when
parts share parameters, since some products are then empty).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
import scipy  # scipy imports its modules on first use, so a caller waits only for those it needs

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.mpqp.enumerate import Report, enumerate_regions
from otolith.mpqp.law import Evaluation, Evaluations, Law
from otolith.mpqp.problem import ParametricQp, unit_curvature

_ABSENT = 1e-12  # an entry below this part of the largest entry that it is compared with counts as zero


@dataclass(frozen=True, slots=True)
class Part:
    """An independent sub-problem and its place in the whole problem."""

    problem: ParametricQp
    variables: Ints  # (n',) of the whole
    parameters: Ints  # (p',) of the whole
    constraints: Ints  # (m',) of the whole


def separate(problem: ParametricQp) -> list[Part]:
    """Find the independent parts of a problem, in the order of their first variable; one if it is not
    separable.
    """
    n = len(problem.f)
    hold_z, hold_theta = _holding(problem)
    unit = unit_curvature(problem.H)
    links = np.vstack([_present(problem.H * np.outer(unit, unit)), hold_z])
    bare = hold_theta & ~hold_z.any(axis=1, keepdims=True)
    if bare.any():  # constraints on parameters alone join all variables that read these parameters
        links = np.vstack([links, np.asarray(bare[bare.any(axis=1)].astype(int) @ _readers(problem).T) > 0])
    rows, columns = np.nonzero(links)
    graph = scipy.sparse.coo_array((np.ones(len(rows)), (rows + n, columns)), shape=(n + len(links),) * 2)
    count, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    groups = [np.flatnonzero(label[:n] == c) for c in range(count)]
    ordered = sorted((g for g in groups if len(g)), key=lambda g: int(g[0]))
    return [_part(problem, group) for group in ordered]


def _present(A: Mat) -> Bools:
    """Mark the entries that are not negligible relative to the largest."""
    size = np.abs(A)
    return np.asarray(size > _ABSENT * size.max(initial=0.0), dtype=np.bool_)


def _holding(problem: ParametricQp) -> tuple[Bools, Bools]:
    """Mark the variables (m, n) and parameters (m, p) that every constraint involves, whatever its scale."""
    half = (problem.upper - problem.lower) / 2
    by_z, by_theta = np.abs(problem.G) * unit_curvature(problem.H), np.abs(problem.S) * half
    level = np.maximum(by_theta.max(axis=1, initial=0.0), np.abs(problem.w))[:, None]
    return by_z > _ABSENT * by_z.max(axis=1, keepdims=True, initial=0.0), by_theta > _ABSENT * level


def _readers(problem: ParametricQp) -> Bools:
    """Mark the variables (n, p) that read a parameter, by the cost or by a constraint."""
    hold_z, hold_theta = _holding(problem)
    half = (problem.upper - problem.lower) / 2
    by_cost = _present(problem.F * np.outer(unit_curvature(problem.H), half))
    return np.asarray(by_cost | (hold_z.astype(int).T @ hold_theta.astype(int) > 0), dtype=np.bool_)


def _part(problem: ParametricQp, variables: Ints) -> Part:
    """Make the sub-problem of some variables, with every constraint and parameter that concerns them."""
    parameters = np.flatnonzero(_readers(problem)[variables].any(axis=0))
    if len(parameters) == 0:
        parameters = np.array([0])
    hold_z, hold_theta = _holding(problem)
    bare = ~hold_z.any(axis=1) & hold_theta[:, parameters].any(axis=1)
    constraints = np.flatnonzero(hold_z[:, variables].any(axis=1) | bare)
    v, q, c = variables, parameters, constraints
    return Part(
        ParametricQp(
            H=problem.H[np.ix_(v, v)], F=problem.F[np.ix_(v, q)], f=problem.f[v],
            G=problem.G[np.ix_(c, v)], w=problem.w[c], S=problem.S[np.ix_(c, q)],
            lower=problem.lower[q], upper=problem.upper[q],
        ),
        v, q, c,
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class JointLaw:
    """The law of a separable problem, made of the laws of its parts."""

    problem: ParametricQp
    parts: tuple[Part, ...]
    laws: tuple[Law, ...]

    def __len__(self) -> int:
        """Number of regions of the joint problem: the product of the parts' counts."""
        return reduce(lambda product, law: product * len(law), self.laws, 1)

    @property
    def counts(self) -> tuple[int, ...]:
        """Number of regions of each part; only these are stored."""
        return tuple(len(law) for law in self.laws)

    @property
    def nbytes(self) -> int:
        """Memory of the stored regions of all parts [bytes]."""
        return sum(law.nbytes for law in self.laws)

    def region_of(self, regions: Sequence[int]) -> int:
        """Convert the parts' region ids to a joint region id; the last part's id counts fastest."""
        return reduce(
            lambda joint, pair: joint * pair[1] + pair[0], zip(regions, self.counts, strict=True), 0
        )

    def regions_in(self, region: int) -> tuple[int, ...]:
        """Convert a joint region id to the parts' region ids; -1 for each when `region` is negative."""
        ids: list[int] = []
        for count in reversed(self.counts):
            ids.append(region % count if region >= 0 else -1)
            region = region // count if region >= 0 else region
        return tuple(reversed(ids))

    def evaluate(self, theta: Vec, start: int = -1) -> Evaluation:
        """Evaluate as `Law.evaluate` does, part by part. A negative region is that of the first part
        without one.
        """
        starts = self.regions_in(start)
        answers = [
            law.evaluate(theta[part.parameters], s)
            for law, part, s in zip(self.laws, self.parts, starts, strict=True)
        ]
        found = all(a.found for a in answers) and self._within(theta)
        z = np.full(len(self.problem.f), np.nan)
        if not found:
            none = np.empty(0, dtype=np.int64)
            return Evaluation(z, min(-2, *(a.region for a in answers)), none, np.empty(0), False)
        for answer, part in zip(answers, self.parts, strict=True):
            z[part.variables] = answer.z
        regions = [a.region for a in answers]
        active = np.concatenate([p.constraints[a.active] for a, p in zip(answers, self.parts, strict=True)])
        multipliers = np.concatenate([a.multipliers for a in answers])
        return Evaluation(z, self.region_of(regions) if min(regions) >= 0 else -1, active, multipliers, True)

    def evaluate_many(self, thetas: Mat) -> Evaluations:
        """Evaluate at parameters (N, p) as `Law.evaluate_many` does, part by part."""
        z = np.full((len(thetas), len(self.problem.f)), np.nan)
        found = np.array([self._within(theta) for theta in thetas], dtype=np.bool_)
        region = np.zeros(len(thetas), dtype=np.int64)
        hit = found.copy()
        for law, part in zip(self.laws, self.parts, strict=True):
            answers = law.evaluate_many(thetas[:, part.parameters])
            z[:, part.variables] = answers.z
            found &= answers.found
            hit &= answers.region >= 0
            region = region * len(law) + answers.region
        z[~found] = np.nan
        return Evaluations(z, np.where(hit, region, np.where(found, -1, -2)), found)

    def _within(self, theta: Vec) -> bool:
        """True when `theta` lies in the whole problem's box; parts check only the parameters that they
        read.
        """
        slop = 1e-8 * (self.problem.upper - self.problem.lower)
        return bool(((theta >= self.problem.lower - slop) & (theta <= self.problem.upper + slop)).all())


def enumerate_parts(
    problem: ParametricQp,
    *,
    tolerance: float = 1e-7,
    progress: Report | None = None,
    workers: int | None = None,
) -> JointLaw:
    """Separate a problem and enumerate every part; arguments and errors are those of `enumerate_regions`."""
    parts = tuple(separate(problem))
    laws = tuple(
        enumerate_regions(part.problem, tolerance=tolerance, progress=progress, workers=workers)
        for part in parts
    )
    return JointLaw(problem, parts, laws)
