"""Counts by other definitions, each against brute force over all active sets or a general solver."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.mpqp import Law, ParametricQp, ball_radii, count_regions, enumerate_regions, overlapping_sets
from otolith.mpqp.geometry import affine_multipliers, affine_slacks
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.prune import largest_ball
from otolith.mpqp.simplex import UNDECIDED
from tests.mpqp.models import random_problem, surge_pitch


def radius(form: LeastDistance, A: np.ndarray, scale: np.ndarray) -> float:
    """Radius in θ/scale of the region of active rows A; -1 when they are dependent or weakly active."""
    if np.linalg.matrix_rank(form.Q[np.ix_(A, A)], tol=1e-9) < len(A):
        return -1.0
    affine = affine_slacks(form, A)
    affine[A] = affine_multipliers(form, A)
    constant = np.linalg.norm(affine[:, :-1], axis=1) < 1e-9
    if (affine[constant, -1] < -1e-9).any() or (np.abs(affine[A, -1])[constant[A]] < 1e-9).any():
        return -1.0
    rows = affine[~constant] * np.append(-np.ones(len(form.half)), 1.0)
    p = len(form.half)
    A_tau = np.vstack([rows[:, :-1], np.eye(p), -np.eye(p), form.E.T])
    A_theta = A_tau / form.half  # rows in the parameters' own units
    b = np.concatenate([rows[:, -1], np.ones(2 * p), form.e])
    return largest_ball(A_theta, b, np.linalg.norm(A_theta * scale, axis=1))


def brute_force(law: Law, least: float, scale: np.ndarray) -> set[tuple[int, ...]]:
    """All independent sets of rows that are optimal throughout a ball, by trying all subsets."""
    m, n, _ = law.form.sizes
    subsets = [np.array(A, dtype=np.int64) for k in range(n + 1) for A in combinations(range(m), k)]
    return {tuple(A.tolist()) for A in subsets if radius(law.form, A, scale) >= least}


def sets_of(law: Law) -> set[tuple[int, ...]]:
    return {tuple(law.form_rows(region).tolist()) for region in range(len(law))}


def cone(seed: int) -> ParametricQp:
    """Five planes that meet in one point for every parameter, none of them implied by the others."""
    plain = random_problem(seed, 3, 1, 2)
    rng = np.random.default_rng(seed)
    around = (np.arange(5) + rng.uniform(0.1, 0.9, 5)) * 2.0 * np.pi / 5.0
    sides = np.column_stack([np.cos(around), np.sin(around), np.full(5, 0.7)]) @ rng.standard_normal((3, 3))
    return replace(
        plain,
        G=np.vstack([plain.G, sides]),
        w=np.append(plain.w, sides @ rng.uniform(-0.1, 0.1, 3)),
        S=np.vstack([plain.S, sides @ rng.uniform(-0.3, 0.3, (3, 2))]),
    )


def test_overlapping_sets_are_those_of_brute_force() -> None:
    overlapping = 0
    for seed in range(25):
        law = enumerate_regions(cone(seed), tolerance=1e-9)
        own, scale = sets_of(law), law.form.half
        more = overlapping_sets(law, 1e-6, scale)
        assert own.isdisjoint(more)
        assert more == brute_force(law, 1e-6, scale) - own
        overlapping += len(more)
    assert overlapping > 50


def test_rows_at_a_joint_vertex_overlap() -> None:
    """Four planes meet in the apex of a pyramid, and any three of them hold it: some sets overlap."""
    sides = np.array([[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]])
    problem = ParametricQp(
        H=np.eye(3), F=-np.eye(3), f=np.zeros(3), G=sides, w=np.ones(4), S=np.zeros((4, 3)),
        lower=-4 * np.ones(3), upper=4 * np.ones(3),
    )  # fmt: skip
    law = enumerate_regions(problem)
    more = overlapping_sets(law, 1e-6)
    assert len(more) > 0
    assert brute_force(law, 1e-6, np.ones(3)) == sets_of(law) | more


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.integers(0, 10**6))
def test_nothing_overlaps_where_no_rows_are_dependent(seed: int) -> None:
    law = enumerate_regions(random_problem(seed, 3, 6, 2))
    assert overlapping_sets(law, 1e-9, law.form.half) == set()


def test_input_limits_leave_no_overlaps_in_the_thesis_s_law(blocked: Law) -> None:
    """With limits on an input the count of active sets and of regions is one number."""
    assert overlapping_sets(blocked, 1e-9) == set()


def test_in_the_unit_box_the_radii_are_the_stored_ones(blocked: Law) -> None:
    np.testing.assert_allclose(ball_radii(blocked, blocked.form.half), blocked.radius, rtol=1e-6)
    assert count_regions(blocked, blocked.tolerance * 0.99, blocked.form.half) == len(blocked)


def test_radii_in_own_units_are_those_of_a_general_solver(blocked: Law) -> None:
    one = np.ones(5)
    chosen = np.random.default_rng(0).choice(len(blocked.radius), 40, replace=False)
    plain = [radius(blocked.form, blocked.form_rows(int(region)), one) for region in chosen]
    np.testing.assert_allclose(ball_radii(blocked)[chosen], plain, rtol=1e-5, atol=1e-11)


def test_a_ball_in_own_units_does_not_depend_on_the_parameter_box(blocked: Law) -> None:
    """A wider box for the reference makes regions thinner in the unit box, not in their own units."""
    wide = enumerate_regions(surge_pitch(5, blocks=2, reference=2000.0), tolerance=1e-10)
    fine = enumerate_regions(surge_pitch(5, blocks=2, reference=200.0), tolerance=1e-10)
    for diameter in (1e-3, 1e-5):
        assert count_regions(wide, diameter / 2) == count_regions(fine, diameter / 2)
    unit_box = [count_regions(law, 1e-5, law.form.half) for law in (wide, fine)]
    assert unit_box[0] < unit_box[1]


def test_a_set_that_the_simplex_method_gives_up_on_is_measured_all_the_same(
    blocked: Law, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = ball_radii(blocked)
    from otolith.mpqp import counts

    def lost(form: object, work: object, active: object, stretch: object, out: np.ndarray) -> None:
        out[:] = UNDECIDED

    monkeypatch.setattr(counts, "_measure", lost)
    np.testing.assert_allclose(ball_radii(blocked), expected, rtol=1e-5, atol=1e-11)
