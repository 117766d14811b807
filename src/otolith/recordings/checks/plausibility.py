"""Contradictions in a recorded drive: signs, units, exchanged axes, and a sensor that is not level.

A contradiction is refused only if a remedy was tried on the drive and resolves it, or if no attitude of a
vehicle could explain it: on a bank or slope, or in a vehicle that leans, the felt force differs from that of
a level car by up to 1 g. What such a vehicle explains stays unchanged, with a note.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings.channels import FORCE, RATE, Channel, Recording
from otolith.recordings.checks.kinematics import CHANGE, TURNING, Kinematics
from otolith.recordings.checks.relations import AGREE, SLOPES, Relation, window_means
from otolith.recordings.checks.remedies import (
    SURE,
    Remedy,
    either,
    exchange,
    forward,
    remedies,
    spelled,
    turns,
)
from otolith.recordings.columns import STANDARD_GRAVITY

ODD: Final = 0.5  # negative correlation of related quantities from which it is noted
GRAVITY_SHOWS: Final = 0.5 * STANDARD_GRAVITY  # [m/s²] a larger mean along x or y needs an explanation
GRAVITY: Final = (0.9, 1.1)  # of 1 g: a constant of this size is gravity
GAIN: Final = 90.0  # [m/s] largest gain of speed of a car in a drive
LONG: Final = 20.0  # [s] least duration of a drive for this bound, or for a judgement of its largest force
TURNING_FAST: Final = 2.5  # [rad/s] over two seconds; a car turns so only in a spin
SPINNING: Final = 0.1  # largest share of a drive in which a car may spin
STEEP: Final = 0.35  # sine of the steepest street (Baldwin Street, Dunedin: 35 %)
BANK: Final = 0.7  # sine of 45 deg, the steepest bank
# [m/s²] largest force of nearly every drive exceeds this number in m/s², and of hardly any in g
FAINT: Final = 1.2
SUSTAINED: Final = 7.0  # [m/s²] lateral force that a level road hardly allows for seconds


@dataclass(frozen=True, slots=True)
class Statements:
    """The user's statements; what they settle is noted instead of refused."""

    axes: bool  # whether the axes, and so the signs, are stated
    units: Sequence[str]  # quantities whose unit is given in the mapping


def check(drive: Kinematics, recording: Recording, stated: Statements) -> list[str]:
    """Check a drive for contradictions, and return notes on what is odd.

    Raises
    ------
    InputError : gravity lies along x or y, a rate is too large for too long, the drive gains more speed than
        a car can, or signs, units or the order of the axes contradict speed, yaw rate or positions and a
        remedy resolves that.
    """
    channels, source = drive.channels, recording.source
    notes: list[str] = []
    swapped = exchange(drive)
    if swapped is not None:
        value = "following turning and the change of speed"
        bound = f"ax for the change of speed and ay for turning (exchanged? {either([swapped])})"
        raise InputError(f"ax and ay in {source}", value, bound)
    if mapping := forward(drive):
        value = "that along which the speed changes"
        bound = f"the vertical one (axes of a game, y up? map {mapping}, and ay, az and the rates alike)"
        raise InputError(f"the axis of az in {source}", value, bound)
    notes += _contradictions(drive, recording, stated)
    notes += _gravity_in_the_plane(drive, source)
    for key in RATE:
        if key in channels:
            notes += _implausible_turning(drive, channels[key], source, stated)
    if drive.speed is None and "ax" in channels:
        _refuse_implausible_gain(channels["ax"], source)
    notes += _without_speed(drive, source, stated)
    return [*notes, *_perhaps_in_g(drive), *_inertial(drive)]


def _contradictions(drive: Kinematics, recording: Recording, stated: Statements) -> list[str]:
    """Refuse relations that a remedy resolves, if possible all with one remedy; note the others."""
    notes: list[str] = []
    faults: list[Relation] = []
    for key in ("ax", "ay"):
        if recording.needed(key) and not stated.axes:
            _refuse_opposed(drive, key, recording.source)
    for one in drive.relations:
        if not one.informative or one.agrees or (one.key == "yaw_rate" and one.correlation < 0.0):
            continue  # `orientation` handles a yaw rate that contradicts a witness
        if one.key not in {fault.key for fault in faults}:
            if drive.attitude_explains(one.key):
                notes.append(_gravitys_share(drive, one))
            else:
                faults.append(one)
    notes += _only_on_the_level(drive, stated)
    strong = [one for one in faults if one.strong and recording.needed(one.key)]
    together = _tried(drive, strong, stated) if len(strong) > 1 else []
    alone = any(_road_may_explain(one, drive, together) for one in strong)  # then not all need a remedy
    for one in faults:
        try:
            notes += _contradiction(
                drive, one, recording.source, stated, (together if one in strong else [], alone)
            )
        except InputError as error:
            if recording.needed(one.key):
                raise
            notes.append(f"reported only, since it is not cued: {error}")
    return notes


def _refuse_opposed(drive: Kinematics, key: str, source: str) -> None:
    """Refuse a sign that only a level road supports, while gyro and gravity show that it is turned."""
    if not drive.attitude_opposes(key):
        return
    turned = "ax" if key == "ax" else "ay" if drive.side_of_gravity(key) < 0.0 else "yaw_rate"
    way = f"map {turned}={spelled(drive.channels[turned].column, -1.0)}, which makes this file agree"
    gyro = "pitch" if key == "ax" else "roll"
    value = f"against gravity's share in the {gyro} that the gyro gives"
    raise InputError(f"{turned} in {source}", value, f"of the same sign ({way})")


def _only_on_the_level(drive: Kinematics, stated: Statements) -> list[str]:
    """Note an a_x that follows the change of speed but would also do so with its sign turned on hills."""
    one = drive.of("ax", CHANGE)
    if one is None or not one.agrees or stated.axes or drive.attitude_shows("ax"):
        return []
    share = float(np.quantile(np.abs(one.measured + one.expected), 0.9)) / STANDARD_GRAVITY
    if share > STEEP:
        return []
    slope = 100.0 * np.tan(np.arcsin(share))
    return [
        "ax goes with the change of speed, which proves its sign unless the road climbs and falls by "
        f"{slope:.0f} %: there a turned ax would show the same; --axes states it"
    ]


def _tried(
    drive: Kinematics, faults: Sequence[Relation], stated: Statements, sure: float = SURE
) -> list[Remedy]:
    """Return the remedies for faults, without those that turn a sign if the user has stated the axes."""
    found = remedies(drive, faults, stated=stated.units, sure=sure)
    return [remedy for remedy in found if not (stated.axes and remedy.turns)]


def _gravitys_share(drive: Kinematics, one: Relation) -> str:
    share = drive.share_of_gravity(one.key)
    correlation = 0.0 if share is None else share.correlation
    turned, road = ("pitch", "a slope") if one.key == "ax" else ("roll", "a bank, or in a lean")
    return (
        f"{one.key} is not {one.other} ({_numbers(one)}), but with gravity's share it is: the difference "
        f"follows the {turned} of the gyro (correlation {correlation:.2f}), as on {road}; it stays"
    )


def _numbers(one: Relation) -> str:
    return f"correlation {one.correlation:.2f}, slope {one.slope:.2g}"


def _contradiction(
    drive: Kinematics, one: Relation, source: str, stated: Statements, joint: tuple[Sequence[Remedy], bool]
) -> list[str]:
    """Refuse a relation that a remedy resolves; note one that only the vehicle or the road explains.

    Parameters
    ----------
    joint : the remedies that resolve all contradictions together, and whether resolving this one alone
        suffices.
    """
    numbers, (together, alone) = _numbers(one), joint
    found = list(together)
    if abs(one.correlation) > ODD and (not found or alone):
        found += [remedy for remedy in _tried(drive, [one], stated) if remedy not in found]
    if one.strong and one.correlation < 0.0 and not found and one.key in FORCE and not stated.axes:
        found = turns(drive, one)  # the lean of a vehicle also changes the size of its force
    if not one.strong and found:
        runs = "runs against" if one.correlation < 0.0 else f"is {one.slope:.2g} times"
        return [f"doubtful: {one.key} {runs} {one.other} ({numbers}; {'; or '.join(map(str, found))})"]
    if not one.strong:
        return _unexplained(one, numbers)
    if one.correlation < 0.0:
        value = f"against {one.other} ({numbers})"
    else:
        value = f"{one.slope:.2g} times {one.other} (correlation {one.correlation:.2f})"
    if not found and _beyond_gravity(one):
        bound = "about 1 times, or within 1 g of it; no other sign, unit or order of axes makes it fit"
        raise InputError(f"{one.key} in {source}", value, f"{bound} ({_leave_out(drive)})")
    if not found:
        perhaps = "; or ".join(map(str, _tried(drive, [one], stated, ODD)))
        why = _explanation(one) + (f", or {perhaps}" if perhaps else "")
        return [f"doubtful: {one.key} is {value}: {why}; it is left as it is"]
    otherwise = [way] if (way := _road_may_explain(one, drive, found)) else []
    bound = "of the same sign" if one.correlation < 0.0 else "about 1 times"
    raise InputError(f"{one.key} in {source}", value, f"{bound} ({either(found, otherwise)})")


def _unexplained(one: Relation, numbers: str) -> list[str]:
    """Note a force that hardly follows what the force of a level car follows."""
    if one.key not in FORCE or float(np.std(one.expected)) < 0.5:
        return []
    return [f"{one.key} hardly goes with {one.other} ({numbers}): {_explanation(one)}; it is left as it is"]


def _explanation(one: Relation) -> str:
    if one.key == "ax":
        return "hills do so, or a coarse or late speed"
    if one.key == "ay":
        return "a banked road, a vehicle that leans, or a sensor that is not where it is thought does so"
    return "its unit is doubtful"


def _beyond_gravity(one: Relation) -> bool:
    """Return whether a force differs by more than 1 g from a level car's, which no attitude explains."""
    if one.key not in FORCE:
        return abs(one.slope) > SLOPES[1]
    return float(np.quantile(np.abs(one.measured - one.expected), 0.9)) > STANDARD_GRAVITY


def _road_may_explain(one: Relation, drive: Kinematics, found: Sequence[Remedy]) -> str:
    """Return how a road or a leaning vehicle could explain a relation, as a further remedy; else empty."""
    share = float(np.quantile(np.abs(one.measured - one.expected), 0.9)) / STANDARD_GRAVITY
    turned = any(remedy.turns for remedy in found)
    if one.key == "ax" and turned and share < STEEP:
        return f"--axes iso if the road climbs and falls by {100.0 * np.tan(np.arcsin(share)):.0f} %"
    if one.key != "ay" or share > BANK:
        return ""
    if turned:
        way = "--axes iso"
    else:
        doubted = dict.fromkeys(["ay", *(key for remedy in found for key in remedy.mapping)])
        columns = {key: drive.channels[key].column for key in doubted if key in drive.channels}
        stated = (f"{key}={spelled(column, unit=column.unit)}" for key, column in columns.items())
        way = f"map {' and '.join(stated)}"  # a unit that the user states is not questioned again
    angle = f"{np.degrees(np.arcsin(share)):.0f} deg"
    return f"{way} if the road is banked, or the vehicle leans, by {angle}"


def _leave_out(drive: Kinematics) -> str:
    if "vx" in drive.channels:
        return "map vx=none to leave the comparison out"
    keys = dict.fromkeys(key for witness in drive.witnesses for key in witness.keys)
    return f"map {' and '.join(f'{key}=none' for key in keys)} to leave the comparison out"


def _gravity_in_the_plane(drive: Kinematics, source: str) -> list[str]:
    """Refuse gravity along x or y: a constant of about 1 g, or the part of 1 g that a tilted sensor shows."""
    notes, channels = [], drive.channels
    for key in ("ax", "ay"):
        if key not in channels:
            continue
        values = _levels(drive, key)
        mean, least = float(np.mean(values)), float(np.quantile(np.abs(values), 0.05))
        if abs(mean) < GRAVITY_SHOWS or _explained(drive, key, mean):
            continue
        size = f"{mean:.4g} m/s²"
        upright = "az" in channels and float(np.mean(channels["az"].values)) > GRAVITY_SHOWS
        if least > GRAVITY_SHOWS and GRAVITY[0] < abs(mean) / STANDARD_GRAVITY < GRAVITY[1] and not upright:
            way = f"az={spelled(channels[key].column, 1.0 if mean > 0.0 else -1.0)}"
            hint = f"is this the vertical axis? then map another column to {key} and {way}"
            raise InputError(f"mean of {key} in {source}", size, f"about 0 m/s² ({hint})")
        if (tilt := _tilt(channels, key)) > 0.0:
            hint = (
                f"az holds the rest of gravity: the sensor is tilted by {tilt:.0f} deg; turn its axes level"
            )
            raise InputError(f"mean of {key} in {source}", size, f"about 0 m/s² ({hint})")
        notes.append(
            f"doubtful: {key} averages {size}, which nothing in the file explains: "
            + ("a long turn, a bank" if key == "ay" else "a long slope")
            + ", or a sensor that is far from level"
        )
    return notes


def _levels(drive: Kinematics, key: str) -> Vec:
    """Return the means over windows, or the samples of a drive that is too short for windows."""
    means = window_means(drive.channels[key], drive.start)
    means = means[np.isfinite(means)]
    return means if len(means) else drive.channels[key].values


def _explained(drive: Kinematics, key: str, mean: float) -> bool:
    """Return whether speed and turning predict such a mean."""
    others = [r for r in drive.relations if r.key == key and len(r.start)]
    return any(abs(float(np.mean(r.expected)) - mean) < max(0.3 * abs(mean), 1.0) for r in others)


def _tilt(channels: Mapping[str, Channel], key: str) -> float:
    """Return the tilt [deg] of a sensor if the means of its axes add up to 1 g; otherwise zero."""
    if "az" not in channels:
        return 0.0
    aside, up = (float(np.mean(channels[k].values)) for k in (key, "az"))
    whole = float(np.hypot(aside, up)) / STANDARD_GRAVITY
    return float(np.degrees(np.arctan2(abs(aside), up))) if GRAVITY[0] < whole < GRAVITY[1] else 0.0


def _implausible_turning(drive: Kinematics, channel: Channel, source: str, stated: Statements) -> list[str]:
    """Refuse rates that are too large for too long; note a spin."""
    means = np.abs(_levels(drive, channel.key))
    most, fast = float(means.max()), float(np.mean(means > TURNING_FAST))
    if most <= TURNING_FAST:
        return []
    where = f"{channel.key} in {source}"
    if fast <= SPINNING or channel.key in stated.units:
        return [f"{channel.key} reaches {most:.3g} rad/s over two seconds: a spin?"]
    bound = f"within ±{TURNING_FAST:g} rad/s for most of the drive"
    if most < np.degrees(TURNING_FAST):
        alike = [
            c for key, c in drive.channels.items() if key in RATE and c.column.unit == channel.column.unit
        ]
        mapping = " and ".join(f"{c.key}={spelled(c.column, unit='deg/s')}" for c in alike)
        bound += f" (is it in deg/s? then map {mapping})"
    raise InputError(where, f"{most:.4g} rad/s over two seconds", bound)


def _refuse_implausible_gain(ax: Channel, source: str) -> None:
    gain = float(np.trapezoid(ax.values, ax.t))
    if abs(gain) > GAIN and ax.t[-1] - ax.t[0] > LONG:
        hint = f"a sensor that is not level, or {ax.column.name!r} in a wrong unit or sign?"
        bound = f"within ±{GAIN:g} m/s, or with a column of speed that explains it ({hint})"
        raise InputError(f"speed gained by ax in {source}", f"{gain:.4g} m/s", bound)


def _without_speed(drive: Kinematics, source: str, stated: Statements) -> list[str]:
    """Compare the signs of lateral force and yaw rate if no speed is known; they must agree."""
    if drive.speed is not None or not {"ay", "yaw_rate"} <= set(drive.channels):
        return []
    one = drive.signs()
    if not one.informative or one.correlation > -ODD:
        return []
    if one.correlation > -AGREE or stated.axes:
        return [f"doubtful: ay runs against yaw rate (correlation {one.correlation:.2f}); is a sign turned?"]
    ways = [f"map {key}={spelled(drive.channels[key].column, -1.0)}" for key in ("ay", "yaw_rate")]
    bound = (
        f"of the same sign ({', or '.join(ways)}; nothing in the file shows which, --axes iso leaves both)"
    )
    raise InputError(f"ay in {source}", f"against yaw rate (correlation {one.correlation:.2f})", bound)


def _perhaps_in_g(drive: Kinematics) -> list[str]:
    """Note forces without a stated unit that are small enough to be in g and that nothing confirms."""
    felt = {key: drive.channels[key] for key in ("ax", "ay") if key in drive.channels}
    open_ = [key for key, one in felt.items() if one.column.assumed]
    most = max((float(np.abs(one.values).max(initial=0.0)) for one in felt.values()), default=0.0)
    confirmed = any(one.agrees and one.key in felt for one in drive.relations)
    brief = all(one.t[-1] - one.t[0] < LONG for one in felt.values())
    if not open_ or confirmed or brief or not 0.0 < most < FAINT:
        return []
    ways = " and ".join(f"{key}={spelled(felt[key].column, 1.0, 'g')}" for key in open_)
    return [
        f"doubtful: no unit is stated of {' and '.join(open_)}, nothing in the file confirms one, and "
        f"{most:.2g} m/s² at most is little for a drive: if the unit is g, map {ways}"
    ]


def _inertial(drive: Kinematics) -> list[str]:
    """Note a lateral force that is all v r and larger, for longer, than a level road allows."""
    one = drive.of("ay", TURNING) or next((r for r in drive.relations if r.key == "ay"), None)
    if one is None or not one.agrees or not 0.9 < one.slope < 1.2:
        return []
    held = np.abs(one.measured) > SUSTAINED
    if held.sum() < 4:
        return []
    return [
        f"ay is speed × turning throughout (slope {one.slope:.2f}), beyond {SUSTAINED:g} m/s² for "
        f"{held.sum()} s: the centripetal acceleration, as it is felt on a level road; on a banked one "
        "the driver feels a cos(bank) - g sin(bank), and this file holds something else than what is felt"
    ]
