"""How far six legs may move in any direction before a joint could lean too far or a pose become singular.

Every pose of the legs has a ball in the space of leg lengths (of cranks: of arcs) in which all poses are
proved to hold: none is singular, no joint exceeds its angle, and no crank is at its dead centre. A path is
proved by a chain of such balls.

Notation: ℓ leg lengths, x a path length through them; J the Jacobian scaled to one unit, σ its singular
values, K `SINGULAR_CONDITION`; w = σ₆ − σ₁/K + 1/K; m the least margin of a joint's angle, or of n·t from a
crank's dead centre. Leg lengths change
the pose by at most dx/σ₆, and σ₆ ≥ w, because σ₁² ≥ ‖J‖²/6 ≥ 1 (every row of J contains a unit vector). Let
c₀ and c bound how fast w and m can change with the pose (`otolith.platforms.reach.change_rates`). Then w w′ ≥
−c₀ and m′ ≥ −c/w. Integration gives w² ≥ w₀² − 2 c₀ x and m ≥ m₀ − c (w₀ − w)/c₀, so both hold until

    x = (w₀² − w₁²)/(2 c₀),   w₁ = max(1/K, w₀ − c₀ m₀/c)

Cranks move the lower ends of their rods, too: J is that of the rods, dx/σ₆ still bounds the pose's change
because |n·t| ≤ 1, and the tips' own path adds b₀ and b to c₀/w and c/w. While w ≤ w₀, which is the worst
case, these are less than b₀ w₀/w and b w₀/w, so c₀ + b₀ w₀ and c + b w₀ take the place of c₀ and c.

The ball about any point of a ball has at least the radius that remains there. Checked by
test_no_pose_in_a_ball_fails_to_hold.
"""

import math
from typing import Final, NamedTuple, Self

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.jit import kernel
from otolith.core.rotation import rotation_of
from otolith.core.singular_values import extreme_singular_values
from otolith.platforms.hexapod import DEAD_CENTRE, SINGULAR_CONDITION, Hexapod
from otolith.platforms.kinematics import Actuators, forward, inverse
from otolith.platforms.reach import change_rates

FLOOR: Final = 1e-5  # [m] smallest radius of a ball; a path ends this close to a limit
STRIDE: Final = 0.9  # distance from a ball's centre to the next, as a share of its radius
MOST: Final = 40  # largest number of balls in a path; a path that needs more is too close to a limit
CLOSE: Final = 1e-12  # [m] tolerance on leg lengths when their pose is computed
NEWTON: Final = 30  # largest number of iterations; within a ball 2 or 3 suffice


class Joints(NamedTuple):
    """The numbers of a `Hexapod` that the kernels here need."""

    actuators: Actuators
    axes: (
        Mat  # (2, 6, 3) [-] axes of the joints, in world at the base, in the platform's frame at the platform
    )
    lean: Vec  # (2,) [rad] largest angles at the base and at the platform; π if there is no limit
    # [1/m] (2, 4) largest changes of w, of both angles and of n·t: along a scaled motion of the platform, and
    # along the path of a crank's tip
    rates: Mat
    size: float  # [m] radius at which rotations are measured as paths

    @classmethod
    def of(cls, hexapod: Hexapod) -> Self:
        """Return the numbers of one hexapod."""
        axes = np.array(hexapod.joint_axes)
        along, about, driven = change_rates(hexapod)
        return cls(
            actuators=hexapod.actuators,
            axes=axes / np.linalg.norm(axes, axis=2, keepdims=True),
            lean=np.array(hexapod.lean),
            rates=np.array([np.hypot(along, about / hexapod.size), driven]),
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
def _room(J: Mat, leverages: Vec, R: Mat, of: Joints, rates: Vec) -> tuple[float, int]:
    """Return the least m/c of joints and cranks [m of scaled motion], and what has it; see `place_ball`."""
    least, which, axis, cranks = math.inf, -1, np.empty(3), of.actuators.radius > 0.0
    for i in range(6):
        for k in range(2):
            if of.lean[k] >= math.pi:
                continue
            copy_to(axis, of.axes[k, i])
            if k == 1:
                for row in range(3):
                    axis[row] = (
                        R[row, 0] * of.axes[1, i, 0]
                        + R[row, 1] * of.axes[1, i, 1]
                        + R[row, 2] * of.axes[1, i, 2]
                    )
            angle = _angle(axis, J[i, :3])
            if cranks and k == 0:
                angle = abs(0.5 * math.pi - angle)  # from the plane of the crank
            room = (of.lean[k] - angle) / rates[1 + k]
            if room < least:
                least, which = room, i
        if cranks:
            room = (leverages[i] - DEAD_CENTRE) / rates[3]
            if room < least:
                least, which = room, 6 + i
    return least, which


@kernel
def _to_rods(J: Mat, of: Actuators, leverages: Vec) -> None:
    """Turn the Jacobian (6, 6) of cranks into that of their rods; write |n·t| (6,), 1 for linear legs."""
    leverages[:] = 1.0
    if of.radius == 0.0:
        return
    for i in range(6):
        leverages[i] = 1.0 / math.sqrt(J[i, 0] ** 2 + J[i, 1] ** 2 + J[i, 2] ** 2)
        for j in range(6):
            J[i, j] *= of.push * leverages[i]


@kernel
def _least(J: Mat, size: float, floor: float) -> float:
    """Return w, given the Jacobian (6, 6) of the legs, or of their rods."""
    scaled = J.copy()
    for i in range(6):
        for j in range(3, 6):
            scaled[i, j] /= size
    largest, smallest = extreme_singular_values(scaled)
    return smallest - largest * floor + floor


@kernel
def place_ball(lengths: Vec, of: Joints, ball: Ball) -> int:
    """Move the ball to leg lengths (6,), whose pose is near its place, and compute its radius.

    Returns
    -------
    What bounds the ball: the leg (0 … 5) whose joint may lean too far first, 6 more for a crank that may come
    to its dead centre, or −1 for a singular pose. The radius is 0 if the pose does not hold or is not found.
    """
    copy_to(ball.centre, lengths)
    ball.radius[0] = 0.0
    if forward(lengths, of.actuators, ball.place, CLOSE, NEWTON) < 0:
        return -1
    J, R, found, leverages = np.empty((6, 6)), np.empty((3, 3)), np.empty(6), np.empty(6)
    inverse(ball.place, of.actuators, found, J, np.empty((6, 3)))
    for i in range(6):
        if not abs(found[i] - lengths[i]) <= FLOOR:  # the other branch of a crank
            return 6 + i
    rotation_of(ball.place, R)
    _to_rods(J, of.actuators, leverages)
    floor, rates = 1.0 / SINGULAR_CONDITION, np.empty(4)
    w = _least(J, of.size, floor)
    for k in range(4):
        rates[k] = of.rates[0, k] + w * of.rates[1, k]
    room, which = _room(J, leverages, R, of, rates)
    end = w - rates[0] * room
    if end < floor:
        end, which = floor, -1
    if end < w:
        ball.radius[0] = (w * w - end * end) / (2.0 * rates[0])
    return which


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
