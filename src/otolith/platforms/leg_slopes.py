"""How coordinates, speeds and accelerations of six legs change with a motion of the platform: exact slopes.

A controller that keeps the limits of legs, linear or on cranks, linearises them about a planned motion. The
slopes include what the speed does to the acceleration of a leg, which at 7.8 m/s² is not small.

Notation: leg i runs from its base joint, or its crank's tip b, to the platform's joint, l = p + R a_i − b.
Along a motion (q, v, a) of the pose the length L = |l| of a linear leg has

    L L̇ = l·l̇,   L L̈ = l·l̈ + l̇·l̇ − L̇²;

of a crank (`otolith.platforms.kinematics`: arc s, radius ρ, e along the crank, t = e′ along its tip's path)
the tip has b′ = t and b″ = −e/ρ, so that |l| = d, the rod, gives with P = l + b

    (l·t) ṡ = l·Ṗ,   (l·t) s̈ = l̇·l̇ + l·P̈ + (l·e) ṡ²/ρ.

Differentiating these equations, with the slopes of P, Ṗ and P̈ from the rotation jet (`otolith.core.slopes`),
gives all others. Checked by finite differences and against `otolith.platforms.kinematics`.
"""

import math

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import jit_inner, kernel
from otolith.core.slopes import point_jet
from otolith.platforms.kinematics import Actuators, arc

ROWS = (
    18  # coordinates, speeds, accelerations of six legs; and columns: place, rate, acceleration of six axes
)


@kernel
def leg_slopes(motion: Mat, jet: Mat, of: Actuators, values: Vec, slopes: Mat) -> None:
    """Write coordinates, speeds and accelerations (18,) of the legs and their slopes (18, 18).

    Parameters
    ----------
    motion : (3, 6) pose, twist and acceleration of the platform.
    jet : of this motion, from `otolith.core.slopes.rotation_jet`.
    of : the geometry, from `otolith.platforms.hexapod.Hexapod.actuators`.
    """
    moves, leg = np.zeros((7, 3, 3)), np.empty((5, 3))  # l, l̇, l̈, and e and t of a crank
    for j in range(3):
        moves[j, 0, j] = 1.0
    slopes[:, :] = 0.0
    for i in range(6):
        point_jet(jet, of.places[0, i], moves[3:])
        for m in range(3):
            for order in range(3):
                leg[order, m] = motion[order, m] + moves[3, order, m]
            leg[0, m] -= of.places[1, i, m]
        if of.radius > 0.0:
            _arc(leg, of, i, values)
        else:
            _length(leg, i, values)
        for j in range(6):  # ∂P/∂q_j, in time: unit vectors for a translation, from the jet for an angle
            D = moves[j if j < 3 else j + 1]
            if of.radius > 0.0:
                _slopes_of_crank(leg, D, of.radius, i, j, values, slopes)
            else:
                _slopes_of(leg, D, i, j, values, slopes)


@jit_inner
def _dot(a: Vec, b: Vec) -> float:
    total: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return total


@jit_inner
def _length(leg: Mat, i: int, values: Vec) -> None:
    """Write length, speed and acceleration of leg i from l, l̇, l̈ (3, 3)."""
    length = np.sqrt(_dot(leg[0], leg[0]))
    speed = _dot(leg[0], leg[1]) / length
    values[i], values[6 + i] = length, speed
    values[12 + i] = (_dot(leg[0], leg[2]) + _dot(leg[1], leg[1]) - speed * speed) / length


@jit_inner
def _arc(leg: Mat, of: Actuators, i: int, values: Vec) -> None:
    """Write the motion of crank i and its e and t, given P − o, Ṗ and P̈, which become l, l̇ and l̈."""
    e, t = leg[3], leg[4]
    values[i] = arc(of, i, leg[0, 0], leg[0, 1], leg[0, 2])
    c, s = math.cos(values[i] / of.radius), math.sin(values[i] / of.radius)
    for m in range(3):
        e[m] = c * of.places[2, i, m] + s * of.places[3, i, m]
        t[m] = c * of.places[3, i, m] - s * of.places[2, i, m]
        leg[0, m] -= of.radius * e[m]
    push, bend = _dot(leg[0], t), _dot(leg[0], e) / of.radius
    speed = _dot(leg[0], leg[1]) / push
    for m in range(3):
        leg[1, m] -= speed * t[m]
    growth = (_dot(leg[1], leg[1]) + _dot(leg[0], leg[2]) + bend * speed * speed) / push
    for m in range(3):
        leg[2, m] -= growth * t[m] - speed * speed * e[m] / of.radius
    values[6 + i], values[12 + i] = speed, growth


@jit_inner
def _slopes_of(leg: Mat, D: Mat, i: int, j: int, values: Vec, slopes: Mat) -> None:
    """Write the slopes of place, rate and acceleration of leg i by axis j; D (3, 3) is ∂P/∂q_j, Ḋ, D̈."""
    length, speed, growth = values[i], values[6 + i], values[12 + i]
    along = _dot(leg[0], D[0]) / length  # ∂L/∂q
    turning = (_dot(leg[1], D[0]) + _dot(leg[0], D[1]) - speed * along) / length  # ∂L̇/∂q
    by_place = _dot(D[0], leg[2]) + _dot(leg[0], D[2]) + 2.0 * _dot(leg[1], D[1])
    by_place = (by_place - 2.0 * speed * turning - growth * along) / length
    _enter(along, turning, by_place, i, j, slopes)


@kernel
def _slopes_of_crank(leg: Mat, D: Mat, radius: float, i: int, j: int, values: Vec, slopes: Mat) -> None:
    """Write the slopes of place, rate and acceleration of crank i by axis j; D (3, 3) is ∂P/∂q_j, Ḋ, D̈."""
    e, t, by, moving = leg[3], leg[4], np.empty(3), np.empty(3)  # … ∂l/∂q, ∂l̇/∂q
    speed, growth = values[6 + i], values[12 + i]
    push, bend = _dot(leg[0], t), _dot(leg[0], e) / radius
    along = _dot(leg[0], D[0]) / push  # ∂s/∂q
    for m in range(3):
        by[m] = D[0, m] - t[m] * along
    turning = (_dot(leg[1], by) + _dot(leg[0], D[1]) + bend * speed * along) / push  # ∂ṡ/∂q
    for m in range(3):
        moving[m] = D[1, m] - t[m] * turning + e[m] * speed * along / radius
    by_place = 2.0 * _dot(leg[1], moving) + _dot(leg[2], by) + _dot(leg[0], D[2])
    by_place = (by_place + bend * (2.0 * speed * turning + growth * along)) / push
    by_place += speed * speed * along / radius**2
    _enter(along, turning, by_place, i, j, slopes)


@jit_inner
def _enter(along: float, turning: float, by_place: float, i: int, j: int, slopes: Mat) -> None:
    """Enter what all actuators share: by speed, by acceleration, and by place."""
    slopes[i, j] = slopes[6 + i, 6 + j] = slopes[12 + i, 12 + j] = along
    slopes[6 + i, j] = turning
    slopes[12 + i, 6 + j] = 2.0 * turning
    slopes[12 + i, j] = by_place
