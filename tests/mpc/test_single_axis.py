"""Heave and yaw against a rollout by hand, and the joint law against its parts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.mpc.explicit import ExplicitSettings
from otolith.mpc.joint import joint_law, joint_problem, problems
from otolith.mpc.single_axis import axis_problem
from otolith.platforms import load, parse_platform
from otolith.qp import DenseSolver, Qp

DAVSI = load("davsi")


@pytest.mark.parametrize("axis", ["heave", "yaw"])
@given(seed=st.integers(0, 10_000), block_from=st.sampled_from([None, 2]))
@settings(max_examples=20, deadline=None)
def test_cost_and_rows_are_those_of_the_rollout(axis: str, seed: int, block_from: int | None) -> None:
    rng = np.random.default_rng(seed)
    options = ExplicitSettings(block_from=block_from)
    problem, limits = axis_problem(DAVSI, axis, options), DAVSI.axis_limits(axis)
    z, theta = rng.normal(size=len(problem.H)), 0.1 * rng.normal(size=3)
    v, s, wanted = theta
    cost, margins = 0.0, []
    for a in options.blocking[::2, ::2] @ z:
        s, v = s + 0.1 * v + 0.005 * a, v + 0.1 * a
        cost += ((v if axis == "yaw" else a) - wanted) ** 2 + 1e-3 * a**2
        low, high = limits.position
        margins += [limits.velocity - abs(v), high - s, s - low, limits.acceleration - abs(a)]
    constant = 5 * (theta[0] - wanted) ** 2 if axis == "yaw" else 5 * wanted**2
    quadratic = z @ problem.H @ z + 2 * (problem.f + problem.F @ theta) @ z
    assert quadratic + constant == pytest.approx(cost, abs=1e-9)
    assert min(problem.w + problem.S @ theta - problem.G @ z) == pytest.approx(min(margins), abs=1e-9)


def test_the_joint_law_of_six_axes_falls_into_four_parts_and_is_the_joint_minimiser() -> None:
    options = ExplicitSettings(horizon=3, block_from=2)
    dofs = ["surge-pitch", "sway-roll", "heave", "yaw"]
    law = joint_law(DAVSI, dofs, options)
    assert len(law.counts) == 4
    assert len(law) == np.prod(law.counts)
    whole = joint_problem(problems(DAVSI, dofs, options))
    rng, found = np.random.default_rng(1), 0
    for theta in 0.3 * rng.uniform(whole.lower, whole.upper, (100, len(whole.lower))):
        g, b = whole.at(theta)
        qp = DenseSolver().solve(Qp(np.array(whole.H), g, np.array(whole.G), np.full(len(b), -np.inf), b))
        answer = law.evaluate(theta)
        assert answer.found == (qp.status == "optimal")
        if answer.found:
            found += 1
            np.testing.assert_allclose(answer.z, qp.z, atol=1e-7)
    assert found > 20


def test_parts_found_in_the_joint_problem_are_the_problems_it_was_made_of() -> None:
    """Digest for digest: so a joint law's file serves a controller that asks for one pair's law."""
    options = ExplicitSettings(horizon=2)
    parts = problems(DAVSI, ["surge-pitch", "sway-roll", "heave"], options)
    law = joint_law(DAVSI, ["surge-pitch", "sway-roll", "heave"], options)
    assert [part.problem.digest for part in law.parts] == [part.digest for part in parts]


def test_an_unknown_axis_and_a_missing_one_are_refused() -> None:
    with pytest.raises(
        InputError, match="--dofs is 'heav', must be one of surge-pitch, sway-roll, heave, yaw"
    ):
        problems(DAVSI, ["heav"], ExplicitSettings())
    with pytest.raises(InputError, match="heave of platform thesis is missing"):
        problems(load("thesis"), ["heave"], ExplicitSettings())
    rig = parse_platform('name = "rig"\n[yaw]\nangle_deg = 20\n', "rig.toml")
    with pytest.raises(InputError, match="rate or acceleration of yaw of platform rig is missing"):
        problems(rig, ["yaw"], ExplicitSettings())
