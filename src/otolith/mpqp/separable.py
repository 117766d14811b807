"""Problems that fall apart: independent sub-problems are found from the data and solved one by one.

Notation: variables are the nodes of a graph; H joins two of them, and every constraint those it holds.
The connected components are the parts. A parameter that several parts read goes to each of them:
their minimisers are still found apart.

The regions of the whole are products of the parts' regions: n1·n2·… of them, never stored (fewer when
parts share parameters: then some products are empty).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
import scipy  # its modules are imported on first use: none waits for one that it does not need

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.mpqp.enumerate import Report, enumerate_regions
from otolith.mpqp.law import Evaluation, Evaluations, Law
from otolith.mpqp.problem import ParametricQp, unit_curvature

_ABSENT = 1e-12  # entry, relative to the largest that it is compared with, that counts as zero


@dataclass(frozen=True, slots=True)
class Part:
    """An independent sub-problem and where it stands in the whole."""

    problem: ParametricQp
    variables: Ints  # (n',) of the whole
    parameters: Ints  # (p',) of the whole
    constraints: Ints  # (m',) of the whole


def separate(problem: ParametricQp) -> list[Part]:
    """The independent parts of a problem, in the order of their first variable; one when it is whole."""
    n = len(problem.f)
    hold_z, hold_theta = _holding(problem)
    unit = unit_curvature(problem.H)
    links = np.vstack([_present(problem.H * np.outer(unit, unit)), hold_z])
    bare = hold_theta & ~hold_z.any(axis=1, keepdims=True)
    if bare.any():  # constraints on parameters alone join whatever reads these parameters
        links = np.vstack([links, np.asarray(bare[bare.any(axis=1)].astype(int) @ _readers(problem).T) > 0])
    rows, columns = np.nonzero(links)
    graph = scipy.sparse.coo_array((np.ones(len(rows)), (rows + n, columns)), shape=(n + len(links),) * 2)
    count, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    groups = [np.flatnonzero(label[:n] == c) for c in range(count)]
    ordered = sorted((g for g in groups if len(g)), key=lambda g: int(g[0]))
    return [_part(problem, group) for group in ordered]


def _present(A: Mat) -> Bools:
    """Which entries are not zero beside the largest."""
    size = np.abs(A)
    return np.asarray(size > _ABSENT * size.max(initial=0.0), dtype=np.bool_)


def _holding(problem: ParametricQp) -> tuple[Bools, Bools]:
    """Which variables (m, n) and parameters (m, p) every constraint holds, whatever it is multiplied by."""
    half = (problem.upper - problem.lower) / 2
    by_z, by_theta = np.abs(problem.G) * unit_curvature(problem.H), np.abs(problem.S) * half
    level = np.maximum(by_theta.max(axis=1, initial=0.0), np.abs(problem.w))[:, None]
    return by_z > _ABSENT * by_z.max(axis=1, keepdims=True, initial=0.0), by_theta > _ABSENT * level


def _readers(problem: ParametricQp) -> Bools:
    """Which variables (n, p) read a parameter, by the cost or by a constraint."""
    hold_z, hold_theta = _holding(problem)
    half = (problem.upper - problem.lower) / 2
    by_cost = _present(problem.F * np.outer(unit_curvature(problem.H), half))
    return np.asarray(by_cost | (hold_z.astype(int).T @ hold_theta.astype(int) > 0), dtype=np.bool_)


def _part(problem: ParametricQp, variables: Ints) -> Part:
    """The sub-problem of some variables, with every constraint and parameter that concerns them."""
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
    """The law of a problem as the laws of its parts."""

    problem: ParametricQp
    parts: tuple[Part, ...]
    laws: tuple[Law, ...]

    def __len__(self) -> int:
        """Regions of the joint problem: the product of the parts' counts."""
        return reduce(lambda product, law: product * len(law), self.laws, 1)

    @property
    def counts(self) -> tuple[int, ...]:
        """Regions of each part: what is stored."""
        return tuple(len(law) for law in self.laws)

    @property
    def nbytes(self) -> int:
        """Bytes of the stored regions of all parts."""
        return sum(law.nbytes for law in self.laws)

    def region_of(self, regions: Sequence[int]) -> int:
        """Joint region id of the parts' ids, the last part's counting fastest."""
        return reduce(
            lambda joint, pair: joint * pair[1] + pair[0], zip(regions, self.counts, strict=True), 0
        )

    def regions_in(self, region: int) -> tuple[int, ...]:
        """The parts' region ids of a joint id; -1 for each when `region` is negative."""
        ids: list[int] = []
        for count in reversed(self.counts):
            ids.append(region % count if region >= 0 else -1)
            region = region // count if region >= 0 else region
        return tuple(reversed(ids))

    def evaluate(self, theta: Vec, start: int = -1) -> Evaluation:
        """As `Law.evaluate`, from the parts. A negative region is that of the first part without one."""
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
        """As `Law.evaluate_many`, from the parts."""
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
        """Whether `theta` lies in the whole problem's box; parts check only the parameters they read."""
        slop = 1e-8 * (self.problem.upper - self.problem.lower)
        return bool(((theta >= self.problem.lower - slop) & (theta <= self.problem.upper + slop)).all())


def enumerate_parts(
    problem: ParametricQp, *, tolerance: float = 1e-7, progress: Report | None = None
) -> JointLaw:
    """Separate a problem and enumerate every part; errors as `enumerate_regions`."""
    parts = tuple(separate(problem))
    laws = tuple(enumerate_regions(part.problem, tolerance=tolerance, progress=progress) for part in parts)
    return JointLaw(problem, parts, laws)
