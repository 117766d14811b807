"""What the driver feels, computed from the definitions, for the certificate alone.

It shares no code with the solver. It accepts complex motions, so that steps along the imaginary axis give
derivatives that are exact to rounding.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Vec
from otolith.core.frames import GRAVITY, specific_force

Numbers = NDArray[Any]  # real or complex


def felt(place: Numbers, speed: Numbers, acceleration: Numbers, head: Vec | None) -> Numbers:
    """Return the specific force [m/s²] and the yaw rate [rad/s] that the driver feels, (..., 4).

    Parameters
    ----------
    place, speed, acceleration : (..., 6) of the platform's axes.
    head : (3,) [m] where the force is sensed, with rotation and lever arm as in `core.rotation.felt_at`;
        None: the force of the planar models.
    """
    roll, pitch = place[..., 3], place[..., 4]
    yawing = speed[..., 5] * np.cos(pitch) * np.cos(roll) - speed[..., 4] * np.sin(roll)
    if head is None:
        force = specific_force(acceleration[..., :3], place[..., 3:])
    else:
        force = _force_at(head, place, speed, acceleration)
    return np.concatenate([force, yawing[..., None]], axis=-1)


def _force_at(head: Vec, place: Numbers, speed: Numbers, acceleration: Numbers) -> Numbers:
    """Return the specific force at a point: f = Rᵀ (a + α × r + ω × (ω × r) + g ẑ) − g ẑ, r = R h."""
    rolls, pitches, yaws = _axes_of_turning(place[..., 4], place[..., 5])
    R = _about(2, place[..., 5]) @ _about(1, place[..., 4]) @ _about(0, place[..., 3])
    P, Q, Y = np.moveaxis(speed[..., 3:, None], -2, 0)
    w = rolls * P + pitches * Q + yaws * Y
    # Each axis is itself turned by the axes before it: yaw, then pitch.
    alpha = rolls * acceleration[..., 3:4] + pitches * acceleration[..., 4:5] + yaws * acceleration[..., 5:]
    alpha = alpha + np.cross(yaws * Y, pitches * Q) + np.cross(yaws * Y + pitches * Q, rolls * P)
    r = R @ head
    moved = acceleration[..., :3] + np.cross(alpha, r) + np.cross(w, np.cross(w, r))
    up = np.array([0.0, 0.0, GRAVITY])
    force: Numbers = np.einsum("...ji,...j->...i", R, moved + up) - up
    return force


def _axes_of_turning(pitch: Numbers, yaw: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Return the axes (..., 3) about which roll, pitch and yaw turn, in the world frame."""
    zero, one = np.zeros_like(yaw), np.ones_like(yaw)
    rolls = np.stack([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)], axis=-1)
    pitches = np.stack([-np.sin(yaw), np.cos(yaw), zero], axis=-1)
    return rolls, pitches, np.stack([zero, zero, one], axis=-1)


def _about(axis: int, angle: Numbers) -> Numbers:
    """Return the rotations (..., 3, 3) about one axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.zeros((*angle.shape, 3, 3), dtype=angle.dtype)
    R[..., axis, axis] = 1.0
    R[..., i, i] = R[..., j, j] = np.cos(angle)
    R[..., j, i], R[..., i, j] = np.sin(angle), -np.sin(angle)
    return R
