"""Where six legs can go: along each axis alone, across two axes at once, and how firmly they stand there.

The ranges of single axes are what data sheets print. They are not the workspace: the cuts show how one
axis takes from another. Reach ends where the first of three things happens on the way from the neutral
pose: a leg is at the end of its stroke, a joint leans as far as it may, or the pose is singular.

Notation: l = R a − b a leg, from its anchor b to its joint, a in the neutral pose, both from the reference
point; J the scaled Jacobian, σ its singular values, κ = σ₁/σ₆ < K the condition number and its bound. Along a
translation |l|² is a quadratic of the way, along a rotation by θ it is A − 2ρ cos(θ − φ): the ends of the
strokes have closed forms. For the other two the way is walked in steps that are proved too short to reach
them: angles change by no more than |dl|/|l|, and σ₆ − σ₁/K by no more than (1 + 1/K) ‖dJ‖ (Weyl's
inequality). Checked by test_no_pose_on_the_way_to_an_end_is_out_of_reach.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import scipy  # its modules are imported on first use: none waits for one that it does not need

from otolith.core.arrays import Bools, Mat, Vec
from otolith.core.frames import AXES
from otolith.core.jit import kernel
from otolith.platforms.hexapod import SINGULAR_CONDITION, Hexapod

BEYOND: Final = 1.25  # times the single ranges that a cut shows
CLOSE: Final = 1e-8  # [m or rad] to an end, at which the walk ends
MOST: Final = 20_000  # steps of a walk
SINGULAR: Final = "a singular pose"  # why an end is one, see `End`
CUTS: Final = (
    ("surge", "pitch"),
    ("sway", "roll"),
    ("surge", "sway"),
    ("surge", "heave"),
    ("roll", "pitch"),
    ("heave", "yaw"),
)


class End(NamedTuple):
    """Where the reach of an axis ends, and why."""

    at: float  # [m or rad] with its sign
    why: str  # what ends there, for sentences


@kernel
def leg_end(joints: Mat, anchors: Mat, stroke: tuple[float, float], axis: int, sign: float) -> float:
    """How far [m or rad] one axis goes to one side, of `sign` ±1, until a leg is at the end of its stroke.

    Positive. Zero where the neutral pose is out of the strokes; π where a rotation never ends.
    """
    nearest = math.pi if axis >= 3 else math.inf
    e = np.zeros(3)
    e[axis % 3] = sign
    for i in range(6):
        a, b = joints[i], anchors[i]
        l0, L0 = a - b, 0.0
        for k in range(3):
            L0 += l0[k] * l0[k]
        if not stroke[0] ** 2 <= L0 <= stroke[1] ** 2:  # a NaN fails every comparison
            return 0.0
        for k in range(2):
            B = stroke[k] ** 2
            if axis < 3:
                half = l0[axis] * sign
                root = half * half - L0 + B
                if root >= 0.0:
                    way = -half - math.sqrt(root) if k == 0 else -half + math.sqrt(root)
                    nearest = min(nearest, way) if way >= 0.0 else nearest
            else:
                along = a[axis - 3] * b[axis - 3]
                P = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] - along
                Q = (
                    b[0] * (e[1] * a[2] - e[2] * a[1])
                    + b[1] * (e[2] * a[0] - e[0] * a[2])
                    + b[2] * (e[0] * a[1] - e[1] * a[0])
                )
                rho, phi = math.hypot(P, Q), math.atan2(Q, P)
                cosine = (L0 + 2.0 * P - B) / (2.0 * rho) if rho > 0.0 else 2.0
                if abs(cosine) <= 1.0:
                    turn = math.acos(cosine)
                    for angle in (phi + turn, phi - turn):
                        nearest = min(nearest, angle % (2.0 * math.pi))
    return nearest


def reach_ends(hexapod: Hexapod) -> dict[str, tuple[End, End]]:
    """Lowest and highest end of every axis moving alone from the neutral pose."""
    return {axis: (_end(hexapod, i, -1.0), _end(hexapod, i, 1.0)) for i, axis in enumerate(AXES)}


def reach(hexapod: Hexapod) -> dict[str, tuple[float, float]]:
    """Lowest and highest position [m or rad] of every axis moving alone from the neutral pose."""
    return {axis: (low.at, high.at) for axis, (low, high) in reach_ends(hexapod).items()}


def _end(hexapod: Hexapod, axis: int, sign: float) -> End:
    way = leg_end(hexapod.joints, hexapod.anchors, hexapod.stroke, axis, sign)
    pose, at = np.zeros(6), 0.0
    for _ in range(MOST):
        pose[axis] = sign * at
        spare, why = _spare(hexapod, pose, turning=axis >= 3)
        at += spare
        if at >= way or spare < CLOSE:
            break
    if at < way:
        return End(sign * at, why)
    if axis >= 3 and way == math.pi:
        return End(sign * way, "half a turn")
    pose[axis] = sign * way
    beyond = np.abs(hexapod.lengths(pose)[:, None] - np.array(hexapod.stroke))
    leg, which = np.unravel_index(int(np.argmin(beyond)), beyond.shape)
    return End(sign * way, f"leg {leg + 1} at its {('shortest', 'longest')[which]}")


def _spare(hexapod: Hexapod, pose: Vec, *, turning: bool) -> tuple[float, str]:
    """A way [m or rad] along one axis on which no joint leans too far, nor is a pose singular.

    With it, for sentences, which of the two is next.
    """
    rates = change_rates(hexapod)[1 if turning else 0]
    sigma = np.linalg.svd(hexapod.scaled_jacobians(pose[None])[0], compute_uv=False)
    found = [((sigma[-1] - sigma[0] / SINGULAR_CONDITION) / rates[0], SINGULAR)]
    for k, joint in enumerate(("base", "platform")):
        if hexapod.lean[k] < math.pi:
            leans = hexapod.leans(pose[None])[0, k]
            why = f"leg {int(np.argmax(leans)) + 1} leaning as far as its {joint} joint allows"
            found.append(((hexapod.lean[k] - leans.max()) / rates[1 + k], why))
    spare, why = min(found)
    return max(float(spare), 0.0), why


def change_rates(hexapod: Hexapod) -> Mat:
    """How fast what `_spare` judges can change at most (2, 3), by translation [1/m] and by rotation [1/rad].

    Columns: σ₆ − σ₁/K, a leg's angle at the base, at the platform; while the legs are within their strokes.
    """
    least, size = hexapod.stroke[0], hexapod.size
    arms = np.linalg.norm(hexapod.joints, axis=1)
    moved = np.linalg.norm(np.array([np.ones(6), arms / size])) / least  # of n and r × n
    turned = np.linalg.norm(np.array([arms / least, arms / size * (1.0 + arms / least)]))
    lever = float(arms.max()) / least
    weyl = 1.0 + 1.0 / SINGULAR_CONDITION
    return np.array([[weyl * moved, 1.0 / least, 1.0 / least], [weyl * turned, lever, lever + 1.0]])


def axis_speeds(hexapod: Hexapod) -> Vec:
    """Leg speed (6,) that a speed of 1 m/s or 1 rad/s of each axis needs in the neutral pose."""
    speeds: Vec = np.abs(hexapod.pose_jacobian(np.zeros(6))).max(axis=0)
    return speeds


@dataclass(frozen=True, slots=True, kw_only=True)
class Cut:
    """The workspace across two axes, the other four neutral."""

    axes: tuple[str, str]
    first: Vec  # (n,) [m or rad] of the first axis
    second: Vec  # (m,) of the second
    inside: Bools  # (m, n) whether the pose is in reach, on a way through such poses from the neutral one
    condition: Mat  # (m, n) condition number of the Jacobian, nan outside


def cut(hexapod: Hexapod, axes: tuple[str, str], *, n: int = 81) -> Cut:
    """The workspace across two axes on a grid of n × n poses, a little beyond their single ranges."""
    ranges = reach(hexapod)
    first, second = (np.linspace(BEYOND * ranges[axis][0], BEYOND * ranges[axis][1], n) for axis in axes)
    poses = np.zeros((n, n, 6))
    poses[:, :, AXES.index(axes[0])] = first
    poses[:, :, AXES.index(axes[1])] = second[:, None]
    inside = hexapod.reaches(poses.reshape(-1, 6)).reshape(n, n)
    pieces, _ = scipy.ndimage.label(inside)
    neutral = pieces[int(np.argmin(np.abs(second))), int(np.argmin(np.abs(first)))]
    inside &= pieces == neutral
    condition = np.full((n, n), np.nan)
    condition[inside] = hexapod.conditions(poses[inside])
    return Cut(axes=axes, first=first, second=second, inside=inside, condition=condition)


def box_share(hexapod: Hexapod, box: Mat | None = None, *, samples: int = 20_000, seed: int = 0) -> float:
    """Share of a box of poses that the legs can reach.

    Parameters
    ----------
    box : (6, 2) lowest and highest position [m or rad] of every axis; by default all single ranges, of which
        the share is small, which is the point.
    """
    ranges = np.array(list(reach(hexapod).values())) if box is None else box
    poses = np.random.default_rng(seed).uniform(ranges[:, 0], ranges[:, 1], (samples, 6))
    return float(np.mean(hexapod.reaches(poses)))
