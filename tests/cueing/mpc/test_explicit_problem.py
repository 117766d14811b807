"""Laws of heave and yaw against a rollout by hand, and the joint law against its parts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.core.frames import DOFS, HEAVE, SURGE_PITCH, SWAY_ROLL, YAW, Dof
from otolith.cueing.mpc.explicit_problem import (
    ExplicitSettings,
    explicit_platform,
    explicit_problem,
    joint_law,
    joint_problem,
)
from otolith.mpqp import ParametricQp
from otolith.platforms import Platform, load, parse_platform
from otolith.qp import DenseSolver, Qp

DAVSI = load("davsi")


def problem_of(platform: Platform, dof: Dof, options: ExplicitSettings) -> ParametricQp:
    return explicit_problem(dof, platform.limits(dof), platform.braking, options)


def problems(dofs: tuple[Dof, ...], options: ExplicitSettings) -> list[ParametricQp]:
    seen = explicit_platform(DAVSI, dofs)
    return [problem_of(seen, dof, options) for dof in dofs]


@pytest.mark.parametrize("dof", [HEAVE, YAW], ids=lambda dof: dof.name)
@given(seed=st.integers(0, 10_000), block_from=st.sampled_from([None, 2]))
@settings(max_examples=20, deadline=None)
def test_cost_and_rows_are_those_of_the_rollout(dof: Dof, seed: int, block_from: int | None) -> None:
    rng = np.random.default_rng(seed)
    options = ExplicitSettings(block_from=block_from)
    problem, (limits,) = problem_of(DAVSI, dof, options), DAVSI.limits(dof)
    z, theta = rng.normal(size=len(problem.H)), 0.1 * rng.normal(size=3)
    v, s, wanted = theta
    cost, margins = 0.0, []
    for a in options.blocking(1) @ z:
        s, v = s + 0.1 * v + 0.005 * a, v + 0.1 * a
        cost += ((v if dof is YAW else a) - wanted) ** 2 + 1e-3 * a**2
        low, high = limits.position
        margins += [limits.velocity - abs(v), high - s, s - low, limits.acceleration - abs(a)]
    constant = 5 * (theta[0] - wanted) ** 2 if dof is YAW else 5 * wanted**2
    quadratic = z @ problem.H @ z + 2 * (problem.f + problem.F @ theta) @ z
    assert quadratic + constant == pytest.approx(cost, abs=1e-9)
    assert min(problem.w + problem.S @ theta - problem.G @ z) == pytest.approx(min(margins), abs=1e-9)


def test_the_joint_law_of_six_axes_falls_into_four_parts_and_is_the_joint_minimiser() -> None:
    options = ExplicitSettings(horizon=3, block_from=2)
    law = joint_law(DAVSI, tuple(DOFS.values()), options)
    assert len(law.counts) == 4
    assert len(law) == np.prod(law.counts)
    whole = joint_problem(problems(tuple(DOFS.values()), options))
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
    options, dofs = ExplicitSettings(horizon=2), (SURGE_PITCH, SWAY_ROLL, HEAVE)
    law = joint_law(DAVSI, dofs, options)
    assert [part.problem.digest for part in law.parts] == [part.digest for part in problems(dofs, options)]


def test_where_both_pairs_are_cued_their_laws_keep_a_square_inside_the_circle() -> None:
    both, alone = explicit_platform(DAVSI, (SURGE_PITCH, SWAY_ROLL)), explicit_platform(DAVSI, (SURGE_PITCH,))
    assert DAVSI.circle is not None
    side = DAVSI.circle / np.sqrt(2.0)
    for pair in (SURGE_PITCH, SWAY_ROLL):
        low, high = both.limits(pair)[0].position
        assert np.hypot(max(-low, high), side) <= DAVSI.circle + 1e-12
    assert alone.limits(SURGE_PITCH)[0].position == DAVSI.limits(SURGE_PITCH)[0].position
    travel = explicit_platform(load("thesis"), (SURGE_PITCH,)).limits(SURGE_PITCH)[0]
    assert travel.command == travel.acceleration == 9.81  # commands of its model are accelerations


def test_a_missing_axis_is_refused() -> None:
    with pytest.raises(InputError, match="heave of platform thesis is missing"):
        problem_of(load("thesis"), HEAVE, ExplicitSettings())
    rig = parse_platform('name = "rig"\n[yaw]\nangle_deg = 20\n', "rig.toml")
    with pytest.raises(InputError, match="rate or acceleration of yaw of platform rig is missing"):
        problem_of(rig, YAW, ExplicitSettings())
