"""A machine on six cranks, for tests: six 50 mm cranks in three pairs, 0.3 m rods."""

import math
from dataclasses import replace

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.platforms import load
from otolith.platforms.geometry import Circles
from otolith.platforms.hexapod import Cranks, Hexapod

RADIUS, ROD = 0.05, 0.30


def machine(
    *, push: bool = True, range_deg: float = 60.0, tilt_deg: float = 0.0, seed: int | None = None
) -> Hexapod:
    """A hexapod whose cranks point away from each other within each pair, horizontally at angle 0.

    With a seed, shafts, joints and directions are irregular.
    """
    circles = Circles(
        base_radius_m=0.30, base_half_angle_deg=10.0, platform_radius_m=0.25, platform_half_angle_deg=28.0
    )
    base, joints = circles.points()
    away = np.linalg.norm((joints - base)[0, :2])
    shafts = base - [0.0, 0.0, math.sqrt(ROD**2 - away**2)]
    ahead = np.degrees(np.arctan2(base[:, 1], base[:, 0])) + np.tile([-90.0, 90.0], 3)
    zero, quarter = directions(np.radians(ahead), math.radians(tilt_deg))
    shafts = shafts - RADIUS * zero * [1.0, 1.0, 0.0]
    if seed is not None:
        rng = np.random.default_rng(seed)
        shafts = shafts + rng.uniform(-0.008, 0.008, (6, 3))
        joints = joints + rng.uniform(-0.008, 0.008, (6, 3))
        turn = np.linalg.qr(np.eye(3) + 0.07 * rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.diag(turn))
        zero, quarter = zero @ turn.T, quarter @ turn.T
    arc = RADIUS * math.radians(range_deg)
    if not push:
        quarter = -quarter
    return replace(
        load("davsi").six_legs(),
        joints=joints,
        anchors=shafts,
        cranks=Cranks(zero=zero, quarter=quarter, radius=RADIUS, rod=ROD, push=push),
        stroke=(-arc, arc),
        speed=0.4,
        acceleration=8.0,
    )


def directions(headings: Vec, tilt: float) -> tuple[Mat, Mat]:
    """Unit vectors along cranks with headings [rad], tilted up at angle 0, and a quarter of a turn later."""
    level = np.column_stack([np.cos(headings), np.sin(headings), np.zeros(6)])
    up = np.tile([0.0, 0.0, 1.0], (6, 1))
    return math.cos(tilt) * level + math.sin(tilt) * up, math.cos(tilt) * up - math.sin(tilt) * level
