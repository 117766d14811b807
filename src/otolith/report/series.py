"""From a run to the curves of its report: plain arrays in the units that people read.

Everything that is drawn, on paper or on a page, comes from here, so both show the same numbers.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import DOFS, Dof, specific_force
from otolith.interfaces import Status
from otolith.loop import Run

MAX_POINTS: Final = 5_000  # largest number of points of a curve; three times the pixels of a wide screen

Band = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Line:
    """A quantity over time, with at most `MAX_POINTS` points that look like all samples of the run."""

    x: Vec  # (k,) [s]
    y: Vec  # (k,)


@dataclass(frozen=True, slots=True, kw_only=True)
class PairSeries:
    """The motion of one axis pair over time, tilt in the planar model's sign."""

    pair: Dof
    reference: Line  # [m/s²] specific force to be felt
    felt: Line  # [m/s²] specific force felt
    translation: Line  # [m/s²] part of the felt force from moving
    gravity: Line  # [m/s²] part of the felt force from tilting
    tilt_deg: Line  # [deg]
    tilt_rate_deg: Line  # [deg/s]
    position: Line  # [m]
    velocity: Line  # [m/s]
    tilt_band_deg: Band  # limits, low and high
    tilt_rate_band_deg: Band
    position_band: Band
    velocity_band: Band
    base: Line | None = None  # [m/s²] part of the felt force from the base that carries the platform


@dataclass(frozen=True, slots=True, kw_only=True)
class BaseSeries:
    """The motion over time of one axis of the base that carries the platform, in `units`."""

    units: tuple[str, str]  # units of place and speed
    place: Line
    speed: Line
    place_band: Band
    speed_band: Band


@dataclass(frozen=True, slots=True, kw_only=True)
class SingleSeries:
    """The motion of heave or yaw over time, in `units`."""

    axis: str
    units: tuple[str, str, str]  # units of what is felt, of the position, of the speed
    reference: Line  # to be felt
    felt: Line
    place: Line
    speed: Line
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

    def lines(part: Run) -> dict[str, Vec]:
        pose, twist = part.pose, part.twist
        return {
            "reference": part.reference_force[:, i],
            "felt": part.felt_force[:, i],
            "translation": part.acceleration[:, i],
            # The plants report acceleration in the driver's frame, so what is left of the force is gravity.
            "gravity": specific_force(np.zeros((len(pose), 3)), pose[:, 3:])[:, i],
            "tilt_deg": np.rad2deg(axes.sign * pose[:, j]),
            "tilt_rate_deg": np.rad2deg(axes.sign * twist[:, j]),
            "position": pose[:, i],
            "velocity": twist[:, i],
            **({} if part.base is None else {"base": part.base[:, 12 + i]}),
        }

    return PairSeries(
        **thinned(run, lines),
        pair=axes,
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
    low, high = limits.position
    speed = scale * limits.velocity

    def lines(part: Run) -> dict[str, Vec]:
        force, rate = (part.reference_force, part.felt_force), (part.reference_rate, part.felt_rate)
        wanted, felt = force if heaves else rate
        return {
            "reference": scale * wanted[:, dof.felt],
            "felt": scale * felt[:, dof.felt],
            "place": scale * part.pose[:, i],
            "speed": scale * part.twist[:, i],
        }

    return SingleSeries(
        **thinned(run, lines),
        axis=axis,
        units=("m/s²", "m", "m/s") if heaves else ("deg/s", "deg", "deg/s"),
        place_band=(scale * low, scale * high),
        speed_band=(-speed, speed),
    )


def base_series(run: Run, name: str) -> BaseSeries | None:
    """Return curves and limits of the base's axis that carries a degree of freedom; None if there is none."""
    carriers = run.platform.bases([DOFS[name]])
    if run.base is None or not carriers:
        return None
    (limits,), i = run.platform.limits(carriers[0]), carriers[0].axes[0] % 6
    scale = float(np.rad2deg(1.0)) if carriers[0].feels_rate else 1.0
    unit = "deg" if carriers[0].feels_rate else "m"

    def lines(part: Run) -> dict[str, Vec]:
        motion = np.zeros((part.samples, 18)) if part.base is None else part.base
        return {"place": scale * motion[:, i], "speed": scale * motion[:, 6 + i]}

    return BaseSeries(
        **thinned(run, lines),
        units=(unit, f"{unit}/s"),
        place_band=(scale * limits.position[0], scale * limits.position[1]),
        speed_band=(-scale * limits.velocity, scale * limits.velocity),
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
    length = _stretch(len(y), limit)
    if length == 1:
        return x, y
    keep = _kept(y, length, first=True, last=True)
    return x[keep], y[keep]


def thinned(run: Run, lines: Callable[[Run], Mapping[str, Vec]], limit: int = MAX_POINTS) -> dict[str, Line]:
    """Return quantities of a run over time, with those points of each that `decimate` keeps.

    The run is read part by part, so only these points of a long run are in memory.

    Parameters
    ----------
    lines : gives the quantities (n,) of a part by name.
    """
    length, left, first = _stretch(run.samples, limit), run.samples, True
    rest: dict[str, Vec] = {}  # samples of a stretch that ends in the next part
    kept: dict[str, list[Mat]] = {}
    for part in run.parts():
        found = {"": part.time, **lines(part)}
        series = {name: np.concatenate([rest.get(name, one[:0]), one]) for name, one in found.items()}
        left, count = left - part.samples, len(series[""])
        whole = count - count % length if left else count
        for name, values in series.items():
            keep = _kept(values[:whole], length, first=first, last=not left)
            kept.setdefault(name, []).append(np.stack([series[""][keep], values[keep]]))
        first = first and not whole
        rest = {name: values[whole:] for name, values in series.items()}
    return {name: Line(*np.concatenate(parts, axis=1)) for name, parts in kept.items() if name}


def _stretch(n: int, limit: int) -> int:
    """Return how many of n points are represented by two, so that at most `limit` remain; 1 keeps all."""
    if limit < 4:
        raise ValueError(f"limit is {limit}, must be at least 4")
    return 1 if n <= limit else -(-n // ((limit - 2) // 2))


def _kept(y: Vec, length: int, *, first: bool, last: bool) -> Ints:
    """Return the indices of the lowest and highest of every stretch of points, and of the ends if asked."""
    n = len(y)
    rows = -(-n // length)
    padded = np.pad(y, (0, rows * length - n), mode="edge").reshape(rows, length) if n else np.zeros((0, 1))
    start = length * np.arange(rows)
    low = start + np.argmin(np.where(np.isnan(padded), np.inf, padded), axis=1)
    high = start + np.argmax(np.where(np.isnan(padded), -np.inf, padded), axis=1)
    ends = [0] * (first and n > 0) + [n - 1] * (last and n > 0)
    return np.unique(np.minimum(np.concatenate([low, high, np.array(ends, dtype=np.int64)]), n - 1))


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
    return max(run.samples, run.decisions) > MAX_POINTS
