"""Frames, signs and axis pairs: the one place where planar models meet the six axes.

Axes x forward, y left, z up (ISO 8855); roll, pitch, yaw about them, intrinsic z-y-x, so
positive pitch is nose-down. Order of six-vectors: surge x, sway y, heave z, roll, pitch, yaw.

An *axis pair* couples one translation and one tilt through one specific force. Its planar model
writes f = a + g sin(tilt); the sign between tilt and the platform's own angle is kept here only.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec

GRAVITY: Final = 9.81  # [m/s²], the thesis's value
AXES: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass(frozen=True, slots=True)
class AxisPair:
    """One translation and one tilt that share one specific force."""

    name: str
    translation: int  # index of the translation in a six-vector; also of the force in (3,)
    rotation: int  # index of the rotation in a six-vector
    sign: float  # tilt = sign · angle, chosen so that f = a + g sin(tilt)

    def planar(self, axes: Vec) -> tuple[float, float]:
        """Translation and tilt of the planar model, out of a (6,) pose, twist or acceleration."""
        return float(axes[self.translation]), self.sign * float(axes[self.rotation])

    def axes(self, translation: float, tilt: float) -> Vec:
        """(6,) pose, twist or acceleration with only this pair's axes set; undoes `planar`."""
        vector = np.zeros(6)
        vector[self.translation] = translation
        vector[self.rotation] = self.sign * tilt
        return vector


SURGE_PITCH: Final = AxisPair("surge-pitch", translation=0, rotation=4, sign=-1.0)
SWAY_ROLL: Final = AxisPair("sway-roll", translation=1, rotation=3, sign=+1.0)
PAIRS: Final = {pair.name: pair for pair in (SURGE_PITCH, SWAY_ROLL)}


def specific_force(acceleration_driver: Vec, attitude: Vec) -> Vec:
    """Specific force felt in the driver's frame, without the standing 1 g.

    f = a + Rᵀ g ẑ − g ẑ with R = Rz(yaw) Ry(pitch) Rx(roll), so that
    f_x = a_x − g sin(pitch) and f_y = a_y + g cos(pitch) sin(roll).

    Parameters
    ----------
    acceleration_driver : (..., 3) [m/s²] acceleration of the head, in the driver's frame.
    attitude : (..., 3) [rad] roll, pitch, yaw of the driver's frame in world.

    Returns
    -------
    (..., 3) [m/s²].
    """
    roll, pitch = attitude[..., 0], attitude[..., 1]
    up_driver = np.stack(
        [-np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll) - 1.0], axis=-1
    )
    force: Vec = acceleration_driver + GRAVITY * up_driver
    return force
