"""Parts are found from the data, and together they are the whole."""

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from otolith.mpqp import ParametricQp, enumerate_regions
from otolith.mpqp.oracle import solve
from otolith.mpqp.separable import enumerate_parts, separate
from tests.mpqp.models import random_problem, surge_pitch


def product(one: ParametricQp, two: ParametricQp, seed: int) -> ParametricQp:
    """Both problems side by side, variables, parameters and constraints shuffled."""
    rng = np.random.default_rng(seed)
    n, p, m = (
        rng.permutation(len(a) + len(b)) for a, b in ((one.f, two.f), (one.lower, two.lower), (one.w, two.w))
    )
    join = {name: block_diag(getattr(one, name), getattr(two, name)) for name in ("H", "F", "G", "S")}
    line = {name: np.append(getattr(one, name), getattr(two, name)) for name in ("f", "w", "lower", "upper")}
    return ParametricQp(
        H=join["H"][np.ix_(n, n)], F=join["F"][np.ix_(n, p)], f=line["f"][n], G=join["G"][np.ix_(m, n)],
        w=line["w"][m], S=join["S"][np.ix_(m, p)], lower=line["lower"][p], upper=line["upper"][p],
    )  # fmt: skip


def test_a_whole_problem_is_one_part() -> None:
    assert len(separate(random_problem(0, 3, 5, 2))) == 1


def test_a_product_of_two_is_told_apart_and_counted_as_parts_and_product() -> None:
    one, two = random_problem(1, 2, 5, 2), random_problem(2, 3, 4, 1)
    joint = enumerate_parts(product(one, two, 0))
    counts = {len(enumerate_regions(one)), len(enumerate_regions(two))}
    assert set(joint.counts) == counts
    assert len(joint) == np.prod(joint.counts)


def test_the_joint_law_equals_an_independent_qp() -> None:
    problem = product(random_problem(1, 2, 5, 2), random_problem(2, 3, 4, 2), 3)
    joint = enumerate_parts(problem)
    thetas = np.random.default_rng(0).uniform(problem.lower, problem.upper, (500, 4))
    truth = np.array([solve(problem, theta) for theta in thetas])
    many = joint.evaluate_many(thetas)
    np.testing.assert_allclose(many.z, truth, atol=1e-9)
    start = -1
    for theta, z, region in zip(thetas[:100], truth, many.region, strict=False):
        answer = joint.evaluate(theta, start)
        assert answer.found == np.isfinite(z[0])
        assert answer.region == region
        np.testing.assert_allclose(answer.z, z, atol=1e-9)
        start = answer.region if answer.found else start
        if answer.found:
            gradient = (
                problem.H @ answer.z + problem.at(theta)[0] + problem.G[answer.active].T @ answer.multipliers
            )
            np.testing.assert_allclose(gradient, 0.0, atol=1e-8)


def test_the_joint_count_equals_that_of_the_joint_enumeration() -> None:
    problem = product(random_problem(4, 2, 3, 1), random_problem(6, 1, 2, 1), 1)
    assert len(enumerate_parts(problem)) == len(enumerate_regions(problem))


def test_two_axis_pairs_are_two_parts() -> None:
    """4 DOF, blocked: the law is two laws of 2 DOF, never their product."""
    pair = surge_pitch(5, blocks=2)
    other = surge_pitch(5, blocks=2, limits=(0.05, 0.5, 7.2, 0.35))
    joint = enumerate_parts(product(pair, other, 5))
    assert sorted(joint.counts) == sorted((len(enumerate_regions(pair)), len(enumerate_regions(other))))


def test_a_constraint_that_joins_two_parts_makes_them_one() -> None:
    problem = product(random_problem(1, 2, 5, 2), random_problem(2, 3, 4, 1), 0)
    row = np.ones((1, 5))
    tied = replace(
        problem,
        G=np.vstack([problem.G, row]),
        w=np.append(problem.w, 9.0),
        S=np.vstack([problem.S, np.zeros((1, 3))]),
    )
    assert len(separate(tied)) == 1
