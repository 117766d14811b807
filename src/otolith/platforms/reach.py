"""Where six legs can go: along each axis alone, across two axes at once, and with which conditioning.

The ranges of single axes are those of data sheets. They are not the workspace: the sections show how one axis
reduces the range of another. Reach ends where the first of three events happens on the path from the neutral
pose: a leg is at the end of its stroke, a joint leans as far as it may, or the pose is singular.

Notation: l = R a − b a leg, from its anchor b to its joint, a in the neutral pose, both from the reference
point; J the scaled Jacobian, σ its singular values, κ = σ₁/σ₆ < K the condition number and its bound. Along a
translation |l|² is a quadratic in the distance, along a rotation by θ it is A − 2ρ cos(θ − φ), so the ends of
the strokes have closed forms. For the other events, and for cranks, the path is walked in steps that are
proved too short to reach them: angles change by at most |dl|/|l|, and σ₆ − σ₁/K by at most (1 + 1/K) ‖dJ‖
(Weyl's inequality). Checked by test_no_pose_on_the_way_to_an_end_is_out_of_reach.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import scipy  # scipy imports its modules on first use, so unused ones cost no time

from otolith.core.arrays import Bools, Mat, Vec
from otolith.core.frames import AXES
from otolith.core.jit import kernel
from otolith.platforms.hexapod import DEAD_CENTRE, SINGULAR_CONDITION, Cranks, Hexapod

BEYOND: Final = 1.25  # range of a section relative to the single ranges
CLOSE: Final = 1e-8  # [m or rad] distance to an end at which the walk stops
MOST: Final = 20_000  # largest number of steps of a walk
SINGULAR: Final = "a singular pose"  # a reason of `End`
CUTS: Final = (
    ("surge", "pitch"),
    ("sway", "roll"),
    ("surge", "sway"),
    ("surge", "heave"),
    ("roll", "pitch"),
    ("heave", "yaw"),
)


class End(NamedTuple):
    """The end of an axis's reach, and its reason."""

    at: float  # [m or rad] with its sign
    why: str  # the reason, for messages


@kernel
def leg_end(joints: Mat, anchors: Mat, stroke: tuple[float, float], axis: int, sign: float) -> float:
    """Return how far [m or rad] one axis moves in the direction `sign` until a leg ends its stroke.

    The result is positive. It is zero if the neutral pose is out of the strokes, and π if a rotation never
    ends.
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
    """Return the lowest and highest end of every axis that moves alone from the neutral pose."""
    return {axis: (_end(hexapod, i, -1.0), _end(hexapod, i, 1.0)) for i, axis in enumerate(AXES)}


def reach(hexapod: Hexapod) -> dict[str, tuple[float, float]]:
    """Return the lowest and highest position [m or rad] of every axis, moving alone from neutral."""
    return {axis: (low.at, high.at) for axis, (low, high) in reach_ends(hexapod).items()}


def _end(hexapod: Hexapod, axis: int, sign: float) -> End:
    linear, way = hexapod.cranks is None, math.pi if axis >= 3 else math.inf
    if linear:
        way = leg_end(hexapod.joints, hexapod.anchors, hexapod.stroke, axis, sign)
    pose, at, why = np.zeros(6), 0.0, ""
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
    """Return a distance [m or rad] along one axis on which no joint leans too far and no pose is singular.

    No crank leaves its range or comes to its dead centre on it, either; the strokes of linear legs are not
    considered. The second result names which of these comes next.
    """
    found, follow = list[tuple[float, str]](), 0.0
    if hexapod.cranks is not None:
        lever = float(np.linalg.norm(hexapod.joints, axis=1).max()) if turning else 1.0
        found, follow = _crank_spare(hexapod, hexapod.cranks, pose, lever)
    rates = change_rates(hexapod, follow=follow)[1 if turning else 0]
    sigma = np.linalg.svd(hexapod.scaled_jacobians(pose[None])[0], compute_uv=False)
    found.append(((sigma[-1] - sigma[0] / SINGULAR_CONDITION) / rates[0], SINGULAR))
    for k, joint in enumerate(("base", "platform")):
        if hexapod.lean[k] < math.pi:
            leans = hexapod.leans(pose[None])[0, k]
            why = f"leg {int(np.argmax(leans)) + 1} leaning as far as its {joint} joint allows"
            found.append(((hexapod.lean[k] - leans.max()) / rates[1 + k], why))
    spare, why = min(found)
    return max(float(spare), 0.0), why


def _crank_spare(
    hexapod: Hexapod, cranks: Cranks, pose: Vec, lever: float
) -> tuple[list[tuple[float, str]], float]:
    """Return distances to the ends of the cranks' ranges and to dead centres, and a bound on their speeds.

    On these distances n·t stays above the middle between its value and `DEAD_CENTRE`, so a tip moves at most
    as fast as the platform's joints over this middle, which is the second result.
    """
    arcs, leverages = hexapod.lengths(pose), hexapod.leverages(pose[None])[0]
    least = int(np.argmin(leverages))
    middle = 0.5 * (leverages[least] + DEAD_CENTRE)
    rate = lever * ((1.0 + 1.0 / middle) / cranks.rod + 1.0 / (middle * cranks.radius))
    found = [((leverages[least] - middle) / rate, f"crank {least + 1} near its dead centre")]
    for end, gaps in (("lowest", arcs - hexapod.stroke[0]), ("highest", hexapod.stroke[1] - arcs)):
        i = int(np.argmin(gaps))
        found.append((float(gaps[i]) * middle / lever, f"crank {i + 1} at its {end}"))
    return found, 1.0 / middle


def change_rates(hexapod: Hexapod, *, follow: float = 0.0) -> Mat:
    """Return the largest rates of change (3, 4) of what decides whether a pose holds, for legs within their
    strokes.

    Rows are translation [1/m] and rotation [1/rad] of the platform, and the path [1/m] of the tips of cranks
    (zero for linear legs). Columns are σ₆ − σ₁/K, a leg's angle at the base and at the platform, and n·t of a
    crank.

    Parameters
    ----------
    follow : speed of a tip over that of the platform's joint, where both are counted as the platform's
    motion; with
        0, the first two rows are those of resting tips.
    """
    cranks, size = hexapod.cranks, hexapod.size
    least = hexapod.stroke[0] if cranks is None else cranks.rod
    arms = np.linalg.norm(hexapod.joints, axis=1)
    swing = (1.0 + follow) / least  # of a leg's direction n, over the motion of its upper end
    moved = swing * np.linalg.norm(np.array([np.ones(6), arms / size]))  # of n and r × n
    turned = np.linalg.norm(np.array([arms * swing, arms / size * (1.0 + arms * swing)]))
    lever, weyl = float(arms.max()), 1.0 + 1.0 / SINGULAR_CONDITION
    rates = np.zeros((3, 4))
    rates[0] = weyl * moved, swing, swing, swing
    rates[1] = weyl * turned, lever * swing, lever * swing + 1.0, lever * swing
    if cranks is not None:
        rates[0, 3] += follow / cranks.radius
        rates[1, 3] += lever * follow / cranks.radius
        path = weyl * float(np.hypot(1.0, arms / size).max())
        rates[2] = np.array([path, 1.0, 1.0, 1.0]) / least
        rates[2, 3] += 1.0 / cranks.radius
    return rates


def axis_speeds(hexapod: Hexapod) -> Vec:
    """Return the leg speed (6,) that 1 m/s or 1 rad/s of each axis needs in the neutral pose."""
    speeds: Vec = np.abs(hexapod.pose_jacobian(np.zeros(6))).max(axis=0)
    return speeds


@dataclass(frozen=True, slots=True, kw_only=True)
class Cut:
    """A section of the workspace across two axes, with the other four neutral."""

    axes: tuple[str, str]
    first: Vec  # (n,) [m or rad] of the first axis
    second: Vec  # (m,) of the second
    inside: Bools  # (m, n) whether the pose is in reach, along a path of such poses from the neutral one
    condition: Mat  # (m, n) condition number of the Jacobian, NaN outside


def cut(hexapod: Hexapod, axes: tuple[str, str], *, n: int = 81) -> Cut:
    """Return the workspace across two axes on a grid of n × n poses, somewhat beyond the single ranges."""
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
    """Return the share of a box of poses that the legs can reach.

    Parameters
    ----------
    box : (6, 2) lowest and highest position [m or rad] of every axis; by default all single ranges, of which
        the share is small.
    """
    ranges = np.array(list(reach(hexapod).values())) if box is None else box
    poses = np.random.default_rng(seed).uniform(ranges[:, 0], ranges[:, 1], (samples, 6))
    return float(np.mean(hexapod.reaches(poses)))
