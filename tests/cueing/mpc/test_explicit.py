"""The explicit problem against its own definition, and the law at work against the thesis."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith import metrics
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY, SURGE_PITCH
from otolith.cueing import design
from otolith.cueing.mpc.axis_sets import axes_of, sets_apart
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_problem
from otolith.cueing.mpc.guess import FromExplicit
from otolith.cueing.mpc.rows import BrakingRows
from otolith.interfaces import PlatformState, Reference, Status
from otolith.loop import Run, simulate
from otolith.plant.ideal import without_lag
from otolith.platforms import load
from otolith.safety.invariant.axis import LEAST_LAG
from otolith.scenarios import scenario

THESIS = load("thesis")
LIMITS = THESIS.limits(SURGE_PITCH)


@pytest.fixture(scope="module")
def plain() -> design.Design:
    return design.Design(platform=THESIS)


def test_a_state_without_a_limit_is_covered_as_far_as_asked() -> None:
    open_speed = (replace(LIMITS[0], velocity=np.inf), LIMITS[1])
    problem = explicit_problem(SURGE_PITCH, open_speed, THESIS.braking, ExplicitSettings(open_bound=300.0))
    assert_allclose(problem.upper[2], 300.0)
    assert_allclose(problem.lower[2], -300.0)
    assert_allclose(problem.upper[3], LIMITS[0].position[1])


@pytest.fixture(scope="module")
def braking() -> design.Design:
    return design.Design(platform=THESIS, explicit=ExplicitSettings(braking=BrakingRows.POSITION))


def run(of: design.Design, name: str) -> Run:
    return simulate(
        design.explicit(of), without_lag(), scenario(name), platform=THESIS, dofs=("surge-pitch",)
    )


@given(
    seed=st.integers(0, 10_000),
    block_from=st.sampled_from([None, 1, 2, 3]),
    kind=st.sampled_from(list(BrakingRows)),
)
@example(seed=662, block_from=1, kind=BrakingRows.LEADING)  # the row of surge's place is the nearest
@settings(max_examples=40, deadline=None)
def test_cost_and_rows_are_those_of_the_rollout(seed: int, block_from: int | None, kind: BrakingRows) -> None:
    rng = np.random.default_rng(seed)
    options = ExplicitSettings(block_from=block_from, braking=kind)
    problem = explicit_problem(SURGE_PITCH, LIMITS, THESIS.braking, options)
    z, theta = rng.normal(size=len(problem.H)), 0.1 * rng.normal(size=5)
    U = (options.blocking(2) @ z).reshape(-1, 2)

    axes = axes_of(SURGE_PITCH, LIMITS, THESIS.braking, kind, lag=0.0, period=0.1)
    sets = sets_apart(SURGE_PITCH, THESIS.braking, axes)
    travel_ahead, tilt_ahead = (one.ahead + LEAST_LAG for one in sets)  # places follow what leads by both
    w, tilt, v, s, wanted = theta
    cost, margins, stages = 0.0, [], 0.1
    for a_rot, a_tran in U:  # two double integrators under held accelerations, by hand
        cost += (a_tran + GRAVITY * tilt - wanted) ** 2 + 1e-3 * (a_rot**2 + a_tran**2)
        margins.append(9.81 - abs(a_tran))
        if kind not in (BrakingRows.NONE, BrakingRows.LEADING):
            own = kind is not BrakingRows.PRINTED
            margins.append(0.5 - abs(own * s + 2.5 * v + 1.40625 * a_tran))
            margins.append(np.deg2rad(30) - abs(own * tilt + 0.5 * w + 0.05625 * a_rot))
        s, v = s + stages * v + stages**2 / 2 * a_tran, v + stages * a_tran
        tilt, w = tilt + stages * w + stages**2 / 2 * a_rot, w + stages * a_rot
        ahead = (tilt_ahead, travel_ahead) if kind.leads else (0.0, 0.0)
        margins += [np.deg2rad(3) - abs(w), np.deg2rad(30) - abs(tilt + ahead[0] * w)]
        margins += [7.2 - abs(v), 0.5 - abs(s + ahead[1] * v)]

    constant = 5 * theta[4] ** 2  # what is left of the cost at z = 0, tilt = 0
    constant += sum(GRAVITY**2 * (theta[1] + 0.1 * k * theta[0]) ** 2 for k in range(5))
    constant -= 2 * theta[4] * sum(GRAVITY * (theta[1] + 0.1 * k * theta[0]) for k in range(5))
    quadratic = z @ problem.H @ z + 2 * (problem.f + problem.F @ theta) @ z
    assert quadratic + constant == pytest.approx(cost, abs=1e-9)
    rows = problem.w + problem.S @ theta - problem.G @ z
    assert min(rows) == pytest.approx(min(margins), abs=1e-9)


def test_the_law_the_thesis_uses_has_about_its_number_of_regions(plain: design.Design) -> None:
    """Table 5.2 prints 938 for blocked N = 5; the exact count is odd and depends on the tolerance."""
    (law,) = plain.laws
    assert 930 <= len(law) <= 975
    assert len(law) % 2 == 1


def test_sine_2_reproduces_table_5_2(plain: design.Design) -> None:
    result = run(plain, "sine-2")
    assert set(result.status) == {Status.DECIDED}
    assert metrics.tracking_rmse(result)[0] == pytest.approx(1.586, rel=0.005)  # the thesis: 1.5815


@pytest.mark.parametrize(
    ("name", "rmse", "thesis"),
    [
        ("sine-0.5", 0.0318, 0.0345),
        ("sine-1", 0.2893, 0.2933),
        ("sine-2", 1.1777, 1.1747),
        ("combined", 0.0829, 0.0844),
        ("step-0.5", 0.0400, 0.0480),
        ("step-1", 0.2938, 0.3101),
        ("step-2", 0.9873, 1.0070),
    ],
)
def test_braking_rows_reproduce_table_c2(
    braking: design.Design, name: str, rmse: float, thesis: float
) -> None:
    result = run(braking, name)
    assert set(result.status) == {Status.DECIDED}
    reached = metrics.tracking_rmse(result)[0]
    assert reached == pytest.approx(rmse, rel=0.01)
    assert reached == pytest.approx(thesis, rel=0.2)  # step-0.5 differs most, by 17 %
    assert sum(e.violations for e in metrics.excesses(result)) == 0


def test_where_no_law_exists_it_brakes_and_says_so(plain: design.Design) -> None:
    cueing = design.explicit(plain)
    cueing.reset(PlatformState())
    fast = PlatformState(pose=np.array([0.49, 0, 0, 0, 0, 0]), twist=np.array([7.0, 0, 0, 0, 0.01, 0]))
    command = cueing.step(fast, Reference(specific_force=np.zeros(3)))
    assert command.outcome.status is Status.FALLBACK
    assert command.acceleration[0] == -9.81
    assert 0.0 <= command.twist[4] < 0.01
    nan = cueing.step(PlatformState(), Reference(specific_force=np.full(3, np.nan)))
    assert nan.outcome.status is Status.INVALID
    assert np.isfinite(nan.acceleration).all()


def test_the_hybrids_stretch_the_law_over_the_finer_horizon(plain: design.Design) -> None:
    x, plan = np.array([0.01, 0.05, 0.1, -0.1, 0.0, 0.0]), np.zeros((50, 2))
    coarse = plain.laws_at_work()[0].inputs(x, 0.7)
    assert coarse is not None
    every = FromExplicit(plain.laws_at_work(), first_only=False).controls(x, np.array([0.7]), plan)
    first = FromExplicit(plain.laws_at_work(), first_only=True).controls(x, np.array([0.7]), plan)
    assert every is not None
    assert first is not None
    assert_allclose(every[[0, 9, 10, 49]], coarse[[0, 0, 1, 4]])
    assert_allclose(first, np.tile(coarse[0], (50, 1)))
    assert_allclose(coarse[1:], np.tile(coarse[1], (4, 1)))  # blocked from the second step


def test_a_law_of_another_platform_is_refused(plain: design.Design) -> None:
    other = design.Design(platform=load("davsi"), stored_laws=plain.laws)
    with pytest.raises(
        InputError, match=r"the stored law's model is .* surge-pitch of platform davsi as chosen"
    ):
        _ = other.laws


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"horizon": 0}, "explicit horizon is 0, must be from 1 to 1000 steps"),
        ({"horizon": 10**23}, "explicit horizon is 10{23}, must be from 1 to 1000 steps"),
        ({"period": -0.1}, "explicit period is -0.1 s, must be from 0.0001 to 1 s"),
        ({"period": 1e300}, "explicit period is 1e[+]300 s, must be from 0.0001 to 1 s"),
        ({"control_weight": 1e300}, "control weight is 1e[+]300, must be from 1e-12 to 1e[+]12"),
        ({"open_bound": 0.0}, "open bound is 0.0, must be finite and greater than 0"),
        ({"block_from": 6}, "block-from is 6, must be from 1 to the horizon of 5 steps"),
    ],
)
def test_settings_out_of_bounds_are_refused(options: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        ExplicitSettings(**options)  # type: ignore[arg-type]
