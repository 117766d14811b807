"""Prove with an independent solver that a law is complete and correct.

Notation: θ parameter, τ the parameter scaled to the unit box, z minimiser. The oracle is DAQP on the ordinary
QP at θ, see `oracle`; it shares no code with the engine. Points are drawn uniformly, inside regions (small
ones preferred), and on both sides of facets.

Every variable is judged relative to the largest value that it takes at the samples, and feasibility in the
oracle's unit, so that the verdict does not depend on the units of the problem.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.mpqp.geometry import affine_multipliers, affine_slacks, exact_rows
from otolith.mpqp.law import Law
from otolith.mpqp.leastdistance import least_distance
from otolith.mpqp.oracle import Oracle
from otolith.mpqp.problem import ParametricQp
from otolith.mpqp.prune import inscribed

LongVec = NDArray[np.longdouble]
LAW_ERROR = 1e-8  # largest accepted relative deviation of z, and largest accepted jump across a facet
_GRAIN = 1e-2  # part of a law's grain that is added to LAW_ERROR, for rounding where curvature is weak
_SMALL = 1e-6  # smallest unit of a variable relative to the largest, with units of curvature 1
_BESIDE = 1e-6  # distance from a facet of the points next to it, in τ
_STRICT = 2e-6  # margin of the overlap census, larger than the rounding of the stored rows
_BOUNDARY = 1e-8  # margin of the QP, in the oracle's unit, below which rounding decides feasibility
_BLURRED = 3.0  # the same for the law, in multiples of the violation that its own QP ends with
_FOUND = 1e-9  # how far from its place, in τ, a facet may be located again
_TOUCH = 1e-12  # how near, in τ, a region must come to a point to share it
_REFINED = 4  # solves of a linear system; all but the first are refinements
_FACETS = 1000
_RADIUS = 1e-2  # relative error of a radius that is close to the tolerance
_SCANS = 100_000_000  # largest number of region tests in the overlap census
_INSPECTED = 2000  # largest number of regions checked against their own optimality conditions
_RAYS = 32  # rays from the centre of each of these


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """The result of checking a law; `passed` summarises it.

    Between full regions lie thinner ones, down to facets where many constraints meet. The law leaves them
    out, as its tolerance states. A parameter inside such a sliver is no hole: `Law.evaluate` solves the QP
    there and its answer is exact, only its region is -1 (MISSED).

    Two regions cannot share an interior if each lies within its own optimality conditions (at most one active
    set satisfies them strictly) and none is stored twice. `strays` and `doubles` check this region by region;
    the census `max_overlap` checks it once more by counting at sample parameters. The census leaves out
    points nearer than 2e-6 to a facet: rows stored in 32 bits have an error of up to 2^-24 (|a|_1 + |b|), at
    most 4e-7 for five parameters.
    """

    regions: int
    tolerance: float  # tolerance of the enumeration, on which the number of regions depends
    samples: int
    feasible: int  # samples where the QP has a solution
    unsolved: (
        int  # samples where the law answers and an LP confirms feasibility, but the oracle has no answer
    )
    missing: int  # feasible samples in no region although they lie deeper inside than `tolerance`
    slivers: int  # feasible samples in no region because their region is thinner than `tolerance`
    false_hits: int  # samples where the law has an answer or a region although the QP has no solution
    max_law_error: float  # largest |z_i - z_QP,i|, relative to the largest |z_QP,i| of all samples
    overlap_samples: int
    max_overlap: int  # largest number of regions, beyond one, that strictly contain the same sample
    strays: int  # of up to 2000 regions, those whose facets admit points that their conditions forbid
    doubles: int  # active sets stored twice, directly or as mirror images
    facets: int  # number of facets crossed to a region that shares them
    continuity: float  # largest jump of z across a facet, relative in the same way
    open_facets: int  # facets with no region beyond them although the QP is feasible there
    mirror_missing: int  # regions whose mirror image is absent from a centrally symmetric problem's law
    allowed_error: float = LAW_ERROR  # bound on `max_law_error` and `continuity`

    @property
    def passed(self) -> bool:
        """True when nothing is missing, wrong, stored twice, discontinuous, or undecided by the oracle."""
        holes = (self.missing, self.open_facets, self.mirror_missing, self.unsolved)
        excess = (self.false_hits, self.max_overlap, self.strays, self.doubles)
        return not any(holes + excess) and max(self.max_law_error, self.continuity) <= self.allowed_error


def verify(law: Law, samples: int, rng: np.random.Generator) -> Verification:
    """Check `law` at `samples` parameters, at up to 1000 facets and in up to 2000 regions."""
    thetas = _points(law, samples, rng)
    judge = _Judge(law, thetas)
    feasible = np.isfinite(judge.truth[:, 0])
    answer = law.locate_many(thetas)
    gap = (np.abs(answer.z - judge.truth) / judge.unit)[feasible & answer.found]
    lost = [theta for theta in thetas[feasible & ~answer.found] if judge.feasible(theta)]
    thin = sum(_is_sliver(law, theta) for theta in lost)
    few = max(100, _SCANS // max(1, len(law)))
    held = law.count_many(thetas[:few], _STRICT)
    wrong = ~feasible & (answer.found | law.evaluate_many(thetas).found)
    wrong[:few] |= ~feasible[:few] & (held > 0) & _within(law, thetas[:few])
    crossing = _cross_facets(law, judge, min(_FACETS, samples), rng)
    return Verification(
        regions=len(law), tolerance=law.tolerance, samples=len(thetas), feasible=int(feasible.sum()),
        unsolved=sum(judge.feasible(theta) for theta in thetas[wrong]),
        missing=len(lost) - thin, slivers=thin,
        false_hits=sum(judge.infeasible(theta) for theta in thetas[wrong]),
        max_law_error=float(gap.max(initial=0.0)), overlap_samples=len(held),
        max_overlap=max(0, int(held.max(initial=0)) - 1),
        strays=sum(_strays(law, int(r), rng) for r in _choose(law, min(_INSPECTED, samples), rng)),
        doubles=_doubles(law),
        facets=crossing.facets, continuity=crossing.jump, open_facets=crossing.open,
        mirror_missing=_mirror_missing(law), allowed_error=LAW_ERROR * max(1.0, _GRAIN * law.form.grain),
    )  # fmt: skip


class _Judge:
    """The true minimisers at the samples (N, p), and the differences from them that count as rounding."""

    def __init__(self, law: Law, thetas: Mat) -> None:
        self.oracle = Oracle(law.problem)
        self.truth = np.array([self.oracle.solve(theta) for theta in thetas])  # (N, n)
        largest = np.nanmax(np.abs(np.nan_to_num(self.truth)), axis=0, initial=0.0) / self.oracle.size
        self.unit = self.oracle.size * np.maximum(largest, max(_SMALL * float(largest.max()), 1e-300))
        self._boundary = max(_BOUNDARY, _BLURRED * law.form.blur)

    def feasible(self, theta: Vec) -> bool:
        """True when the QP at `theta` is feasible by more than rounding."""
        return self.oracle.margin(theta) > self._boundary

    def infeasible(self, theta: Vec) -> bool:
        """True when the QP at `theta` is infeasible by more than rounding."""
        return self.oracle.margin(theta) < -self._boundary


def _points(law: Law, samples: int, rng: np.random.Generator) -> Mat:
    """Draw parameters (samples, p): three fifths uniform, a fifth inside regions, a fifth next to facets."""
    in_regions = samples // 5
    uniform = rng.uniform(-1.0, 1.0, (samples - 2 * in_regions, len(law.form.half)))
    chosen = _choose(law, in_regions, rng)
    inside = np.array([_inside(law, r, rng) for r in chosen]).reshape(in_regions, -1)
    beside = [_facet_point(law, r, rng) for r in chosen]
    sides = rng.choice((-_BESIDE, _BESIDE), in_regions)
    shifted = np.array([x + s * a for (x, a, _), s in zip(beside, sides, strict=True)]).reshape(
        in_regions, -1
    )
    taus = np.vstack([uniform, inside, shifted])
    rng.shuffle(taus)
    thetas: Mat = law.form.centre + law.form.half * np.clip(taus, -1.0, 1.0)
    return thetas


def _choose(law: Law, count: int, rng: np.random.Generator) -> Ints:
    """Draw region ids, half of them from the tenth of the regions with the smallest balls."""
    h = len(law.radius)
    small = np.argsort(law.radius)[: max(1, h // 10)]
    stored = np.where(rng.random(count) < 0.5, rng.choice(small, count), rng.integers(h, size=count))
    image = (rng.random(count) < 0.5) & (stored >= law.alone)
    chosen: Ints = stored + image * (h - law.alone)
    return chosen


def _inside(law: Law, region: int, rng: np.random.Generator) -> Vec:
    """Draw a τ within half the radius around a region's centre."""
    centre, radius = law.ball(region)
    step = rng.standard_normal(len(centre))
    inside: Vec = centre + 0.5 * radius * step / np.linalg.norm(step)
    return inside


def _facet_point(law: Law, region: int, rng: np.random.Generator) -> tuple[Vec, Vec, int]:
    """Shoot a random ray from a region's centre; return the exit point τ, the unit row there, and the facet.

    The facet is -1 where the ray leaves through the bounds of the parameter.
    """
    centre, _ = law.ball(region)
    facets = law.facets(region)
    rows = np.vstack([exact_rows(law.form, law.form_rows(region), facets), _domain(law)])
    points, hit = _leave(rows, centre, rng.standard_normal((1, len(centre))))
    return points[0], rows[hit[0], :-1], int(hit[0]) if hit[0] < len(facets) else -1


def _leave(rows: Mat, centre: Vec, rays: Mat) -> tuple[Mat, Ints]:
    """Find where rays (N, p) from the centre first meet a half-space: τ (N, p), and the index of that
    half-space.
    """
    speed = rays @ rows[:, :-1].T  # (N, rows)
    gap = np.maximum(rows[:, -1] - rows[:, :-1] @ centre, 0.0)
    reach = np.where(speed > 0.0, gap / np.where(speed > 0.0, speed, 1.0), np.inf)
    hit = reach.argmin(axis=1)
    return centre + reach.min(axis=1)[:, None] * rays, hit


def _domain(law: Law) -> Mat:
    """Half-spaces (a, b) of the box and of the constraints on the parameter alone."""
    p = len(law.form.half)
    bounds = np.column_stack([np.vstack([np.eye(p), -np.eye(p)]), np.ones(2 * p)])
    return np.vstack([bounds, np.column_stack([law.form.E.T, law.form.e])])


def _within(law: Law, thetas: Mat) -> Bools:
    """Mark the parameters (N, p) that satisfy the constraints on the parameter alone; regions do not
    store these.
    """
    return np.asarray((law.form.scaled(thetas) @ law.form.E <= law.form.e).all(axis=1), dtype=np.bool_)


def _strays(law: Law, region: int, rng: np.random.Generator) -> bool:
    """True when a region's facets admit points where its law is not optimal, so that it covers other
    regions.
    """
    A, (centre, _) = law.form_rows(region), law.ball(region)
    rows = np.vstack([exact_rows(law.form, A, law.facets(region)), _domain(law)])
    points, _ = _leave(rows, centre, rng.standard_normal((_RAYS, len(centre))))
    every = _all_rows(law, A)
    return bool((points @ every[:, :-1].T - every[:, -1] > _STRICT).any())


def _doubles(law: Law) -> int:
    """Count the active sets that are stored twice, directly or as mirror images."""
    bits = law.bits()
    image = bits[law.alone :, law.form.mirror] if law.alone < len(bits) else bits[:0]
    packed = np.packbits(np.vstack([bits, image]), axis=1)
    return len(packed) - len(np.unique(packed, axis=0))


@dataclass(frozen=True, slots=True)
class _Crossing:
    facets: int
    jump: float
    open: int


def _cross_facets(law: Law, judge: _Judge, count: int, rng: np.random.Generator) -> _Crossing:
    """Leave regions through their facets: z must not jump, and no feasible point may be uncovered."""
    facets, jump, uncovered = 0, 0.0, 0
    for region in _choose(law, count, rng):
        tau, row, facet = _facet_point(law, int(region), rng)
        if facet < 0:
            continue
        on, past = (law.form.centre + law.form.half * (tau + step * row) for step in (0.0, _BESIDE))
        there = law.locate_many(past[None, :])
        if there.found[0]:
            other = int(there.region[0])
            leap = _jump(law, judge, int(region), facet, other=other, on=on, past=past)
            facets += leap >= 0.0
            jump = max(jump, leap)
        elif there.region[0] == -1 and judge.feasible(past):
            uncovered += not _is_sliver(law, past)
    return _Crossing(facets, jump, uncovered)


def _jump(law: Law, judge: _Judge, one: int, facet: int, *, other: int, on: Vec, past: Vec) -> float:
    """Return |difference| of the laws of two regions where they meet; -1 when the second does not reach the
    point.

    A facet's position has a rounding error along its gradient, and from there the laws differ by the
    difference of their gains: an error of 1e-12 times a gain of 1e4 is no discontinuity. Therefore the facet
    is located again as the zero of its own multiplier or slack, on the line from `on` to `past` and within
    _FOUND of `on`.
    """
    problem = judge.oracle.problem
    i = int(law.form.rows[law.facets(one)[facet]])
    start, step = on.astype(np.longdouble), (past - on).astype(np.longdouble)
    g = [_condition(problem, law.active(one), start + t * step, i) for t in (0.0, 1.0)]
    shift = float(g[0] / (g[0] - g[1])) if g[0] != g[1] else 0.0
    theta = start + step * np.clip(shift, -_FOUND / _BESIDE, _FOUND / _BESIDE)
    rows, bound = law.halfspaces(other)
    if (rows @ theta.astype(np.float64) > bound + _TOUCH).any():
        return -1.0
    z, _ = _law_at(problem, law.active(one), theta)
    beyond, _ = _law_at(problem, law.active(other), theta)
    return float((np.abs(z - beyond) * judge.oracle.size / judge.unit).max())


def _condition(problem: ParametricQp, A: Ints, theta: LongVec, i: int) -> np.longdouble:
    """Multiplier of constraint i if it is in A, else its slack, by the law of A at `theta`."""
    z, lam = _law_at(problem, A, theta)
    if i in A:
        return np.longdouble(lam[i == A][0])
    return np.longdouble(problem.w[i] + problem.S[i] @ theta - problem.G[i] @ z)


def _law_at(problem: ParametricQp, A: Ints, theta: LongVec) -> tuple[LongVec, LongVec]:
    """Minimiser and multipliers with the constraints A active, without rounding except that of the data.

    Solves [H G_A'; G_A 0][z; λ] = [-(f + F θ); w_A + S_A θ] with residuals in extended precision.
    """
    n, G = len(problem.f), problem.G[A]
    K = np.block([[problem.H, G.T], [G, np.zeros((len(A), len(A)))]])
    right = np.concatenate([-problem.f - problem.F @ theta, problem.w[A] + problem.S[A] @ theta])
    factor = lu_factor(K)
    x = np.zeros(len(right), dtype=np.longdouble)
    for _ in range(_REFINED):
        x += lu_solve(factor, (right - K @ x).astype(np.float64))
    return x[:n], x[n:]


def _is_sliver(law: Law, theta: Vec) -> bool:
    """True when the region of a feasible `theta` may be absent because its ball is smaller than the
    tolerance.
    """
    answer = law.evaluate(theta)
    if not answer.found:
        return False
    rows = _all_rows(law, np.flatnonzero(np.isin(law.form.rows, answer.active)))
    rows = np.vstack([rows, _domain(law)])
    return inscribed(rows[:, :-1], rows[:, -1]) < law.tolerance * (1.0 + _RADIUS)


def _all_rows(law: Law, A: Ints) -> Mat:
    """Unit half-spaces of the region of active rows A, without constant ones."""
    gradient = affine_slacks(law.form, A)[:, :-1]
    gradient[A] = affine_multipliers(law.form, A)[:, :-1]
    return exact_rows(law.form, A, np.flatnonzero(np.linalg.norm(gradient, axis=1) > 1e-9))


def _mirror_missing(law: Law) -> int:
    """Count the regions without a mirror image among all active sets; 0 without central symmetry."""
    mirror = least_distance(law.problem).without(_dropped(law)).mirror
    if len(mirror) == 0:
        return 0
    bits = law.bits()
    if len(law.form.mirror):
        bits = np.vstack([bits, bits[law.alone :, law.form.mirror]])
    packed, images = np.packbits(bits, axis=1), np.packbits(bits[:, mirror], axis=1)
    known = {key.tobytes() for key in packed}
    return sum(key.tobytes() not in known for key in images)


def _dropped(law: Law) -> Ints:
    whole: Bools = np.isin(least_distance(law.problem).rows, law.form.rows)
    return np.flatnonzero(~whole)
