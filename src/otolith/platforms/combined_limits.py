"""What surge, sway, roll and pitch can do together on six legs: the largest share of a data sheet.

A data sheet states the range of each axis alone. A controller with a limit per axis needs limits that hold in
every combination. Here each of a platform's three sets of limits (reach, speeds, accelerations) is scaled by
one factor, the largest for which the legs keep their limits whatever the four axes do together.

Notation: a is a joint on the platform and b its anchor, from the reference point; R is the rotation of roll
and pitch. With c = b − R a = (c_h, c_z), the leg at the horizontal position p has the length |p − c|. Over
the disc |p| ≤ r it lies between √(max(|c_h| − r, 0)² + c_z²) and √((|c_h| + r)² + c_z²), and both are
attained. A tilt changes R a by at most |a| times the angle. So a cell of roll × pitch whose centre has that
much margin is proved, and any other cell is divided. Checked by test_no_pose_of_the_share_needs_more_stroke.
That no pose is singular and no joint leans too far is proved in the same way over cells of all four axes,
with the bounds of `otolith.platforms.reach.change_rates`, and so are the ranges of cranks.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.rotation import place_of, rotation_of
from otolith.platforms.axes import Rotation, Translation
from otolith.platforms.hexapod import DEAD_CENTRE, SINGULAR_CONDITION, Hexapod
from otolith.platforms.platform import Platform
from otolith.platforms.reach import change_rates

# Largest number of divisions of a cell; a cell not proved by then counts as out of reach
DIVISIONS: Final = 14
BISECTIONS: Final = 20  # bisections of the share
FEWER: Final = 8  # bisections where each examines thousands of cells
HALVINGS: Final = 8  # largest number of halvings of a cell of four axes
CELLS: Final = 5_000  # largest number of cells at once; a proof that needs more fails
CORNERS: Final = np.array(list(itertools.product((-1.0, 1.0), repeat=4)))
TILTS: Final = 7  # points per side of the grid of tilts over which leg speeds and accelerations are evaluated
PLACES: Final = 24  # points on the edge of the disc, in addition to its centre


@dataclass(frozen=True, slots=True, kw_only=True)
class Together:
    """Shares of a platform's limits that surge, sway, roll and pitch may use at the same time."""

    reach: float  # share of circle and angles
    speed: float  # share of velocities and tilt rates
    acceleration: float | None  # share of accelerations at these speeds; None if the file lacks one

    circle: float  # [m] radius of surge and sway
    tilt: float  # ± [rad] of roll and of pitch
    velocity: float  # ± [m/s] of surge and of sway
    tilt_rate: float  # ± [rad/s]
    translation: float | None  # ± [m/s²] acceleration of surge and of sway
    tilt_acceleration: float | None  # ± [rad/s²]


def _spare(hexapod: Hexapod, circle: float, tilt: Vec) -> float:
    """Return the least distance [m] of a leg from the ends of its stroke over the disc, at (roll, pitch)."""
    place, R = np.empty(7), np.empty((3, 3))
    place_of(np.array([0.0, 0.0, 0.0, tilt[0], tilt[1], 0.0]), place)
    rotation_of(place, R)
    c = hexapod.anchors - hexapod.joints @ R.T
    away = np.hypot(c[:, 0], c[:, 1])
    shortest = np.hypot(np.maximum(away - circle, 0.0), c[:, 2])
    longest = np.hypot(away + circle, c[:, 2])
    low, high = hexapod.stroke
    return float(min(np.min(shortest - low), np.min(high - longest)))


def reaches_all(hexapod: Hexapod, circle: float, tilt: float) -> bool:
    """Return whether it is proved that the legs reach all poses of a disc and of tilts.

    Heave and yaw are neutral.

    Parameters
    ----------
    circle : [m] surge² + sway² ≤ circle².
    tilt : [rad] |roll| ≤ tilt and |pitch| ≤ tilt.
    """
    lever = float(np.max(np.linalg.norm(hexapod.joints, axis=1)))
    cells, half = [np.zeros(2)], tilt
    for _ in range(DIVISIONS):
        spare = [_spare(hexapod, circle, cell) for cell in cells]
        if not min(spare) >= 0.0:
            return False
        doubtful = [cell for cell, s in zip(cells, spare, strict=True) if s < 2.0 * half * lever]
        if not doubtful:
            return True
        half *= 0.5
        corners = [half * np.array(signs) for signs in itertools.product((-1.0, 1.0), repeat=2)]
        cells = [cell + corner for cell in doubtful for corner in corners]
    return False


def holds_all(hexapod: Hexapod, circle: float, tilt: float) -> bool:
    """Return whether it is proved that no pose of a disc and of tilts is singular or leans a joint too far.

    Parameters are those of `reaches_all`, which must hold of linear legs, because the bounds assume that
    they are within their strokes; cranks are proved to stay within their ranges here.
    """
    cells, half = np.zeros((1, 4)), np.array([circle, circle, tilt, tilt])
    for _ in range(HALVINGS):
        poses = np.zeros((len(cells), 6))
        poses[:, [0, 1, 3, 4]] = cells
        margins = _margins(hexapod, poses)
        inside = np.hypot(cells[:, 0], cells[:, 1]) <= circle
        if not np.all(margins[inside] >= 0.0):
            return False
        far, turned = float(np.hypot(half[0], half[1])), float(half[2] + half[3])
        doubtful = cells[~np.all(margins >= _changes(hexapod, margins, far, turned), axis=1)]
        if not len(doubtful):
            return True
        if len(doubtful) > CELLS:
            return False
        half = 0.5 * half
        cells = (doubtful[:, None] + CORNERS * half).reshape(-1, 4)
        cells = cells[np.hypot(*np.maximum(np.abs(cells[:, :2]) - half[:2], 0.0).T) <= circle]
    return False


def _changes(hexapod: Hexapod, margins: Mat, far: float, turned: float) -> Vec:
    """Return how much the margins (5,) can change over a way of so far [m] and so much turned [rad].

    For cranks, n·t is assumed to stay above the middle between the least that is found and `DEAD_CENTRE`,
    which is required of it by infinite changes otherwise (as in `otolith.platforms.reach`).
    """
    follow, spare = 0.0, float(np.nanmin(margins[:, 3], initial=np.inf))
    if hexapod.cranks is not None:
        follow = 1.0 / (DEAD_CENTRE + 0.5 * max(spare, 0.0))
    along, about, _ = change_rates(hexapod, follow=follow)
    lever = float(np.linalg.norm(hexapod.joints, axis=1).max())
    changes = np.append(along * far + about * turned, follow * (far + lever * turned))
    if hexapod.cranks is not None:
        changes[3] += 0.5 * max(spare, 0.0)
    return changes


def _margins(hexapod: Hexapod, poses: Mat) -> Mat:
    """Return the margins of poses (n, 5), in the order of `change_rates`, and of the ranges of cranks [m].

    They are inf for joints without a limit and for what only cranks have, and −inf where a rod does not
    reach.
    """
    arcs = hexapod.lengths(poses)
    found = np.isfinite(arcs).all(axis=1)
    margins, poses = np.full((len(poses), 5), -np.inf), poses[found]
    sigma = np.linalg.svd(hexapod.scaled_jacobians(poses), compute_uv=False)
    margins[found] = np.inf
    margins[found, 0] = sigma[:, -1] - sigma[:, 0] / SINGULAR_CONDITION
    lean = np.array(hexapod.lean)
    if lean.min() < math.pi:
        spare = lean - hexapod.leans(poses).max(axis=2)
        margins[found, 1:3] = np.where(lean < math.pi, spare, np.inf)
    if hexapod.cranks is not None:
        low, high = hexapod.stroke
        margins[found, 3] = hexapod.leverages(poses).min(axis=1) - DEAD_CENTRE
        margins[found, 4] = np.minimum(arcs[found] - low, high - arcs[found]).min(axis=1)
    return margins


def reach_share(hexapod: Hexapod, circle: float, tilt: float) -> float:
    """Return the largest share, at most 1, of a disc [m] and of tilts [rad] that is proved to be in reach."""
    share = 1.0
    if hexapod.cranks is None:  # the closed form of strokes
        share = _largest(lambda s: reaches_all(hexapod, s * circle, s * tilt), share, BISECTIONS)
    return _largest(lambda s: holds_all(hexapod, s * circle, s * tilt), share, FEWER)


def _largest(proved: Callable[[float], bool], most: float, bisections: int) -> float:
    """Return the largest share up to `most` that is proved, by bisection.

    The bisection is valid because every smaller share lies within a proved one.
    """
    if proved(most):
        return most
    low, high = 0.0, most
    for _ in range(bisections):
        share = 0.5 * (low + high)
        low, high = (share, high) if proved(share) else (low, share)
    return low


def _poses(circle: float, tilt: float) -> Mat:
    """Return a grid of poses (n, 6): centre and edge of the disc, with roll and pitch over their square."""
    around = np.linspace(0.0, 2.0 * math.pi, PLACES, endpoint=False)
    places = np.vstack([np.zeros(2), circle * np.column_stack([np.cos(around), np.sin(around)])])
    tilts = np.linspace(-tilt, tilt, TILTS)
    grid = [(*place, 0.0, roll, pitch, 0.0) for place in places for roll in tilts for pitch in tilts]
    return np.array(grid)


def _of_four(line: float, turn: float) -> Vec:
    """Return six values with `line` for surge and sway and `turn` for roll and pitch."""
    return np.array([line, line, 0.0, turn, turn, 0.0])


def _speed_share(hexapod: Hexapod, poses: Mat, speeds: Vec) -> float:
    """Return the largest share of axis speeds (6,), at most 1, that no leg exceeds in any combination."""
    fastest = max(float(np.max(np.abs(hexapod.pose_jacobian(pose)) @ speeds)) for pose in poses)
    return min(1.0, hexapod.speed / fastest)


def _acceleration_share(hexapod: Hexapod, poses: Mat, speeds: Vec, accelerations: Vec) -> float:
    """Return the largest share of axis accelerations (6,), at most 1, that the legs can give at full speed.

    Motion along curved paths uses a part of the legs' acceleration; 0 if it uses all of it.
    """
    signs = [np.array([1.0, a, 0.0, b, c, 0.0]) for a, b, c in itertools.product((-1.0, 1.0), repeat=3)]
    share = 1.0
    for pose in poses:
        curved = np.max(
            [np.abs(hexapod.leg_motion(pose, s * speeds, np.zeros(6)).acceleration) for s in signs], axis=0
        )
        asked = np.abs(hexapod.pose_jacobian(pose)) @ accelerations
        share = min(share, float(np.min((hexapod.acceleration - curved) / asked)))
    return max(share, 0.0)


def together(platform: Platform) -> Together:
    """Return what a platform's legs can do of its file's limits with four axes together.

    Heave and yaw are neutral. Of unequal limits the smaller counts: of the two ends of a range, of surge and
    sway, of roll and pitch, and of the circle if the file has one. Missing tilt rates are replaced by the
    perception thresholds, which cueing respects. The reach is proved; speeds and accelerations are the worst
    over a grid of poses.

    Raises
    ------
    InputError : the file has no legs, or lacks one of the four axes.
    """
    hexapod, given = platform.six_legs(), _limits(platform)
    reach = reach_share(hexapod, given.circle, given.tilt)
    poses = _poses(reach * given.circle, reach * given.tilt)
    fast = _of_four(given.velocity, given.tilt_rate)
    speed = _speed_share(hexapod, poses, fast)
    strong, acceleration = (given.translation, given.tilt_acceleration), None
    if strong[0] is not None and strong[1] is not None:
        acceleration = _acceleration_share(hexapod, poses, speed * fast, _of_four(strong[0], strong[1]))
    return Together(
        reach=reach,
        speed=speed,
        acceleration=acceleration,
        circle=reach * given.circle,
        tilt=reach * given.tilt,
        velocity=speed * given.velocity,
        tilt_rate=speed * given.tilt_rate,
        translation=_times(acceleration, strong[0]),
        tilt_acceleration=_times(acceleration, strong[1]),
    )


def _times(share: float | None, limit: float | None) -> float | None:
    return None if share is None or limit is None else share * limit


def _limits(platform: Platform) -> Together:
    """Return all of a file's limits, with a share of 1."""
    lines = [axis for axis in (platform.surge, platform.sway) if isinstance(axis, Translation)]
    turns = [axis for axis in (platform.roll, platform.pitch) if isinstance(axis, Rotation)]
    if not len(lines) == len(turns) == 2:
        raise InputError(
            f"one of surge, sway, roll and pitch of platform {platform.name}",
            "missing",
            "in its file for what the four can do together",
        )
    thresholds = (platform.tilt_coordination.roll_degps, platform.tilt_coordination.pitch_degps)
    rates = [turn.rate_degps or slow for turn, slow in zip(turns, thresholds, strict=True)]
    turning = [turn.acceleration_degps2 for turn in turns if turn.acceleration_degps2 is not None]
    ends = [abs(end) for line in lines for end in line.position_m]
    return Together(
        reach=1.0,
        speed=1.0,
        acceleration=1.0,
        circle=min(ends if platform.circle is None else [platform.circle, *ends]),
        tilt=math.radians(min(abs(end) for turn in turns for end in turn.angle_deg)),
        velocity=min(line.velocity_mps for line in lines),
        tilt_rate=math.radians(min(rates)),
        translation=min(line.acceleration_mps2 for line in lines),
        tilt_acceleration=math.radians(min(turning)) if len(turning) == 2 else None,
    )
