"""From a run to the curves of its report: plain arrays in the units that people read.

Everything that is drawn, on paper or on a page, comes from here, so both show the same numbers.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.core.frames import DOFS, Dof, specific_force
from otolith.interfaces import Status
from otolith.loop import Run

MAX_POINTS: Final = 5_000  # largest number of points of a curve; three times the pixels of a wide screen

Band = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class PairSeries:
    """The motion of one axis pair: n samples at the plant's rate, tilt in the planar model's sign."""

    pair: Dof
    time: Vec  # (n,) [s]
    reference: Vec  # (n,) [m/s²] specific force to be felt
    felt: Vec  # (n,) [m/s²] specific force felt
    translation: Vec  # (n,) [m/s²] part of the felt force from moving
    gravity: Vec  # (n,) [m/s²] part of the felt force from tilting
    tilt_deg: Vec  # (n,) [deg]
    tilt_rate_deg: Vec  # (n,) [deg/s]
    position: Vec  # (n,) [m]
    velocity: Vec  # (n,) [m/s]
    tilt_band_deg: Band  # limits, low and high
    tilt_rate_band_deg: Band
    position_band: Band
    velocity_band: Band


@dataclass(frozen=True, slots=True, kw_only=True)
class SingleSeries:
    """The motion of heave or yaw: n samples at the plant's rate, in `units`."""

    axis: str
    units: tuple[str, str, str]  # units of what is felt, of the position, of the speed
    time: Vec  # (n,) [s]
    reference: Vec  # (n,) to be felt
    felt: Vec  # (n,)
    place: Vec  # (n,)
    speed: Vec  # (n,)
    place_band: Band
    speed_band: Band


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """The cost of each of m decisions, and which of them are not to be trusted."""

    time: Vec  # (m,) [s]
    period: float  # [s]
    changes: Vec  # (m,) working-set changes
    step_time_us: Vec  # (m,) [µs] thread CPU time
    status: tuple[str, ...]  # (m,)

    def troubled(self) -> dict[str, Ints]:
        """Return the indices of decisions that the algorithm did not make itself, by status."""
        status = np.array(self.status, dtype=object)
        names = sorted(set(self.status) - {Status.DECIDED.value})
        return {name: np.flatnonzero(status == name) for name in names}


def pair_series(run: Run, pair: str) -> PairSeries:
    """Return curves and limits of the axis pair named `pair`."""
    axes = DOFS[pair]
    i, j = axes.translation, axes.rotation
    travel, tilt = run.platform.limits(axes)
    low, high = np.rad2deg(tilt.position)
    rate, speed = float(np.rad2deg(tilt.velocity)), float(travel.velocity)
    # The plants report acceleration in the driver's frame, so what is left of the force is gravity.
    gravity = specific_force(np.zeros((len(run.time), 3)), run.pose[:, 3:])
    return PairSeries(
        pair=axes,
        time=run.time,
        reference=run.reference_force[:, i],
        felt=run.felt_force[:, i],
        translation=run.acceleration[:, i],
        gravity=gravity[:, i],
        tilt_deg=np.rad2deg(axes.sign * run.pose[:, j]),
        tilt_rate_deg=np.rad2deg(axes.sign * run.twist[:, j]),
        position=run.pose[:, i],
        velocity=run.twist[:, i],
        tilt_band_deg=(float(low), float(high)),
        tilt_rate_band_deg=(-rate, rate),
        position_band=(float(travel.position[0]), float(travel.position[1])),
        velocity_band=(-speed, speed),
    )


def single_series(run: Run, axis: str) -> SingleSeries:
    """Return curves and limits of "heave", felt as a force, or "yaw", felt as a rate."""
    dof = DOFS[axis]
    (limits,), (i,) = run.platform.limits(dof), dof.axes
    heaves = not dof.feels_rate
    scale = 1.0 if heaves else float(np.rad2deg(1.0))
    wanted, felt = (run.reference_force, run.felt_force) if heaves else (run.reference_rate, run.felt_rate)
    low, high = limits.position
    speed = scale * limits.velocity
    return SingleSeries(
        axis=axis,
        units=("m/s²", "m", "m/s") if heaves else ("deg/s", "deg", "deg/s"),
        time=run.time,
        reference=scale * wanted[:, dof.felt],
        felt=scale * felt[:, dof.felt],
        place=scale * run.pose[:, i],
        speed=scale * run.twist[:, i],
        place_band=(scale * low, scale * high),
        speed_band=(-speed, speed),
    )


def effort(run: Run) -> Effort:
    """Return cost and status of each decision of `run`."""
    return Effort(
        time=run.command_time,
        period=run.period,
        changes=run.changes.astype(np.float64),
        step_time_us=1e6 * run.step_time,
        status=run.outcomes,
    )


def status_counts(run: Run) -> dict[str, int]:
    """Return the number of decisions of each status, most frequent first."""
    return dict(Counter(run.outcomes).most_common())


def labels(runs: Sequence[Run]) -> tuple[str, ...]:
    """Return a distinct name for each run: its cueing, numbered if several share it."""
    seen: Counter[str] = Counter()
    names = []
    for run in runs:
        seen[run.cueing] += 1
        repeat = seen[run.cueing]
        names.append(run.cueing if repeat == 1 else f"{run.cueing} ({repeat})")
    return tuple(names)


def decimate(x: Vec, y: Vec, limit: int = MAX_POINTS) -> tuple[Vec, Vec]:
    """Return at most `limit` of the points (x, y), in order, that look the same when drawn as a line.

    The points are cut into equal stretches. The lowest and highest of each stretch are kept, and the first
    and last of all, so no peak is lost. NaN remains only if a whole stretch is NaN.
    """
    n = len(y)
    if limit < 4:
        raise ValueError(f"limit is {limit}, must be at least 4")
    if n <= limit:
        return x, y
    length = -(-n // ((limit - 2) // 2))  # points of one stretch, rounded up
    rows = -(-n // length)
    padded = np.pad(y, (0, rows * length - n), mode="edge").reshape(rows, length)
    start = length * np.arange(rows)
    low = start + np.argmin(np.where(np.isnan(padded), np.inf, padded), axis=1)
    high = start + np.argmax(np.where(np.isnan(padded), -np.inf, padded), axis=1)
    keep = np.unique(np.minimum(np.concatenate([[0], low, high, [n - 1]]), n - 1))
    return x[keep], y[keep]


def stairs(time: Vec, counts: Vec, period: float, limit: int = MAX_POINTS) -> tuple[Vec, Vec]:
    """Return the edges of the bars of `counts` and their heights, with the last height repeated.

    If there are more than `limit` decisions, one bar stands for several and shows their maximum.
    """
    m = len(counts)
    if m == 0:
        return np.zeros(0), np.zeros(0)
    starts = np.arange(0, m, -(-m // limit))
    heights = np.maximum.reduceat(counts, starts)
    edges = np.append(time[starts], time[-1] + period)
    return edges, np.append(heights, heights[-1])


def survival(counts: Vec) -> tuple[Vec, Vec]:
    """Return the values k = 0 … max(counts), and the share of counts that are at least k."""
    if len(counts) == 0:
        return np.zeros(0), np.zeros(0)
    frequency = np.bincount(counts.astype(np.int64))
    share = np.cumsum(frequency[::-1])[::-1] / len(counts)
    return np.arange(len(share), dtype=np.float64), share


def extent(*curves: Vec) -> Band:
    """Return the lowest and highest finite value of the curves and zero."""
    values = np.concatenate([[0.0], *curves])
    finite = values[np.isfinite(values)]
    return float(finite.min()), float(finite.max())


def decimated(run: Run) -> bool:
    """Return whether some curve of `run` has more samples than are drawn."""
    return max(len(run.time), len(run.command_time)) > MAX_POINTS
