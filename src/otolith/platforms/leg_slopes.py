"""How lengths, speeds and accelerations of six legs change with a motion of the platform: exact slopes.

A controller that keeps the legs' limits linearises them about a planned motion. The slopes include what the
speed does to the acceleration of a leg, which at 7.8 m/s² is not small.

Notation: leg i runs from its base joint b_i to the platform's joint, l = p + R a_i − b_i, with length L = |l|
and direction n = l/L. Along a motion (q, v, a) of the pose

    L̇ = n·l̇,   L L̈ = l·l̈ + l̇·l̇ − L̇².

Differentiating these two, with the slopes of l, l̇ and l̈ from the rotation jet (`otolith.core.slopes`), gives
all others. The same holds for any actuator whose coordinate is an implicit function of the joint's place,
such as a crank: only the two equations change. Checked by finite differences and against
`otolith.platforms.kinematics`.
"""

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.core.slopes import point_jet

ROWS = 18  # lengths, speeds, accelerations of six legs; and columns: place, rate and acceleration of six axes


@kernel
def leg_slopes(motion: Mat, jet: Mat, joints: Mat, anchors: Mat, values: Vec, slopes: Mat) -> None:
    """Write lengths, speeds and accelerations (18,) of the legs and their slopes (18, 18).

    Parameters
    ----------
    motion : (3, 6) pose, twist and acceleration of the platform.
    jet : of this motion, from `otolith.core.slopes.rotation_jet`.
    joints, anchors : (6, 3) [m] as of `otolith.platforms.Hexapod`.
    """
    arm = np.empty((4, 3, 3))
    leg = np.empty((3, 3))  # l, l̇, l̈
    slopes[:, :] = 0.0
    for i in range(6):
        point_jet(jet, joints[i], arm)
        for m in range(3):
            for order in range(3):
                leg[order, m] = motion[order, m] + arm[0, order, m]
            leg[0, m] -= anchors[i, m]
        _length(leg, i, values)
        for j in range(6):
            _slopes_of(leg, arm, i, j, values, slopes)


@kernel
def _dot(a: Vec, b: Vec) -> float:
    total: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return total


@kernel
def _length(leg: Mat, i: int, values: Vec) -> None:
    """Write length, speed and acceleration of leg i from l, l̇, l̈ (3, 3)."""
    length = np.sqrt(_dot(leg[0], leg[0]))
    speed = _dot(leg[0], leg[1]) / length
    values[i], values[6 + i] = length, speed
    values[12 + i] = (_dot(leg[0], leg[2]) + _dot(leg[1], leg[1]) - speed * speed) / length


@kernel
def _slopes_of(leg: Mat, arm: Mat, i: int, j: int, values: Vec, slopes: Mat) -> None:
    """Write the slopes of leg i by axis j: of its place, its rate and its acceleration.

    With D = ∂l/∂q_j: D, Ḋ and D̈ are unit vectors and zeros for a translation, and from the jet for an angle.
    """
    D = np.zeros((3, 3))
    if j < 3:
        D[0, j] = 1.0
    else:
        for order in range(3):
            for m in range(3):
                D[order, m] = arm[j - 2, order, m]
    length, speed, growth = values[i], values[6 + i], values[12 + i]
    along = _dot(leg[0], D[0]) / length  # ∂L/∂q
    turning = (_dot(leg[1], D[0]) + _dot(leg[0], D[1]) - speed * along) / length  # ∂L̇/∂q
    slopes[i, j] = slopes[6 + i, 6 + j] = slopes[12 + i, 12 + j] = along
    slopes[6 + i, j] = turning
    slopes[12 + i, 6 + j] = 2.0 * turning
    by_place = _dot(D[0], leg[2]) + _dot(leg[0], D[2]) + 2.0 * _dot(leg[1], D[1])
    slopes[12 + i, j] = (by_place - 2.0 * speed * turning - growth * along) / length
