"""The motion of a platform on a base that itself moves along x and y and turns about the vertical.

Notation: (p, φ) is the platform's pose on the base and (b, ψ) the base's in world, with ψ about z. The
platform's pose in world is (b + Rz(ψ) p, φ + (0 0 ψ)), since yaw is the outermost angle of a pose. With ẑ × p
written p⊥,

    v = ḃ + Rz (ṗ + ψ̇ p⊥),    a = b̈ + Rz (p̈ + 2 ψ̇ ṗ⊥ + ψ̈ p⊥ − ψ̇² p)      in x and y.

Checked by finite differences in tests/core/test_carried.py.
"""

import math

from otolith.core.arrays import Mat
from otolith.core.jit import kernel


@kernel
def carried(motion: Mat, world: Mat) -> None:
    """Write pose, twist and acceleration in world (3, 6) of a motion (6, 6): the platform's, the base's."""
    c, s = math.cos(motion[3, 5]), math.sin(motion[3, 5])
    rate, change = motion[4, 5], motion[5, 5]
    for row in range(3):
        for axis in range(6):
            world[row, axis] = motion[row, axis] + motion[3 + row, axis]
    px, py, vx, vy = motion[0, 0], motion[0, 1], motion[1, 0], motion[1, 1]
    of_v = (vx - rate * py, vy + rate * px)
    of_a = (
        motion[2, 0] - 2.0 * rate * vy - change * py - rate * rate * px,
        motion[2, 1] + 2.0 * rate * vx + change * px - rate * rate * py,
    )
    world[0, 0], world[0, 1] = motion[3, 0] + c * px - s * py, motion[3, 1] + s * px + c * py
    world[1, 0] = motion[4, 0] + c * of_v[0] - s * of_v[1]
    world[1, 1] = motion[4, 1] + s * of_v[0] + c * of_v[1]
    world[2, 0] = motion[5, 0] + c * of_a[0] - s * of_a[1]
    world[2, 1] = motion[5, 1] + s * of_a[0] + c * of_a[1]
