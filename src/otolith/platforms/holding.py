"""How far six legs may move, whichever way, before a joint could lean too far or a pose could be singular.

Every pose of the legs has a ball in the space of leg lengths in which all poses are proved to hold: no
singular one, no joint beyond its angle. A way is proved by a chain of such balls.

Notation: ℓ leg lengths, x a way through them; J the Jacobian scaled to one unit, σ its singular values, K
`SINGULAR_CONDITION`; w = σ₆ − σ₁/K + 1/K; m the least angle that a joint has to spare. Leg lengths change the
pose by at most dx/σ₆, and σ₆ ≥ w, for σ₁² ≥ ‖J‖²/6 ≥ 1 (every row of J holds a unit vector). Let c₀ and c
bound how fast w and m can change with the pose (`otolith.platforms.reach.change_rates`). Then w w′ ≥ −c₀
and m′ ≥ −c/w, which integrate to w² ≥ w₀² − 2 c₀ x and m ≥ m₀ − c (w₀ − w)/c₀: both hold until

    x = (w₀² − w₁²)/(2 c₀),   w₁ = max(1/K, w₀ − c₀ m₀/c)

The ball about any point of a ball has at least the radius that is left there. Checked by
test_no_pose_in_a_ball_fails_to_hold.
"""

import math
from typing import Final, NamedTuple, Self

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.core.rotation import rotation_of
from otolith.platforms.hexapod import SINGULAR_CONDITION, Hexapod
from otolith.platforms.kinematics import forward, inverse
from otolith.platforms.reach import change_rates

FLOOR: Final = 1e-5  # [m] radius of a ball at which a way ends: so near a limit the legs do not go
STRIDE: Final = 0.9  # of a ball's radius from its centre to the next one's
MOST: Final = 40  # balls in a way; one that needs more leads too near to a limit
CLOSE: Final = 1e-12  # [m] on the legs, when the pose of lengths is found
NEWTON: Final = 30  # iterations; from a place within a ball 2 or 3 do


class Joints(NamedTuple):
    """What the kernels here need of a `Hexapod`, in a form that they can take."""

    joints: Mat  # (6, 3) [m]
    anchors: Mat  # (6, 3) [m]
    axes: Mat  # (6, 3) [-] of the joints, in world at the base, in the platform's frame at the platform
    lean: Vec  # (2,) [rad] most at the base and at the platform; π where the joints set no limit
    rates: Vec  # (3,) [1/m] change of w and of both leans at most, along a scaled motion of the platform
    size: float  # [m] at which rotations are counted as paths

    @classmethod
    def of(cls, hexapod: Hexapod) -> Self:
        """Those of one hexapod."""
        legs = hexapod.joints - hexapod.anchors
        axes = np.tile([0.0, 0.0, 1.0], (6, 1)) if hexapod.upright else legs
        along, about = change_rates(hexapod)
        return cls(
            joints=hexapod.joints,
            anchors=hexapod.anchors,
            axes=axes / np.linalg.norm(axes, axis=1, keepdims=True),
            lean=np.array(hexapod.lean),
            rates=np.hypot(along, about / hexapod.size),
            size=hexapod.size,
        )


class Ball(NamedTuple):
    """Leg lengths about which all poses are proved to hold; its arrays are written in place."""

    centre: Vec  # (6,) [m] leg lengths
    place: Vec  # (7,) of the platform there, see `otolith.core.rotation`
    radius: Vec  # (1,) [m] Euclidean, over the six legs

    @classmethod
    def empty(cls) -> Self:
        """One that is to be placed."""
        return cls(centre=np.zeros(6), place=np.zeros(7), radius=np.zeros(1))


@kernel
def _angle(a: Vec, b: Vec) -> float:
    """Between two vectors (3,) [rad]; by the tangent, which is exact for small angles, too."""
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    return math.atan2(math.sqrt(x * x + y * y + z * z), a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@kernel
def _lean_room(J: Mat, R: Mat, of: Joints) -> tuple[float, int]:
    """Least of m/c over all joints [m of scaled motion], and whose leg it is; infinite without limits."""
    least, leg, axis = math.inf, -1, np.empty(3)
    for i in range(6):
        for k in range(2):
            if of.lean[k] >= math.pi:
                continue
            axis[:] = of.axes[i]
            if k == 1:
                for row in range(3):
                    axis[row] = (
                        R[row, 0] * of.axes[i, 0] + R[row, 1] * of.axes[i, 1] + R[row, 2] * of.axes[i, 2]
                    )
            room = (of.lean[k] - _angle(axis, J[i, :3])) / of.rates[1 + k]
            if room < least:
                least, leg = room, i
    return least, leg


@kernel
def place_ball(lengths: Vec, of: Joints, ball: Ball) -> int:
    """Move the ball to leg lengths (6,), whose pose is near its place, and measure it.

    Returns
    -------
    What bounds it: the leg (0 … 5) whose joint may lean too far first, or −1, a singular pose. The radius is
    0 where the pose does not hold, or is not found.
    """
    ball.centre[:] = lengths
    ball.radius[0] = 0.0
    if forward(lengths, of.joints, of.anchors, ball.place, CLOSE, NEWTON) < 0:
        return -1
    J, R = np.empty((6, 6)), np.empty((3, 3))
    inverse(ball.place, of.joints, of.anchors, np.empty(6), J, np.empty((6, 3)))
    rotation_of(ball.place, R)
    room, leg = _lean_room(J, R, of)
    J[:, 3:] /= of.size
    sigma = np.linalg.svd(J)[1]
    floor = 1.0 / SINGULAR_CONDITION
    w = sigma[5] - sigma[0] * floor + floor
    end = w - of.rates[0] * room
    if end < floor:
        end, leg = floor, -1
    if end < w:
        ball.radius[0] = (w * w - end * end) / (2.0 * of.rates[0])
    return leg


@kernel
def _last_inside(start: Vec, end: Vec, centre: Vec, radius: float) -> float:
    """Share of the way from `start`, which lies in the ball, to `end` at which it leaves it; 1 if never."""
    a, b, c = 0.0, 0.0, -radius * radius
    for i in range(6):
        way, off = end[i] - start[i], start[i] - centre[i]
        a += way * way
        b += way * off
        c += off * off
    if a + 2.0 * b + c <= 0.0:
        return 1.0
    return max(0.0, (math.sqrt(max(b * b - a * c, 0.0)) - b) / a)


@kernel
def way_holds(start: Vec, end: Vec, of: Joints, ball: Ball) -> tuple[bool, int]:
    """True when all poses of the straight way between leg lengths (6,) are proved to hold, its end with room.

    `start` lies in the ball, which goes along: where the way holds, `end` lies in it.

    Returns
    -------
    With it, where it does not hold, what ends it: see `place_ball`.
    """
    at = start.copy()
    for _ in range(MOST):
        left = 0.0
        for i in range(6):
            left += (end[i] - ball.centre[i]) ** 2
        if math.sqrt(left) <= ball.radius[0] - FLOOR:
            return True, -1
        share = _last_inside(at, end, ball.centre, STRIDE * ball.radius[0])
        for i in range(6):
            at[i] += share * (end[i] - at[i])
        why = place_ball(at, of, ball)
        if not ball.radius[0] >= FLOOR:  # a NaN fails every comparison
            return False, why
    return False, why
