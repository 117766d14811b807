"""Jumps in a recorded drive: respawns, teleports, crashes, which nothing can drive."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.recordings.channels import Channel
from otolith.recordings.checks.witnesses import EARTH
from otolith.recordings.events.event import Event, without

STILL: Final = 0.3  # [m/s] as good as standing
SPIKE: Final = 20.0  # [m/s²] at the edge of a jump: part of it
EDGE: Final = 0.3  # [s] for which forces are looked at about a jump
LEAP: Final = 1.5  # [m/s²] from one row to the next, at least …
USUAL: Final = 8.0  # … and so many times the usual step: the forces leap, too
SPEED_JUMP: Final = 2.0  # [m/s] between two samples …
SPEED_RATE: Final = 30.0  # [m/s²] … and faster than any braking …
UNEXPLAINED: Final = 0.5  # … and not explained by a_x to this share
PLACE_JUMP: Final = 10.0  # [m] beyond what the speed explains …
PLACE_NOISE: Final = 20.0  # … and so many times the usual disagreement
BACK: Final = 2.0  # [s] within which a value that is astray comes back
RESTING: Final = 1.0  # [s] for which a vehicle stands after a respawn …
AT_REST: Final = 0.1  # [m/s²] … and its forces hardly vary
BRIDGE: Final = 1.0  # [s] of straight line in place of a jump


def find_jumps(channels: Mapping[str, Channel], strays: Sequence[Event] = ()) -> list[Event]:
    """Jumps of speed and of place, besides stray packets.

    They are no driving for sure where the forces leap at the same time or come to rest with the speed; else a
    sensor of speed or position may have gone astray, of which the driver felt nothing.
    """
    calm = {key: without(channel, strays) for key, channel in channels.items()}
    return [*_speed_jumps(calm), *_place_jumps(calm)]


def place_of(channels: Mapping[str, Channel]) -> tuple[Vec, Mat] | None:
    """Times (n,) [s] and positions (n, 2) [m], of x and y or of latitude and longitude, if they are there."""
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
    """Speed that changes from one sample to the next as nothing could, and not as a_x says."""
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
    """The jump after the i-th sample of the speed, as long as it lasts."""
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
    """Index of the first sample after a jump at which the vehicle no longer stands as it was put down."""
    if abs(float(speed.values[i])) > STILL:
        return i
    first, length = i, 64
    while first < len(speed.values):  # a little at a time: many jumps may lie before a long rest
        moved = np.abs(speed.values[first : first + length] - speed.values[i]) > 0.1
        if moved.any():
            return first + int(np.argmax(moved))
        first, length = first + length, 2 * length
    return i


def _around(channels: Mapping[str, Channel], start: float, end: float) -> tuple[float, float]:
    """The last calm sample of the forces before a jump and the first one after it."""
    force = channels.get("ax", channels.get("ay"))
    if force is None:
        return start, end
    near, far = force.within(start - EDGE, start), force.within(end, end + EDGE)
    before = np.flatnonzero(np.abs(force.values[near]) < SPIKE)
    after = np.flatnonzero(np.abs(force.values[far]) < SPIKE)
    last = near.start + int(before[-1]) if len(before) else near.start - 1  # farther away all count as calm
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
    """Return whether a vehicle that was put down stands there with all that it means: no force varies."""
    if end - start < RESTING or "vx" not in channels:
        return False
    forces = [channels[key] for key in ("ax", "ay") if key in channels]
    resting = [one.values[one.within(start, np.nextafter(end, start))] for one in forces]
    return all(len(values) > 2 and float(np.std(values)) < AT_REST for values in resting)


def _place_jumps(channels: Mapping[str, Channel]) -> list[Event]:
    """Positions that move farther from one to the next than the speed explains, and do not come back."""
    place = place_of(channels)
    if place is None:
        return []
    t, xy = place
    at = np.r_[0, np.flatnonzero(np.diff(xy, axis=0).any(axis=1)) + 1]  # held positions catch up with a step
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
    """The way that its neighbours make expect where no speed is recorded: a median of five speeds."""
    padded = np.pad(way / duration, 2, mode="edge")
    middle = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)
    return np.asarray(middle * duration, dtype=np.float64)


def _gain(ax: Channel | None, t: Vec) -> Vec:
    """Speed (n-1,) [m/s] that a_x gives between times (n,)."""
    if ax is None:
        return np.zeros(len(t) - 1)
    area = np.r_[0.0, np.cumsum(0.5 * (ax.values[1:] + ax.values[:-1]) * np.diff(ax.t))]
    return np.diff(np.interp(t, ax.t, area))
