"""Six degrees of freedom: pairs by whatever cues pairs, heave and yaw beside them."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import minimize

from otolith import metrics, registry
from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.interfaces import PlatformState, Reference
from otolith.mpc.beside import with_singles
from otolith.mpc.design import Design, implicit
from otolith.mpc.implicit import ImplicitSettings
from otolith.mpc.linear import YAW_WEIGHT, single_axes
from otolith.mpc.several import Beside
from otolith.mpc.washout import constant
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.qp import Status
from otolith.qp.engines import CondensedEngine
from otolith.scenarios import scenario
from otolith.simulate import Run, simulate

DAVSI = load("davsi")
SETTINGS = ImplicitSettings(horizon=30, blocks=(1, 1, 3, 5, 10, 10), engine=CondensedEngine)
ALL = ("surge-pitch", "sway-roll", "heave", "yaw")


def design(**changes) -> Design:
    both = {"pairs": (SURGE_PITCH, SWAY_ROLL), "singles": ("heave", "yaw"), "implicit": SETTINGS}
    return Design(platform=DAVSI, **(both | changes))


def cue(of: Design, text: str = "step:amplitude=3,duration=4,end=3") -> Run:
    axes = {"surge-pitch": "longitudinal", "sway-roll": "lateral", "heave": "vertical", "yaw": "yaw"}
    first, *others = (scenario(text, axis=axes[dof]) for dof in of.dofs)
    for other in others:
        first = first.beside(other)
    return simulate(
        registry.make_cueing("implicit", of),
        Ideal(),
        first,
        platform=DAVSI,
        pairs=tuple(pair.name for pair in of.pairs),
        singles=of.singles,
    )


@pytest.fixture(scope="module")
def six() -> Run:
    return cue(design())


def test_all_six_axes_move_and_every_limit_holds(six: Run) -> None:
    assert six.dofs == ALL
    assert set(six.status) == {"optimal"}
    assert (np.abs(six.pose).max(axis=0) > 1e-3).all()
    quantities = {excess.quantity.split()[0] for excess in metrics.excesses(six)}
    assert quantities == {*ALL, "circle"}
    for excess in metrics.excesses(six):
        assert excess.at_nodes < 1e-6, excess


def test_the_pairs_move_as_they_do_alone_and_so_do_heave_and_yaw(six: Run) -> None:
    pairs, singles = cue(design(singles=())), cue(design(pairs=()))
    assert_array_equal(six.command[:, [0, 1, 3, 4]], pairs.command[:, [0, 1, 3, 4]])
    assert_array_equal(six.command[:, [2, 5]], singles.command[:, [2, 5]])
    assert not pairs.command[:, [2, 5]].any()
    assert not singles.command[:, [0, 1, 3, 4]].any()


def test_without_heave_and_yaw_the_algorithm_is_left_as_it_is() -> None:
    assert type(with_singles(implicit, design(singles=()))) is type(implicit(design(singles=())))


def test_yaw_is_the_optimum_that_another_solver_finds() -> None:
    """Where no limit is near: the physical rate, tracked at every step's end, against scipy's BFGS."""
    N, T, lag, R, W, wanted = 12, 0.01, 0.01, 1e-3, 2.0, 0.02
    settings = ImplicitSettings(
        horizon=N, control_weight=R, washout=constant({"position": W}), engine=CondensedEngine
    )
    mpc = single_axes(design(pairs=(), singles=("yaw",), implicit=settings))
    x0 = np.array([0.01, 0.03, 0.1])  # rate, angle, acceleration
    state = PlatformState(
        pose=np.array([0, 0, 0, 0, 0, x0[1]]),
        twist=np.array([0, 0, 0, 0, 0, x0[0]]),
        acceleration=np.array([0, 0, 0, 0, 0, x0[2]]),
    )
    command = mpc.step(
        state, Reference(specific_force=np.zeros(3), angular_rate=np.array([0.0, 0.0, wanted]))
    )

    def cost(u: np.ndarray) -> float:
        rate, angle, a = x0
        total, e = 0.0, np.exp(-T / lag)
        for command in u:  # the lag's closed form over one period
            fade = a - command
            angle += rate * T + command * T**2 / 2 + fade * lag * (T - lag * (1 - e))
            rate += command * T + fade * lag * (1 - e)
            a = command + fade * e
            total += 0.5 * YAW_WEIGHT * (rate - wanted) ** 2 + 0.5 * W * angle**2 + 0.5 * R * command**2
        return total

    best = minimize(cost, np.zeros(N), method="BFGS", options={"gtol": 1e-10, "maxiter": 2000}).x
    plan = np.concatenate([command.acceleration[None], command.plan])[:N, 5]
    assert command.outcome.status is Status.OPTIMAL
    assert_allclose(plan, best, atol=1e-4 * np.abs(best).max())


def test_the_worst_status_of_all_parts_is_told() -> None:
    cueing = with_singles(implicit, design())
    high = PlatformState(pose=np.array([0, 0, 5.0, 0, 0, 0]))
    command = cueing.step(high, Reference(specific_force=np.zeros(3)))
    assert command.outcome.status is Status.INFEASIBLE


def test_what_decides_at_other_times_does_not_go_together() -> None:
    slow = ImplicitSettings(horizon=10, period=0.02, engine=CondensedEngine)
    parts = [implicit(design(implicit=slow)), single_axes(design())]
    with pytest.raises(InputError, match="periods beside each other"):
        Beside(parts)


def test_what_cues_pairs_only_says_so() -> None:
    with pytest.raises(InputError, match="explicit does not cue heave and yaw"):
        registry.make_cueing("explicit", design())
