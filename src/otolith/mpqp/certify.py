"""Proof by an independent solver that a law is complete and right.

Notation: θ parameter, τ the same in the unit box, z minimiser. The oracle is DAQP on the ordinary QP
at θ; it shares no code with the engine. Points are drawn uniformly, inside regions with preference
for small ones, and on both sides of facets.
"""

from dataclasses import dataclass

import daqp
import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.mpqp.geometry import affine_multipliers, affine_slacks, exact_rows
from otolith.mpqp.law import Law
from otolith.mpqp.leastdistance import least_distance
from otolith.mpqp.problem import ParametricQp
from otolith.mpqp.prune import inscribed

LAW_ERROR = 1e-8  # largest deviation of z, and jump across a facet, that passes
_BESIDE = 1e-6  # distance of points beside a facet, in τ
_STRICT = 2e-6  # margin of the overlap census, above the rounding of the stored rows
_BOUNDARY = 1e-8  # slack of the whole QP below which feasibility is a matter of rounding
_FACETS = 1000
_RADIUS = 1e-2  # relative error of a radius of the order of the tolerance
_SCANS = 20_000_000  # region tests spent on the overlap census


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """What a check of a law found; `passed` sums it up."""

    regions: int
    tolerance: float  # of the enumeration: the count depends on it
    samples: int
    feasible: int  # samples where the QP has a solution
    missing: int  # of those, in no region although they lie deeper inside than `tolerance`
    slivers: int  # of those, in no region because theirs is thinner than `tolerance`
    false_hits: int  # samples in a region where the QP has no solution
    max_law_error: float  # largest |z - z_QP|
    overlap_samples: int
    max_overlap: int  # most regions, beyond one, strictly inside which one sample lies
    facets: int  # facets crossed
    continuity: float  # largest jump of z across a facet
    open_facets: int  # facets with no region beyond although the QP is feasible there
    mirror_missing: int  # regions whose mirror image is absent from a centrally symmetric problem's law

    @property
    def passed(self) -> bool:
        """Whether nothing is missing, wrong, double or torn."""
        zeros = (self.missing, self.false_hits, self.max_overlap, self.open_facets, self.mirror_missing)
        return not any(zeros) and max(self.max_law_error, self.continuity) <= LAW_ERROR


def verify(law: Law, samples: int, rng: np.random.Generator) -> Verification:
    """Check `law` at `samples` parameters and at up to 1000 facets."""
    thetas = _points(law, samples, rng)
    truth = np.array([solve(law.problem, theta) for theta in thetas])
    feasible = np.isfinite(truth[:, 0])
    answer = law.locate_many(thetas)
    gap = np.abs(answer.z - truth)[feasible & answer.found]
    lost = [theta for theta in thetas[feasible & ~answer.found] if _decided(law.problem, theta)]
    thin = sum(_is_sliver(law, theta) for theta in lost)
    false = thetas[~feasible & answer.found]
    counted = thetas[: max(100, _SCANS // max(1, len(law)))]
    crossing = _cross_facets(law, min(_FACETS, samples), rng)
    return Verification(
        regions=len(law), tolerance=law.tolerance, samples=len(thetas), feasible=int(feasible.sum()),
        missing=len(lost) - thin, slivers=thin,
        false_hits=sum(_decided(law.problem, theta) for theta in false),
        max_law_error=float(gap.max(initial=0.0)), overlap_samples=len(counted),
        max_overlap=max(0, int(law.count_many(counted, _STRICT).max(initial=0)) - 1),
        facets=crossing.facets, continuity=crossing.jump, open_facets=crossing.open,
        mirror_missing=_mirror_missing(law),
    )  # fmt: skip


def solve(problem: ParametricQp, theta: Vec) -> Vec:
    """Minimiser (n,) of the ordinary QP at `theta` by DAQP; NaN when it has none."""
    g, b = problem.at(theta)
    free = np.full(len(b), -1e30)
    kinds = np.zeros(len(b), dtype=np.int32)
    H, G = np.array(problem.H), np.array(problem.G)
    z, _, flag, _ = daqp.solve(H, g, G, b, free, kinds, primal_tol=1e-11)
    return np.asarray(z) if flag == 1 and np.isfinite(z).all() else np.full(len(g), np.nan)


def _points(law: Law, samples: int, rng: np.random.Generator) -> Mat:
    """Parameters (samples, p): three fifths uniform, a fifth in regions, a fifth beside facets."""
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
    """Region ids, half of them among the tenth with the smallest balls."""
    h = len(law.radius)
    small = np.argsort(law.radius)[: max(1, h // 10)]
    stored = np.where(rng.random(count) < 0.5, rng.choice(small, count), rng.integers(h, size=count))
    image = (rng.random(count) < 0.5) & (stored >= law.alone)
    chosen: Ints = stored + image * (h - law.alone)
    return chosen


def _inside(law: Law, region: int, rng: np.random.Generator) -> Vec:
    """A τ within half the radius of a region's centre."""
    centre, radius = law.ball(region)
    step = rng.standard_normal(len(centre))
    inside: Vec = centre + 0.5 * radius * step / np.linalg.norm(step)
    return inside


def _facet_point(law: Law, region: int, rng: np.random.Generator) -> tuple[Vec, Vec, int]:
    """Where a random ray from a region's centre leaves it: τ, the unit row there, and the facet, or -1.

    -1 stands for the bounds of the parameter.
    """
    centre, _ = law.ball(region)
    s, sign = law.stored(region)
    chosen = law.constraint[law.start[s] : law.start[s + 1]].astype(np.int64)
    facets = chosen if sign > 0 else law.form.mirror[chosen]
    rows = exact_rows(law.form, law.form_rows(region), facets)
    p = len(centre)
    domain = np.vstack([np.hstack([np.eye(p), np.ones((p, 1))]), np.hstack([-np.eye(p), np.ones((p, 1))])])
    fixed = np.vstack([domain, np.column_stack([law.form.E.T, law.form.e])])
    every = np.vstack([rows, fixed])
    ray = rng.standard_normal(p)
    speed = every[:, :-1] @ ray
    gap = np.maximum(every[:, -1] - every[:, :-1] @ centre, 0.0)
    reach = np.where(speed > 0.0, gap / np.where(speed > 0.0, speed, 1.0), np.inf)
    hit = int(reach.argmin())
    return centre + reach[hit] * ray, every[hit, :-1], hit if hit < len(rows) else -1


@dataclass(frozen=True, slots=True)
class _Crossing:
    facets: int
    jump: float
    open: int


def _cross_facets(law: Law, count: int, rng: np.random.Generator) -> _Crossing:
    """Leave regions through their facets: z must not jump, and nothing feasible may lie uncovered."""
    facets, jump, uncovered = 0, 0.0, 0
    for region in _choose(law, count, rng):
        tau, row, facet = _facet_point(law, int(region), rng)
        if facet < 0:
            continue
        on, past = (law.form.centre + law.form.half * (tau + step * row) for step in (0.0, _BESIDE))
        there = law.locate_many(past[None, :])
        if there.found[0]:
            jump = max(jump, _jump(law, int(region), int(there.region[0]), on))
            facets += 1
        elif there.region[0] == -1 and np.isfinite(solve(law.problem, past)[0]):
            uncovered += _decided(law.problem, past) and not _is_sliver(law, past)
    return _Crossing(facets, jump, uncovered)


def _jump(law: Law, one: int, other: int, theta: Vec) -> float:
    """|difference| of two regions' laws at a point of both; zero when the second does not reach it."""
    rows, bound = law.halfspaces(other)
    if (rows @ theta > bound + 1e-12).any():
        return 0.0
    return float(np.abs(_law_at(law, one, theta) - _law_at(law, other, theta)).max())


def _law_at(law: Law, region: int, theta: Vec) -> Vec:
    """Minimiser by a region's law at any θ; more accurate than through gains, which may be large."""
    f, A = law.form, law.form_rows(region)
    tau = np.append(f.scaled(theta), 1.0)
    z: Vec = f.Z @ tau + f.V[A].T @ np.linalg.solve(f.Q[np.ix_(A, A)], tau @ f.d[:, A])
    return z


def _decided(problem: ParametricQp, theta: Vec) -> bool:
    """Whether the QP at `theta` is feasible, or infeasible, by more than rounding."""
    _, b = problem.at(theta)
    length = np.maximum(np.linalg.norm(problem.G, axis=1), 1e-300)
    return abs(inscribed(problem.G / length[:, None], b / length)) > _BOUNDARY


def _is_sliver(law: Law, theta: Vec) -> bool:
    """Whether the region of a feasible `theta` is rightly absent: its ball is below the tolerance."""
    answer = law.evaluate(theta)
    if not answer.found:
        return False
    rows = _all_rows(law, np.flatnonzero(np.isin(law.form.rows, answer.active)))
    p = len(theta)
    box = np.vstack([np.eye(p), -np.eye(p), law.form.E.T])
    level = np.concatenate([rows[:, -1], np.ones(2 * p), law.form.e])
    return inscribed(np.vstack([rows[:, :-1], box]), level) < law.tolerance * (1.0 + _RADIUS)


def _all_rows(law: Law, A: Ints) -> Mat:
    """Unit half-spaces of the region of active rows A, constant ones left out."""
    gradient = affine_slacks(law.form, A)[:, :-1]
    gradient[A] = affine_multipliers(law.form, A)[:, :-1]
    return exact_rows(law.form, A, np.flatnonzero(np.linalg.norm(gradient, axis=1) > 1e-9))


def _mirror_missing(law: Law) -> int:
    """Regions without their image, looked for among all active sets; 0 without central symmetry."""
    mirror = least_distance(law.problem).without(_dropped(law)).mirror
    if len(mirror) == 0:
        return 0
    known = {tuple(law.form_rows(r)) for r in range(len(law))}
    return sum(tuple(np.sort(mirror[list(rows)])) not in known for rows in known)


def _dropped(law: Law) -> Ints:
    whole: Bools = np.isin(least_distance(law.problem).rows, law.form.rows)
    return np.flatnonzero(~whole)
