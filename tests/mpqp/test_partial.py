"""Partial laws answer rightly whatever they have seen, and learn what they meet."""

import numpy as np

from otolith.mpqp import Law
from otolith.mpqp.oracle import solve
from otolith.mpqp.partial import PartialLaw
from tests.mpqp.models import double_integrators


def trajectory(law: Law, seed: int, steps: int) -> np.ndarray:
    """Closed loop of the 2 DOF model under a sum of sines: parameters (steps, 5)."""
    A, B = double_integrators(0.1)
    rng = np.random.default_rng(seed)
    rates, phases = rng.uniform(0.2, 4.0, 4), rng.uniform(0, 6, 4)
    x, thetas, region = np.zeros(4), [], -1
    for k in range(steps):
        thetas.append(np.append(x, 0.6 * np.sin(rates * 0.1 * k + phases).sum()))
        answer = law.evaluate(thetas[-1], region)
        region = answer.region
        x = np.clip(A @ x + B @ answer.z[:2], law.problem.lower[:4], law.problem.upper[:4])
    return np.array(thetas)


def test_every_answer_equals_an_independent_qp(blocked: Law) -> None:
    partial, region = PartialLaw(blocked.problem), -1
    for theta in trajectory(blocked, 0, 300):
        answer = partial.evaluate(theta, region)
        region = answer.region
        np.testing.assert_allclose(answer.z, solve(blocked.problem, theta), atol=1e-8)


def test_a_trajectory_seen_before_is_known_and_mostly_predicted(blocked: Law) -> None:
    partial, thetas = PartialLaw(blocked.problem), trajectory(blocked, 1, 600)
    partial.learn(thetas)
    size = len(partial)
    partial.forget_hits()
    partial.learn(thetas)
    assert len(partial) == size
    assert partial.hit_rate.asked == 600
    assert partial.hit_rate.known_share == 1.0
    assert partial.hit_rate.predicted_share > 0.9


def test_infeasible_parameters_are_not_remembered(blocked: Law) -> None:
    partial = PartialLaw(blocked.problem)
    answer = partial.evaluate(blocked.problem.upper)
    assert not answer.found
    assert (len(partial), partial.hit_rate.asked) == (0, 0)


def test_the_law_grows_with_unseen_parameters(blocked: Law) -> None:
    partial = PartialLaw(blocked.problem)
    problem = blocked.problem
    thetas = np.random.default_rng(0).uniform(problem.lower, problem.upper, (4000, 5))
    for theta in thetas:
        partial.evaluate(theta)
    visited = {r for r in blocked.evaluate_many(thetas).region.tolist() if r >= 0}
    assert len(partial) == len(visited)
