"""How far six legs may move in any direction before a joint could lean too far or a pose become singular.

Every pose of the legs has a ball in the space of leg lengths in which all poses are proved to hold: none is
singular, and no joint exceeds its angle. A path is proved by a chain of such balls.

Notation: ℓ leg lengths, x a path length through them; J the Jacobian scaled to one unit, σ its singular
values, K `SINGULAR_CONDITION`; w = σ₆ − σ₁/K + 1/K; m the least margin of a joint's angle. Leg lengths change
the pose by at most dx/σ₆, and σ₆ ≥ w, because σ₁² ≥ ‖J‖²/6 ≥ 1 (every row of J contains a unit vector). Let
c₀ and c bound how fast w and m can change with the pose (`otolith.platforms.reach.change_rates`). Then w w′ ≥
−c₀ and m′ ≥ −c/w. Integration gives w² ≥ w₀² − 2 c₀ x and m ≥ m₀ − c (w₀ − w)/c₀, so both hold until

    x = (w₀² − w₁²)/(2 c₀),   w₁ = max(1/K, w₀ − c₀ m₀/c)

The ball about any point of a ball has at least the radius that remains there. Checked by
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

FLOOR: Final = 1e-5  # [m] smallest radius of a ball; a path ends this close to a limit
STRIDE: Final = 0.9  # distance from a ball's centre to the next, as a share of its radius
MOST: Final = 40  # largest number of balls in a path; a path that needs more is too close to a limit
CLOSE: Final = 1e-12  # [m] tolerance on leg lengths when their pose is computed
NEWTON: Final = 30  # largest number of iterations; within a ball 2 or 3 suffice


class Joints(NamedTuple):
    """The numbers of a `Hexapod` that the kernels here need."""

    joints: Mat  # (6, 3) [m]
    anchors: Mat  # (6, 3) [m]
    axes: Mat  # (6, 3) [-] axes of the joints, in world at the base, in the platform's frame at the platform
    lean: Vec  # (2,) [rad] largest angles at the base and at the platform; π if there is no limit
    rates: Vec  # (3,) [1/m] largest changes of w and of both angles along a scaled motion of the platform
    size: float  # [m] radius at which rotations are measured as paths

    @classmethod
    def of(cls, hexapod: Hexapod) -> Self:
        """Return the numbers of one hexapod."""
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
    """Leg lengths around which all poses are proved to hold; its arrays are written in place."""

    centre: Vec  # (6,) [m] leg lengths
    place: Vec  # (7,) position and orientation of the platform there, see `otolith.core.rotation`
    radius: Vec  # (1,) [m] Euclidean distance of leg lengths

    @classmethod
    def empty(cls) -> Self:
        """Return a ball that has yet to be placed."""
        return cls(centre=np.zeros(6), place=np.zeros(7), radius=np.zeros(1))


@kernel
def _angle(a: Vec, b: Vec) -> float:
    """Return the angle between two vectors (3,) [rad], by the tangent, which is exact for small angles."""
    x, y, z = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    return math.atan2(math.sqrt(x * x + y * y + z * z), a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


@kernel
def _lean_room(J: Mat, R: Mat, of: Joints) -> tuple[float, int]:
    """Return the least m/c over all joints [m of scaled motion], and its leg; infinite without limits."""
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
    """Move the ball to leg lengths (6,), whose pose is near its place, and compute its radius.

    Returns
    -------
    What bounds the ball: the leg (0 … 5) whose joint may lean too far first, or −1 for a singular pose. The
    radius is 0 if the pose does not hold or is not found.
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
    """Return the share of the path from `start`, inside the ball, to `end` at which it leaves; 1 if never."""
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
    """Return whether all poses on the straight path between leg lengths (6,) are proved to hold, with margin.

    `start` must lie in the ball, which moves along: if the path holds, `end` lies in it.

    Returns
    -------
    Whether the path holds and, if not, what ends it: see `place_ball`.
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
