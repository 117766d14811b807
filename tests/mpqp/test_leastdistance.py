"""The transformed problem has the same solution, and its symmetry is found from the data."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.mpqp.geometry import affine_multipliers
from otolith.mpqp.leastdistance import least_distance
from otolith.mpqp.oracle import solve
from otolith.mpqp.prune import prune
from tests.mpqp.models import random_problem, surge_pitch


@pytest.mark.parametrize("seed", range(5))
def test_least_distance_form_has_the_same_minimiser(seed: int) -> None:
    problem = random_problem(seed, 3, 6, 2)
    form = least_distance(problem)
    theta = np.random.default_rng(seed).uniform(problem.lower, problem.upper)
    z = solve(problem, theta)
    _, b = problem.at(theta)
    A = np.flatnonzero(np.abs(problem.G @ z - b)[form.rows] < 1e-9)
    tau = np.append(form.scaled(theta), 1.0)
    np.testing.assert_allclose(form.Z @ tau - form.V[A].T @ (affine_multipliers(form, A) @ tau), z, atol=1e-9)


def test_mirror_is_an_involution_that_changes_the_sign() -> None:
    form = least_distance(surge_pitch(5, blocks=2))
    pi = form.mirror
    assert (pi[pi] == np.arange(len(pi))).all()
    np.testing.assert_allclose(form.V[pi], -form.V, atol=1e-8)
    np.testing.assert_allclose(form.d[:, pi][:-1], -form.d[:-1], atol=1e-12)


@pytest.mark.parametrize("name", ["f", "w", "upper"])
def test_an_asymmetric_problem_has_no_mirror(name: str) -> None:
    problem = surge_pitch(5, blocks=2)
    changed = getattr(problem, name).copy()
    changed[0] += 0.01
    assert len(least_distance(replace(problem, **{name: changed})).mirror) == 0


def test_pruning_keeps_the_feasible_set() -> None:
    """44 rows become 28, and no point within those violates the others."""
    problem = surge_pitch(5, blocks=2)
    kept = prune(least_distance(problem)).form.rows
    assert len(kept) == 28
    reduced = replace(problem, G=problem.G[kept], w=problem.w[kept], S=problem.S[kept])
    rng = np.random.default_rng(0)
    for theta in rng.uniform(problem.lower, problem.upper, (300, 5)):
        np.testing.assert_allclose(solve(reduced, theta), solve(problem, theta), atol=1e-9)
