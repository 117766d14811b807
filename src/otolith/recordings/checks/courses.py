"""Axes that are mistaken: positions against a heading, and a device's axes taken for the vehicle's."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.recordings.channels import Channel
from otolith.recordings.checks.kinematics import CHANGE, TURNING, Kinematics
from otolith.recordings.checks.relations import Relation, relation, window_changes, window_means
from otolith.recordings.checks.remedies import spelled
from otolith.recordings.checks.witnesses import witnesses
from otolith.recordings.columns import STANDARD_GRAVITY, Column
from otolith.recordings.words import ACCELERATION, words

SPAN: Final = 2.0  # [s] interval over which turning is compared
TURNS: Final = 0.05  # [rad] least RMS turning in that interval that proves something
WEAK: Final = 0.5  # correlation below which a_x does not follow the change of speed …
SURE: Final = 0.9  # … and from which another axis follows it
NEAR_G: Final = (0.75, 1.3)  # slope, in 1 g, at which values without a unit are taken for g
MOVING: Final = 3.0  # [m/s] from which the speed along a way is compared
ENOUGH: Final = 20  # least number of such values
STRETCHED: Final = 0.08  # error of the speed along the path from which its coordinates may be exchanged …
ALIKE: Final = 0.3  # … if exchanging them leaves less than this share of the error
AGAINST: Final = -0.7  # correlation below which they surely turn in opposite directions


def refuse_contradicting(channels: Mapping[str, Channel], source: str) -> None:
    """Refuse latitude and longitude that turn against a compass heading.

    One of them is written the other way round, such as a longitude that counts west as positive. Reading it
    as usual would mirror the drive.
    """
    sure = [witness for witness in witnesses(channels) if witness.absolute]
    placed = next((witness for witness in sure if witness.keys == ("lat", "lon")), None)
    compass = next((witness for witness in sure if witness.keys == ("heading",)), None)
    if placed is None or compass is None:
        return
    one, other = placed.course, compass.course
    t = np.arange(max(one.t[0], other.t[0]), min(one.t[-1], other.t[-1]) - SPAN, 0.5 * SPAN)
    t = t[one.known(t) & one.known(t + SPAN) & other.known(t) & other.known(t + SPAN)]
    a, b = one.on(t + SPAN) - one.on(t), other.on(t + SPAN) - other.on(t)
    size = float(np.sqrt(np.mean(a**2) * np.mean(b**2))) if len(t) else 0.0
    if size < TURNS**2 or float(np.mean(a * b)) > AGAINST * size:
        return
    ways = f"map lon={spelled(channels['lon'].column, -1.0)} if it counts the other way, or"
    raise InputError(
        f"{compass.name} in {source}",
        f"against latitude and longitude (correlation {float(np.mean(a * b)) / size:.2f})",
        f"turning the same way ({ways} leave out what is wrong with heading=none or lat=none)",
    )


def refuse_exchanged(channels: Mapping[str, Channel], source: str) -> None:
    """Refuse latitude and longitude whose names are exchanged, so that the path is a mirror image.

    A degree of longitude is shorter than one of latitude, so only one of the two paths has the speed that the
    file states. Near the equator, where the degrees are equally long, or without a speed, nothing can be
    decided.
    """
    if not {"lat", "lon", "vx"} <= set(channels):
        return
    named = {key: channels[key] for key in ("lat", "lon")}
    turned = {"lat": channels["lon"], "lon": channels["lat"]}
    off, off_turned = (_speed_error(ways, channels["vx"]) for ways in (named, turned))
    if not (off > STRETCHED and off_turned < ALIKE * off):
        return
    lat, lon = channels["lat"].column, channels["lon"].column
    raise InputError(
        f"latitude and longitude in {source}",
        f"a way {100 * off:.0f} % off the speed {channels['vx'].column.name!r}, "
        f"and {100 * off_turned:.1f} % with their names exchanged",
        f"each what its name says (map lat={spelled(lon)} and lon={spelled(lat)}, "
        "or leave them out with lat=none)",
    )


def _speed_error(ways: Mapping[str, Channel], speed: Channel) -> float:
    """Return the RMS logarithm of the path's speed over `speed`; 0 if the two cannot be compared."""
    seen = next((one.speed for one in witnesses(ways) if one.speed is not None), None)
    if seen is None:
        return 0.0
    both = speed.known(seen.t)
    way, stated = seen.values[both], np.abs(speed.on(seen.t[both]))
    fast = (stated > MOVING) & (way > MOVING)
    if fast.sum() < ENOUGH:
        return 0.0
    ratio = np.log(way[fast] / stated[fast])
    return float(np.sqrt(np.mean(ratio**2)))


def refuse_sideways(drive: Kinematics, source: str) -> None:
    """Refuse a drive whose a_y, instead of its a_x, follows the change of speed: its x axis points sideways.

    This happens if the axes of a phone or camera are taken for those of the vehicle.
    """
    straight = drive.of("ax", CHANGE)
    if (
        straight is None
        or not straight.informative
        or abs(straight.correlation) > WEAK
        or drive.speed is None
    ):
        return
    if "ay" not in drive.channels:
        return
    ay = window_means(drive.channels["ay"], drive.start)
    ahead = relation("ax", CHANGE, drive.start, ay, window_changes(drive.speed, drive.start), {})
    if abs(ahead.correlation) < SURE:
        return
    beside = next((one for one in drive.relations if one.key == "ay"), None)
    ways = [f"ax={_as(drive.channels['ay'].column, ahead)}"]
    if beside is not None:
        ax = window_means(drive.channels["ax"], beside.start)
        across = relation("ay", beside.by, beside.start, ax, beside.expected, {})
        ways += [f"ay={_as(drive.channels['ax'].column, across)}"] if abs(across.correlation) > WEAK else []
    if len(ways) == 1:
        ways.append(f"ay={spelled(drive.channels['ax'].column)}, or with its sign turned,")
    raise InputError(
        f"the axis of ay in {source}",
        f"that along which the speed changes (correlation {ahead.correlation:.2f})",
        f"the lateral one (a device's axes and not the vehicle's? map {' and '.join(ways)} and az alike)",
    )


def refuse_turning_in_pitch(drive: Kinematics, source: str) -> None:
    """Refuse a drive that turns according to its pitch rate instead of its yaw rate: its y axis points up.

    Games write their rates in this way, even next to forces that are named by words of direction.
    """
    straight = drive.of("ay", TURNING)
    if straight is None or abs(straight.correlation) > WEAK or drive.speed is None:
        return
    if not {"pitch_rate", "yaw_rate"} <= set(drive.channels):
        return
    pitch, speed = (window_means(one, straight.start) for one in (drive.channels["pitch_rate"], drive.speed))
    found = relation("ay", TURNING, straight.start, straight.measured, speed * pitch, {})
    if not found.informative or abs(found.correlation) < SURE:
        return
    as_read, turned = (spelled(drive.channels["pitch_rate"].column, sign) for sign in (1.0, -1.0))
    raise InputError(
        f"pitch rate in {source}",
        f"what the drive turns by (correlation {found.correlation:.2f} with ay), and the yaw rate is not",
        f"about the lateral axis (axes of a game, y up? map yaw_rate={as_read}, or yaw_rate={turned} where y "
        "points right, and roll_rate and pitch_rate alike, or none)",
    )


def lettered(drive: Kinematics) -> list[str]:
    """Note accelerations named only x and y, if there is no speed that shows which way x points."""
    pair = [drive.channels[key].column for key in ("ax", "ay") if key in drive.channels]
    spoken = [one for one in pair if one.rank and one.rank[0] and ACCELERATION & set(words(one.name)) - {"a"}]
    if len(spoken) < 2 or drive.speed is not None:
        return []
    named = " and ".join(repr(one.name) for one in spoken)
    return [
        f"{named} are taken for forward and left, but may be a device's own axes, which nothing in the file "
        "shows (map them if they are, such as ax=NAME and ay=-NAME)"
    ]


def _as(column: Column, found: Relation) -> str:
    """Return the mapping that reads a column with the fitting sign and, unless stated, the fitting unit."""
    unit = "g" if column.assumed and NEAR_G[0] < abs(found.slope) * STANDARD_GRAVITY < NEAR_G[1] else ""
    return spelled(column, -1.0 if found.correlation < 0.0 else 1.0, unit)
