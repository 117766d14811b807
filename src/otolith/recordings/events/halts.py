"""Stretches of a recorded drive in which nothing changes (pauses) or earlier rows repeat (replays)."""

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.recordings.channels import FELT, Channel, held
from otolith.recordings.events.event import Event, apart, inside, stretches, together
from otolith.recordings.events.jumps import BRIDGE, place_of

FROZEN: Final = 0.5  # [s] least duration of values that do not change in the last digit …
HOLDS: Final = 8.0  # … and as a multiple of how long values usually stay (60 Hz written in rows of 250 Hz)
STILL: Final = 0.3  # [m/s², m/s] smaller forces and speeds may truly be constant
GAIN: Final = 0.5  # [m/s] least difference of speed and the integral of a_x in a pause
STEADY: Final = 2.0  # [s] constant forces of this duration are reported without other evidence of a pause
JITTER: Final = 5.0  # [s] before and after a halt in which the noise of the sensor is examined
SENSOR: Final = 1.0  # [m/s, s] least change of speed, and least duration, of a frozen sensor of forces
AROUND: Final = 0.25  # [s] before and after a halt over which positions give the speed, if no channel does …
HARDEST: Final = 10.0  # [m/s²] … and the hardest braking, with which a vehicle may have come to rest there
REPLAY: Final = 1.0  # [s] least duration of rows that repeat earlier ones to the last digit
LEAP: Final = 10.0  # in median steps between rows: a replay begins with a larger leap
_MIX: Final = np.random.default_rng(0).integers(1, 2**63, 64, dtype=np.uint64) | np.uint64(1)


def find_halts(channels: Mapping[str, Channel], strays: Sequence[Event]) -> list[Event]:
    """Find stretches in which everything stands still to the last digit; stray packets do not interrupt them.

    Constant forces are certainly a pause if speed or positions stand still too, in contradiction to the
    forces, or if stray packets arrive in between. Alone they may be a steady manoeuvre.
    """
    t, table = together([channels[key] for key in FELT if key in channels])
    keep = ~inside(t, strays)
    t, table = t[keep], table[keep]
    alive = np.ptp(table, axis=0) > 0.0
    if not alive.any():
        return []
    same = (np.diff(table[:, alive], axis=0) == 0.0).all(axis=1)
    least = max(FROZEN, HOLDS * held(same, t))
    judge = _Judge(channels, t, table)
    halts = [judge.halt(run) for run in stretches(same) if t[run[1]] - t[run[0]] >= least]
    packets = sorted(strays, key=lambda stray: stray.start)
    found = [_with_strays(halt, packets) for halt in halts if halt is not None]
    return [*found, *apart(_frozen_sensors(channels), found)]


def _frozen_sensors(channels: Mapping[str, Channel]) -> list[Event]:
    """Find stretches in which a_x and a_y are constant to the last digit although the speed changes."""
    if not {"ax", "ay", "vx"} <= set(channels):
        return []
    t, table = together([channels["ax"], channels["ay"]])
    same = (np.diff(table, axis=0) == 0.0).all(axis=1)
    judge = _Judge(channels, t, table)
    halts = [judge.halt(run) for run in stretches(same) if t[run[1]] - t[run[0]] >= SENSOR]
    return [halt for halt in halts if halt is not None and halt.kind == "frozen sensor"]


class _Judge:
    """Classifies stretches of constant forces; what all of them share is computed once."""

    def __init__(self, channels: Mapping[str, Channel], t: Vec, table: Mat) -> None:
        self._channels, self._t, self._table = channels, t, table
        self._place = place_of(channels)
        if self._place is not None:
            at, xy = self._place
            self._updates = held((np.diff(xy, axis=0) == 0.0).all(axis=1), at)  # of the position [s]

    def halt(self, run: tuple[int, int]) -> Event | None:
        """Classify a stretch of constant forces; None if the vehicle drives steadily or stands."""
        t, ax = self._t, self._channels.get("ax")
        start, end, after = float(t[run[0]]), float(t[run[1]]), float(t[min(run[1] + 1, len(t) - 1)])
        length, row = f"all forces unchanged for {end - start:.3g} s", float(t[run[0] + 1] - t[run[0]])
        gain = 0.0 if ax is None else float(ax.on(np.array([start]))[0]) * (end - start)
        if "vx" in self._channels:
            change, frozen = _change_of_speed(self._channels["vx"], start, end)
            if frozen and abs(change - gain) > GAIN:
                size = f"{length}, speed too, where a_x makes {gain:+.3g} m/s"
                return Event("pause", start, after, size, bridge=row)
            if change != 0.0 and abs(change - gain) > SENSOR and end - start > SENSOR:
                size = f"{length} while the speed changes by {change:+.3g} m/s"
                return Event("frozen sensor", start, after, size, bridge=row)
            if ax is not None and not self._jitters(run):
                return None  # speed and force agree: a steady manoeuvre
        standing = self._standing_at(start, end)
        if standing > 1.0:
            return Event("pause", start, after, f"{length}, positions too, at {standing:.3g} m/s", bridge=row)
        speed = abs(float(self._channels["vx"].on(np.array([start]))[0])) if "vx" in self._channels else None
        if speed is not None and speed < STILL:
            return None  # the vehicle stands
        held_still = Event("held", start, after, length, sure=False, bridge=row)
        return self._uncontradicted(held_still, run, moving=speed is not None)

    def _uncontradicted(self, event: Event, run: tuple[int, int], *, moving: bool) -> Event | None:
        """Classify a stretch of constant forces that neither speed nor positions contradict."""
        calm = float(np.abs(self._table[run[0]]).max()) < STILL
        if self._jitters(run):
            size = f"{event.size}, of a sensor that jitters otherwise"
            if calm and not moving:
                return replace(event, size=f"{size}; or it stands there")
            return replace(event, kind="pause", size=size, sure=True)
        return None if calm or self._t[run[1]] - event.start < STEADY else event

    def _jitters(self, run: tuple[int, int]) -> bool:
        """Return whether a force goes up and down from row to row about a stretch, like a real sensor's."""
        first = np.searchsorted(self._t, self._t[run[0]] - JITTER)
        last = np.searchsorted(self._t, self._t[run[1]] + JITTER, side="right")
        around = np.r_[self._table[first : run[0]], self._table[run[1] + 1 : last]]
        steps = np.diff(around, axis=0)
        if len(steps) < 20:
            return False
        if (steps == 0.0).all(axis=1).mean() > 0.05:
            return False  # a coarse sensor, whose values often repeat
        back = (steps[1:] * steps[:-1] < 0.0).mean(axis=0)
        return bool(back.max() > 0.3)

    def _standing_at(self, start: float, end: float) -> float:
        """Return the stated speed [m/s] while positions stand still; zero if the positions move."""
        if self._place is None or end - start < 2.0 * self._updates:
            return 0.0
        t, xy = self._place
        still = xy[np.searchsorted(t, start) : np.searchsorted(t, end, side="right")]
        if len(still) < 2 or float(np.ptp(still, axis=0).max()) > 0.0:
            return 0.0
        if "vx" in self._channels:
            return abs(float(self._channels["vx"].on(np.array([start]))[0]))
        around, after = max(AROUND, 4.0 * self._updates), end + self._updates
        pace = min(_pace(t, xy, start - around, start), _pace(t, xy, after, after + around))
        return pace if pace > HARDEST * around else 0.0


def _pace(t: Vec, xy: Mat, start: float, end: float) -> float:
    """Return the speed [m/s] between the first and last position in an interval; zero if there are none."""
    first, last = int(np.searchsorted(t, start)), int(np.searchsorted(t, end, side="right")) - 1
    return float(np.hypot(*(xy[last] - xy[first])) / (t[last] - t[first])) if last > first else 0.0


def _with_strays(halt: Event, strays: Sequence[Event]) -> Event:
    """Classify a halt as a certain pause if stray packets, sorted by time, interrupt it."""
    first, last = (
        bisect_left(strays, time, key=lambda stray: stray.start) for time in (halt.start, halt.end)
    )
    count = sum(stray.end <= halt.end for stray in strays[first:last])
    if not count:
        return halt
    packets = "one stray packet" if count == 1 else f"{count} stray packets"
    return replace(halt, kind="pause", sure=True, size=f"{halt.size}, with {packets} in between")


def _change_of_speed(speed: Channel, start: float, end: float) -> tuple[float, bool]:
    """Return the change of speed in a stretch [m/s], and whether it is constant to the last digit."""
    before, after = speed.on(np.array([start, end]))
    values = speed.values[speed.within(start, end)]
    still = len(values) > 1 and float(np.ptp(values)) == 0.0
    still = still and end - start > 2.0 * speed.held  # a slowly sampled speed is constant between its samples
    return float(after - before), still


def find_replays(felt: Sequence[Channel]) -> list[Event]:
    """Find rows that repeat earlier ones to the last digit for at least a second, after a leap.

    Without the condition of a leap, every periodic signal would be a replay.
    """
    t, table = together(felt)
    if len(t) < 4 or np.count_nonzero(np.ptp(table, axis=0)) < 2:
        return []  # a single periodic signal repeats itself
    lag = _lags(table)
    steps = np.abs(np.diff(table, axis=0)).max(axis=1)
    far = max(LEAP * float(np.median(steps)), STILL)
    events = []
    for first, last in stretches(lag > 0):
        if first == 0 or steps[first - 1] <= far or t[last - 1] - t[first] < REPLAY:
            continue
        usual = int(np.median(lag[first:last]))
        if float(np.mean(lag[first:last] == usual)) > 0.9:
            end = min(last + 2, len(t) - 1)  # each lag belongs to three rows
            size = f"rows of {t[first - usual]:.5g} s on come again"
            events.append(
                Event("replay", float(t[first - 1]), float(t[end]), size, sure=False, bridge=BRIDGE)
            )
    return events


def _lags(table: Mat) -> Ints:
    """Return how many rows earlier each three rows (n-2,) occurred before; zero where they are new.

    Three changing rows are compared, because one row alone repeats by chance and held values repeat
    themselves.
    """
    bits = np.ascontiguousarray(table + 0.0).view(np.uint64)  # adding zero makes -0.0 and 0.0 equal
    row = (bits * _MIX[: bits.shape[1]]).sum(axis=1, dtype=np.uint64)
    three = row[:-2] * _MIX[61] + row[1:-1] * _MIX[62] + row[2:] * _MIX[63]
    _, first, which = np.unique(three, return_index=True, return_inverse=True)
    lag = np.arange(len(three)) - first[which]
    changing = (row[:-2] != row[1:-1]) & (row[1:-1] != row[2:])
    return np.asarray(np.where(changing, lag, 0), dtype=np.int64)
