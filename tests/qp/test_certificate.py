"""The certificate against problems of known answer, in all units, and against answers that must not pass."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.arrays import Vec
from otolith.qp import DenseSolver, Qp, Status, kkt_residual
from tests.qp.qp_problems import KINDS, Known, in_units, known_qp, twelve_units

TOLERANCE = 1e-6
INF = np.inf
seeds = st.integers(0, 100_000)
kinds = st.sampled_from(KINDS)


def residual(known: Known, z: Vec | None = None, y: Vec | None = None) -> float:
    return kkt_residual(known.qp, known.z if z is None else z, known.y if y is None else y)


@given(seed=seeds, kind=kinds)
@settings(max_examples=60, deadline=None)
def test_right_answers_pass_in_all_units(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    for known in twelve_units(rng, known_qp(rng, kind)):
        off = 1.0 + 1e-9 * rng.uniform(-1, 1, (2, len(known.z) + len(known.y)))
        n = len(known.z)
        assert residual(known) < 1e-9
        assert residual(known, known.z * off[0, :n], known.y * off[0, n:]) < TOLERANCE


@given(seed=seeds, kind=kinds)
@settings(max_examples=60, deadline=None)
def test_no_change_of_units_changes_the_certificate(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    known = known_qp(rng, kind)
    z, y = known.z + 0.1 * rng.standard_normal(len(known.z)), known.y * rng.uniform(0.5, 2.0, len(known.y))
    here = kkt_residual(known.qp, z, y)
    d, e = 10.0 ** rng.uniform(-9, 9, len(z)), 10.0 ** rng.uniform(-9, 9, len(known.qp.A))
    other = in_units(Known(known.qp, z, y), d, e, 1e-9)
    assert residual(other) == pytest.approx(here, rel=1e-6)


@given(seed=seeds, kind=kinds)
@settings(max_examples=60, deadline=None)
def test_wrong_answers_pass_in_no_units(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    known = known_qp(rng, kind)
    n = len(known.z)
    for other in twelve_units(rng, known):
        size = 10.0 ** rng.uniform(-4, 0)
        beside = other.z * (1.0 + size * rng.choice([-1.0, 1.0], n))
        moved = known.qp.H @ (beside / other.z * known.z - known.z)  # where the cost tells it from the answer
        if np.linalg.norm(moved) > 1e-5 * np.abs(known.qp.H).sum():
            assert residual(other, beside) > TOLERANCE
        assert residual(other, np.zeros(n), np.zeros(len(known.y))) > TOLERANCE


@pytest.mark.parametrize("scale", [1e-30, 1e-9, 1.0, 1e9, 1e30])
def test_zero_is_refused_whatever_the_cost_is_measured_in(scale: float) -> None:
    qp = Qp(scale * np.eye(2), scale * np.array([1.0, -2.0]), np.zeros((0, 2)), np.empty(0), np.empty(0))
    assert kkt_residual(qp, np.zeros(2), np.zeros(0)) == 1.0
    assert kkt_residual(qp, np.array([-1.0, 2.0]), np.zeros(0)) == 0.0


@pytest.mark.parametrize("scale", [1e-9, 1e-6, 1.0, 1e9])
def test_rows_count_whatever_they_are_measured_in(scale: float) -> None:
    one = np.ones((1, 1))
    qp = Qp(one, np.array([-2.0]), scale * one, np.array([-INF]), np.array([scale]))
    assert kkt_residual(qp, np.array([2.0]), np.zeros(1)) == pytest.approx(1.0 / 3.0)  # 2 of at most 1
    assert kkt_residual(qp, np.array([1.0]), np.array([1.0 / scale])) < 1e-15


@pytest.mark.parametrize(
    ("H", "z"),
    [
        ([[-1.0, 0.0], [0.0, -1.0]], [0.0, 0.0]),
        ([[1.0, 0.0], [0.0, -1.0]], [0.0, 0.0]),
        ([[1.0, 2.0], [2.0, 1.0]], [0.0, 0.0]),
    ],
)
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_a_maximum_or_saddle_is_never_accepted(H: list[list[float]], z: list[float], scale: float) -> None:
    qp = Qp(scale * np.array(H), np.zeros(2), np.eye(2)[:0], -np.ones(2), np.ones(2))
    assert kkt_residual(qp, np.array(z), np.zeros(2)) == INF
    refused = DenseSolver().solve(qp)
    assert refused.status is Status.INVALID
    assert "not convex" in refused.why


def test_huge_multipliers_that_cancel_hide_nothing() -> None:
    pair = np.array([[1.0, 1.0], [-1.0, -1.0]])  # z1 + z2 = 1, written as two rows
    qp = Qp(np.eye(2), np.array([3.0, -3.0]), pair, np.full(2, -INF), np.array([1.0, -1.0]))
    assert kkt_residual(qp, np.array([-2.5, 3.5]), np.array([0.0, 0.5])) < 1e-15
    assert kkt_residual(qp, np.array([0.5, 0.5]), np.array([1e20, 1e20])) > 0.1


def test_a_small_product_of_slack_and_multiplier_is_not_enough() -> None:
    # min ½ (z − 1)² with z ≤ 1 + 1e-3: z = 1. A multiplier of 1e-3 that pulls z to 0.999 leaves a gap of
    # 2e-6 only.
    one = np.ones((1, 1))
    qp = Qp(one, -np.ones(1), one, np.array([-INF]), np.array([1.001]))
    assert kkt_residual(qp, np.array([0.999]), np.array([1e-3])) > 1e-4


def test_rounding_about_an_exact_zero_passes_and_a_small_violation_does_not() -> None:
    # min ½ z₁² + z₁ + ½ (z₂ − 1)² with z ≥ 0: z = (0, 1), y = (−1, 0).
    qp = Qp(np.eye(2), np.array([1.0, -1.0]), np.zeros((0, 2)), np.zeros(2), np.full(2, INF))
    assert kkt_residual(qp, np.array([-1e-16, 1.0]), np.array([-1.0, 0.0])) < 1e-12
    assert kkt_residual(qp, np.array([-1e-6, 1.0]), np.array([-1.0, 0.0])) > 1e-6


def test_a_chain_of_homogeneous_rows_takes_its_size_from_its_end() -> None:
    # z₁ = z₂ = z₃, and z₁ ≤ 1 holds them at 1; multipliers of the chain that should be 0 are left over from
    # rounding.
    A = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [1.0, 0.0, 0.0]])
    qp = Qp(
        np.zeros((3, 3)), np.array([-1.0, 0.0, 0.0]), A, np.array([0.0, 0.0, -INF]), np.array([0.0, 0.0, 1.0])
    )
    assert kkt_residual(qp, np.ones(3), np.array([1e-17, 3e-17, 1.0])) < 1e-12
    assert kkt_residual(qp, np.ones(3), np.array([1e-3, 3e-3, 1.0])) > 1e-3


@given(seed=seeds, kind=kinds)
@settings(max_examples=60, deadline=None)
def test_the_engine_solves_them_in_all_units(seed: int, kind: str) -> None:
    rng = np.random.default_rng(seed)
    known = known_qp(rng, kind)
    value = 0.5 * known.z @ known.qp.H @ known.z + known.qp.g @ known.z
    terms = np.abs(known.z) @ (np.abs(known.qp.H) @ np.abs(known.z) + np.abs(known.qp.g))
    d, e = 10.0 ** rng.uniform(-9, 9, len(known.z)), 10.0 ** rng.uniform(-9, 9, len(known.qp.A))
    other = in_units(known, d, e, 10.0 ** rng.uniform(-9, 9))
    found = DenseSolver().solve(other.qp).or_raise()
    z = found.z * d
    assert 0.5 * z @ known.qp.H @ z + known.qp.g @ z == pytest.approx(value, abs=1e-6 * terms)
