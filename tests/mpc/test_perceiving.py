"""What the drivers' organs are told of a tilted platform, against the same organs fed by hand."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.frames import GRAVITY, SURGE_PITCH, SWAY_ROLL
from otolith.interfaces import PlatformState, Reference
from otolith.mpc.design import Design
from otolith.mpc.implicit import ImplicitSettings
from otolith.mpc.linear import Sensed, implicit_sensed, linear_mpc
from otolith.mpc.perceiving import Organ
from otolith.perception import Vestibular
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine

PITCH, ROLL = -0.3, 0.2  # [rad]; the nose up, and the left side up


def held(cueing: Sensed, pose: np.ndarray) -> list[Organ]:
    """The simulator driver's organs after a second at one pose."""
    problem = cueing.problem
    x = np.concatenate([part.read(PlatformState(pose=pose)) for part in problem.parts])
    for _ in range(100):
        problem.write(
            cueing.engine.memory, x, Reference(specific_force=np.zeros(3)), np.zeros((20, problem.inputs))
        )
    return problem.here


@pytest.mark.parametrize("make", [implicit_sensed, linear_mpc])
def test_in_a_tilt_the_otoliths_are_told_of_gravity_as_it_is_and_the_canals_of_nothing(make) -> None:  # type: ignore[no-untyped-def]
    """g sin θ, not g θ, also where the prediction is linear; roll turns within pitch where both are known."""
    pairs = (SURGE_PITCH, SWAY_ROLL) if make is implicit_sensed else (SURGE_PITCH,)
    settings = ImplicitSettings(horizon=20, engine=CondensedEngine)
    cueing = make(Design(platform=load("davsi"), pairs=pairs, implicit=settings))
    organs = held(cueing, np.array([0.0, 0.0, 0.0, ROLL, PITCH, 0.0]))
    forces = [-GRAVITY * np.sin(PITCH), GRAVITY * np.cos(PITCH) * np.sin(ROLL)]
    assert len(organs) == 2 * len(pairs)
    for organ, force in zip(organs[::2], forces, strict=False):
        by_hand = Organ(Vestibular().otolith, 20, 0.01)
        for _ in range(100):
            by_hand.feel(force)
        assert_allclose(organ.x, by_hand.x, rtol=1e-9)
    for organ in organs[1::2]:
        assert not organ.x.any()
