"""Jumps in a recorded drive, such as respawns, teleports and crashes, which no vehicle can drive."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.recordings.channels import Channel
from otolith.recordings.checks.witnesses import EARTH
from otolith.recordings.events.event import Event, without

STILL: Final = 0.3  # [m/s] a slower vehicle stands
SPIKE: Final = 20.0  # [m/s²] larger forces at the edge of a jump belong to it
EDGE: Final = 0.3  # [s] before and after a jump in which forces are examined
LEAP: Final = 1.5  # [m/s²] from one row to the next, at least …
USUAL: Final = 8.0  # … and as a multiple of the median step: the forces leap too
SPEED_JUMP: Final = 2.0  # [m/s] between two samples …
SPEED_RATE: Final = 30.0  # [m/s²] … and faster than any braking …
UNEXPLAINED: Final = 0.5  # … and least share that a_x does not explain
PLACE_JUMP: Final = 10.0  # [m] beyond what the speed explains …
PLACE_NOISE: Final = 20.0  # … and as a multiple of the median difference
BACK: Final = 2.0  # [s] within which a stray value returns
RESTING: Final = 1.0  # [s] least time that a vehicle stands after a respawn …
AT_REST: Final = 0.1  # [m/s²] … and largest standard deviation of its forces
BRIDGE: Final = 1.0  # [s] of straight line in place of a jump


def find_jumps(channels: Mapping[str, Channel], strays: Sequence[Event] = ()) -> list[Event]:
    """Find jumps of speed and of position, apart from stray packets.

    They are certainly not driving if the forces leap at the same time or come to rest with the speed.
    Otherwise a sensor of speed or position may have failed, of which the driver felt nothing.
    """
    calm = {key: without(channel, strays) for key, channel in channels.items()}
    return [*_speed_jumps(calm), *_place_jumps(calm)]


def place_of(channels: Mapping[str, Channel]) -> tuple[Vec, Mat] | None:
    """Return times (n,) [s] and positions (n, 2) [m], from x and y or latitude and longitude, if present."""
    if {"x", "y"} <= set(channels):
        x = channels["x"]
        return x.t, np.stack([x.values, channels["y"].on(x.t)], axis=1)
    if not {"lat", "lon"} <= set(channels):
        return None
    lat = channels["lat"]
    lon = np.unwrap(channels["lon"].on(lat.t))
    fix = (lat.values != 0.0) & (lon != 0.0)
    if not fix.any():
        return None
    t, lat_, lon = lat.t[fix], lat.values[fix], lon[fix]
    north, east = EARTH * (lat_ - lat_[0]), EARTH * np.cos(lat_[0]) * (lon - lon[0])
    return t, np.stack([east, north], axis=1)


def _speed_jumps(channels: Mapping[str, Channel]) -> list[Event]:
    """Find changes of speed between two samples that no vehicle reaches and that a_x does not explain."""
    if "vx" not in channels or len(channels["vx"].t) < 3:
        return []
    speed = channels["vx"]
    step, change = np.diff(speed.t), np.diff(speed.values)
    felt = _gain(channels.get("ax"), speed.t)
    wrong = (np.abs(change) > SPEED_JUMP) & (np.abs(change) > SPEED_RATE * step)
    wrong &= np.abs(change - felt) > UNEXPLAINED * np.abs(change)
    events: list[Event] = []
    for i in map(int, np.flatnonzero(wrong)):
        if events and speed.t[i] < events[-1].end:
            continue
        size = f"speed changes by {change[i]:+.3g} m/s in {step[i]:.3g} s"
        size += f" where a_x gives {felt[i]:+.2g} m/s" if "ax" in channels else ""
        events.append(_speed_jump(channels, i, size))
    return events


def _speed_jump(channels: Mapping[str, Channel], i: int, size: str) -> Event:
    """Return the jump after the i-th sample of the speed, with its full duration."""
    speed = channels["vx"]
    start, end = float(speed.t[i]), float(speed.t[i + 1])
    soon = speed.values[i + 2 : speed.within(end, start + BACK).stop]
    back = np.abs(soon - speed.values[i]) < 0.2 * abs(speed.values[i + 1] - speed.values[i])
    if back.any() and not _leaps(channels, start, end):
        end = float(speed.t[i + 2 + np.argmax(back)])
        return Event("stray speed", start, end, size, sure=False, bridge=end - start)
    last = _until_it_moves(speed, i + 1)
    sure = _leaps(channels, start, end) or _rests(channels, end, float(speed.t[last]))
    start, end = _around(channels, start, float(speed.t[last]))
    return Event("jump", start, end, size, sure=sure, bridge=BRIDGE)


def _until_it_moves(speed: Channel, i: int) -> int:
    """Return the index of the first sample after a jump at which the vehicle moves again."""
    if abs(float(speed.values[i])) > STILL:
        return i
    first, length = i, 64
    while first < len(speed.values):  # in growing steps: many jumps may precede one long rest
        moved = np.abs(speed.values[first : first + length] - speed.values[i]) > 0.1
        if moved.any():
            return first + int(np.argmax(moved))
        first, length = first + length, 2 * length
    return i


def _around(channels: Mapping[str, Channel], start: float, end: float) -> tuple[float, float]:
    """Return the times of the last calm force before a jump and the first calm one after it."""
    force = channels.get("ax", channels.get("ay"))
    if force is None:
        return start, end
    near, far = force.within(start - EDGE, start), force.within(end, end + EDGE)
    before = np.flatnonzero(np.abs(force.values[near]) < SPIKE)
    after = np.flatnonzero(np.abs(force.values[far]) < SPIKE)
    # samples farther away count as calm
    last = near.start + int(before[-1]) if len(before) else near.start - 1
    first = far.start + int(after[0]) if len(after) else far.stop
    return (
        float(force.t[last]) if last >= 0 else start,
        float(force.t[first]) if first < len(force.t) else end,
    )


def _leaps(channels: Mapping[str, Channel], start: float, end: float) -> bool:
    """Return whether a_x or a_y leaps from one row to the next at about this time."""
    for key in ("ax", "ay"):
        if key not in channels:
            continue
        force = channels[key]
        near = force.within(start - EDGE, end + EDGE)
        steps = np.abs(np.diff(force.values[max(near.start - 1, 0) : near.stop + 1]))
        if len(steps) and float(steps.max()) > max(LEAP, USUAL * force.change):
            return True
    return False


def _rests(channels: Mapping[str, Channel], start: float, end: float) -> bool:
    """Return whether a vehicle stands after a respawn with constant forces."""
    if end - start < RESTING or "vx" not in channels:
        return False
    forces = [channels[key] for key in ("ax", "ay") if key in channels]
    resting = [one.values[one.within(start, np.nextafter(end, start))] for one in forces]
    return all(len(values) > 2 and float(np.std(values)) < AT_REST for values in resting)


def _place_jumps(channels: Mapping[str, Channel]) -> list[Event]:
    """Find positions that move farther between two samples than the speed explains."""
    place = place_of(channels)
    if place is None:
        return []
    t, xy = place
    # repeated positions are dropped: they catch up in one step
    at = np.r_[0, np.flatnonzero(np.diff(xy, axis=0).any(axis=1)) + 1]
    t, xy = t[at], xy[at]
    way, duration = np.hypot(*np.diff(xy, axis=0).T), np.diff(t)
    if len(way) < 5:
        return []
    usual = np.abs(channels["vx"].on(t[1:])) * duration if "vx" in channels else _usual(way, duration)
    excess = way - usual
    bound = max(PLACE_JUMP, PLACE_NOISE * float(np.median(np.abs(excess))))
    events = []
    for i in np.flatnonzero(excess > bound):
        start, end = float(t[i]), float(t[i + 1])
        size = f"the position jumps by {way[i]:.4g} m in {duration[i]:.3g} s, {excess[i]:.4g} m too far"
        sure = _leaps(channels, start, end)
        around = _around(channels, start, end) if sure else (start, end)
        bridge = BRIDGE if sure else end - start
        events.append(Event("jump" if sure else "stray position", *around, size, sure=sure, bridge=bridge))
    return events


def _usual(way: Vec, duration: Vec) -> Vec:
    """Predict the distance from neighbouring samples, by a median of five speeds, if no speed is recorded."""
    padded = np.pad(way / duration, 2, mode="edge")
    middle = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)
    return np.asarray(middle * duration, dtype=np.float64)


def _gain(ax: Channel | None, t: Vec) -> Vec:
    """Return the change of speed (n-1,) [m/s] that a_x gives between times (n,)."""
    if ax is None:
        return np.zeros(len(t) - 1)
    area = np.r_[0.0, np.cumsum(0.5 * (ax.values[1:] + ax.values[:-1]) * np.diff(ax.t))]
    return np.diff(np.interp(t, ax.t, area))
