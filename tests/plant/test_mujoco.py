"""Two rigid-body codes by different authors agree on the same machine."""

import numpy as np
import pytest

from otolith.interfaces import PlatformState
from otolith.plant.hexapod import hexapod
from otolith.platforms import load
from tests.plant.test_hexapod import commanding, driven, poses

pytest.importorskip("mujoco", reason="the extra [emulator] is not installed")

from otolith.plant.mujoco import MujocoHexapod, hexapod_mujoco

DAVSI = load("davsi")


@pytest.mark.parametrize("start", [np.zeros(6), np.array([0.1, -0.1, 0.05, 0.05, -0.1, 0.1])])
def test_the_two_hexapods_agree(start: np.ndarray) -> None:
    """To 0.5 mm (and 0.5 mrad) and 1e-3 m/s², along all axes at once."""
    ours, theirs = hexapod(DAVSI), hexapod_mujoco(DAVSI)
    for plant in (ours, theirs):
        plant.reset(PlatformState(pose=start))
    here, there = driven(ours, 1500, 0.5), driven(theirs, 1500, 0.5)
    assert np.abs(poses(here) - poses(there)).max() < 5e-4
    felt = [np.array([state.specific_force for state in states]) for states in (here, there)]
    assert np.sqrt(np.mean((felt[0] - felt[1]) ** 2, axis=0)).max() < 1e-3
    assert np.abs(poses(here) - start).max() > 0.02
    assert ours.interventions == theirs.interventions == ()


def test_it_starts_in_motion() -> None:
    twist = np.array([0.1, -0.05, 0.05, 0.05, 0.1, -0.1])
    start = PlatformState(pose=np.array([0.05, 0, 0, 0.05, 0, 0]), twist=twist)
    ours, theirs = hexapod(DAVSI), hexapod_mujoco(DAVSI)
    ours.reset(start)
    theirs.reset(start)
    here, there = driven(ours, 50, 0.5), driven(theirs, 50, 0.5)
    assert np.abs(poses(here) - poses(there)).max() < 5e-4
    assert np.abs(here[-1].twist - there[-1].twist).max() < 5e-3


def test_what_they_differ_by_at_a_jump_is_the_softness_of_the_others_joints() -> None:
    """With stiffer joints and shorter steps MuJoCo's felt force at single samples goes to ours."""
    jump = commanding(np.array([1.5, 0.0, 0.0, 0.0, 8.0, 0.0]))

    def felt(plant: object) -> np.ndarray:
        return np.array([plant.step(jump, 1e-3).specific_force for _ in range(40)])  # type: ignore[attr-defined]

    ours, legs = felt(hexapod(DAVSI)), DAVSI.six_legs()
    apart = [np.abs(felt(MujocoHexapod(legs, steps=steps)) - ours).max() for steps in (8, 32, 128)]
    assert apart[1] < 0.6 * apart[0]
    assert apart[2] < 0.6 * apart[1]
    assert apart[2] < 1e-3
