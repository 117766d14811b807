"""The oracle's minimisers are right where curvature is weak, and its margin is a distance."""

from itertools import combinations

import numpy as np
import pytest

from otolith.mpqp import ParametricQp
from otolith.mpqp.oracle import Oracle
from tests.mpqp.models import random_problem, saturated_line


def by_brute_force(problem: ParametricQp, theta: np.ndarray) -> np.ndarray | None:
    """The minimiser from the optimality conditions of every active set; None when none is optimal."""
    g, b = problem.at(theta)
    n = len(g)
    for k in range(n + 1):
        for A in map(list, combinations(range(len(b)), k)):
            K = np.block([[problem.H, problem.G[A].T], [problem.G[A], np.zeros((k, k))]])
            x = np.linalg.solve(K, np.append(-g, b[A]))
            if (problem.G @ x[:n] <= b + 1e-9).all() and (x[n:] >= -1e-9).all():
                return np.asarray(x[:n])
    return None


@pytest.mark.parametrize("ratio", [1.0, 1e-6, 1e-11, 1e-12])
def test_weak_curvature_is_not_lost(ratio: float) -> None:
    """|z1|, |z2| ≤ 1 and H = diag(1, ratio) turned by 30 degrees, where DAQP's default errs by 1."""
    turn = np.array([[np.cos(0.5), -np.sin(0.5)], [np.sin(0.5), np.cos(0.5)]])
    H = turn @ np.diag([1.0, ratio]) @ turn.T
    theta, bound = np.array([0.3]), np.vstack([np.eye(2), -np.eye(2)])
    wanted = turn @ np.array([0.2, 0.4])  # inside, where the gradient vanishes
    problem = ParametricQp(
        H=(H + H.T) / 2, F=np.zeros((2, 1)), f=-H @ wanted, G=bound, w=np.ones(4), S=np.zeros((4, 1)),
        lower=-np.ones(1), upper=np.ones(1),
    )  # fmt: skip
    np.testing.assert_allclose(Oracle(problem).solve(theta), wanted, atol=max(1e-12, 1e-15 / ratio))


@pytest.mark.parametrize("seed", range(3))
def test_minimisers_are_those_of_brute_force(seed: int) -> None:
    problem, found = random_problem(seed, 3, 5, 2), 0
    oracle = Oracle(problem)
    for theta in np.random.default_rng(seed).uniform(3 * problem.lower, 3 * problem.upper, (40, 2)):
        z, right = oracle.solve(theta), by_brute_force(problem, theta)
        assert np.isfinite(z).all() == (right is not None)
        if right is not None:
            np.testing.assert_allclose(z, right, atol=1e-9)
            found += 1
    assert 0 < found <= 40


def test_margin_is_the_distance_of_the_rows_from_contradiction() -> None:
    """|z| ≤ 1 allows to tighten both rows by 1, z ≤ 1 and z ≥ 3 need to be loosened by 1."""
    line = saturated_line()
    assert Oracle(line).margin(np.zeros(1)) == pytest.approx(1.0)
    apart = ParametricQp(
        H=line.H, F=line.F, f=line.f, G=line.G, w=np.array([1.0, -3.0]), S=line.S, lower=line.lower,
        upper=line.upper,
    )  # fmt: skip
    assert Oracle(apart).margin(np.zeros(1)) == pytest.approx(-0.5)  # in units of the median distance, 2
    assert np.isnan(Oracle(apart).solve(np.zeros(1))).all()


def test_rows_on_the_parameter_alone_count() -> None:
    line = saturated_line()
    problem = ParametricQp(
        H=line.H, F=line.F, f=line.f, G=np.vstack([line.G, np.zeros((1, 1))]), w=np.append(line.w, 1.0),
        S=np.array([[0.0], [0.0], [-1.0]]), lower=line.lower, upper=line.upper,
    )  # fmt: skip
    oracle = Oracle(problem)
    np.testing.assert_allclose(oracle.solve(np.array([0.9])), 0.9)
    assert np.isnan(oracle.solve(np.array([1.1]))).all()
    assert oracle.margin(np.array([1.1])) < 0.0
