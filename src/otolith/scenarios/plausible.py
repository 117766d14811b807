"""What physics says of a recorded drive: signs, units, axes and offsets that cannot be.

A car's speed v and yaw rate r tell what its accelerations must roughly be, a_x ≈ v̇ and a_y ≈ v r; compared
are means over whole seconds, in which vibration averages out. What contradicts them clearly is refused with
the mapping that would repair it; a constant difference, as a sensor that is not level shows, is removed;
what is merely odd is noted. `vx=none` leaves the speed, and with it these checks, out.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.scenarios.columns import STANDARD_GRAVITY, Column

LEAST: Final = 10  # whole seconds: fewer say nothing about signs
LEVEL: Final = 20  # whole seconds: fewer say nothing about offsets
# Correlations; a minute of quiet driving with a telephone's sensor showed 0.77 for a_y and 0.89 for a_x.
AGREE: Final = 0.7  # of what belongs together: a contradiction is refused from here on …
ODD: Final = 0.5  # … and noted from here on
FACTOR: Final = 3.0  # by which a unit is wrong for sure
OFFSET: Final = 0.15  # [m/s²] what 0.9 deg of tilt of the sensor shows
GRAVITY_SHOWS: Final = 5.0  # [m/s²] no car keeps this up in the mean of a drive
GAIN: Final = 90.0  # [m/s] no car gains more speed in a drive
TURNING: Final = 2.5  # [rad/s] mean over a second; no car keeps its wheels on the road beyond
FROZEN: Final = 1.0  # [s] of unchanged forces while the speed changes …
FROZEN_GAIN: Final = 1.0  # [m/s] … by this
# what a factor between measured and expected may mean: (factor, what it tells of ay and yaw or ax and speed)
CONVERSIONS: Final = ((1.0 / STANDARD_GRAVITY, "g"), (np.pi / 180.0, "deg/s"), (1.0 / 3.6, "km/h"))


class Checked(NamedTuple):
    """What came out: offsets to be taken off [m/s²], by quantity, and sentences about the rest."""

    offsets: dict[str, float]
    notes: list[str]


def check(
    t: Vec, data: Mapping[str, Vec], speed: Vec | None, columns: Mapping[str, Column], source: str
) -> Checked:
    """Judge a drive.

    Parameters
    ----------
    t : (n,) [s], from zero.
    data : (n,) each, SI, by quantity.
    speed : (n,) [m/s] where the log has one.
    columns : where each quantity comes from, for the remedies in error sentences.

    Raises
    ------
    InputError : gravity lies along x or y, a turn is faster than any car's, the drive gains more speed
        than there is, forces stand still while the speed changes, or a sign, a unit or the order of the
        axes contradicts speed and yaw rate.
    """
    means = _second_means(t, {**data, **({} if speed is None else {"vx": speed})})
    _refuse_gravity_in_the_plane(means, columns, source)
    _refuse_mad_turning(means, columns, source)
    if speed is None:
        _refuse_mad_gain(t, data, columns, source)
        _refuse_turned_sign("ay", "yaw rate", means, means.get("yaw_rate"), (columns, source))
        return Checked({}, [])
    _refuse_frozen(t, data, speed, source)
    expected = _expected(means)
    _refuse_exchanged(means, expected, columns, source)
    names = {"ax": "the change of speed", "ay": "speed × yaw rate"}
    offsets: dict[str, float] = {}
    notes: list[str] = []
    for key, other in names.items():
        if key in means and key in expected and len(means[key]) > LEAST:
            notes += _refuse_turned_sign(key, other, means, expected[key], (columns, source))
            notes += _refuse_unit(key, other, means[key], expected[key], (columns, source))
            offsets |= _offset(key, means[key], expected[key])
    notes += [
        f"{key}: a constant {value:+.2f} m/s² that {names[key]} does not explain was removed "
        f"({np.degrees(abs(value) / STANDARD_GRAVITY):.1f} deg of tilt of the sensor, or a slope); "
        "map vx=none to keep it"
        for key, value in offsets.items()
    ]
    return Checked(offsets, notes)


def _second_means(t: Vec, data: Mapping[str, Vec]) -> dict[str, Vec]:
    """Means over the whole seconds in which there are samples."""
    second = t.astype(np.int64)
    occupied = np.bincount(second)
    full = occupied > 0
    return {key: (np.bincount(second, values)[full] / occupied[full]) for key, values in data.items()}


def _expected(means: Mapping[str, Vec]) -> dict[str, Vec]:
    v = means["vx"]
    if len(v) <= LEAST:
        return {}
    expected = {"ax": np.gradient(v)}
    if "yaw_rate" in means:
        expected["ay"] = v * means["yaw_rate"]
    return expected


def _smooth(key: str, values: Vec) -> Vec:
    """As smooth as what it is compared with: a derivative over two seconds."""
    if key != "ax":
        return values
    padded = np.r_[values[0], values, values[-1]]
    return np.asarray(np.convolve(padded, [0.25, 0.5, 0.25], "valid"), dtype=np.float64)


def _correlation(a: Vec, b: Vec) -> float:
    if np.std(a) == 0.0 or np.std(b) == 0.0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def _refuse_gravity_in_the_plane(
    means: Mapping[str, Vec], columns: Mapping[str, Column], source: str
) -> None:
    for key in ("ax", "ay"):
        if key not in means or abs(mean := float(np.mean(means[key]))) < GRAVITY_SHOWS:
            continue
        if len(means[key]) <= LEAST and abs(mean) < 0.8 * STANDARD_GRAVITY:
            continue  # a short stop from high speed
        hint = f"is this the vertical axis? then map another column to {key} and az={columns[key].name}"
        raise InputError(f"mean of {key} in {source}", f"{mean:.4g} m/s²", f"about 0 m/s² ({hint})")


def _refuse_mad_turning(means: Mapping[str, Vec], columns: Mapping[str, Column], source: str) -> None:
    for key in ("roll_rate", "pitch_rate", "yaw_rate"):
        if key in means and (most := float(np.abs(means[key]).max())) > TURNING:
            column = columns[key]
            hint = f"is it in deg/s? then map {key}={column.name}:deg/s"
            bound = f"within ±{TURNING:g} rad/s ({hint})"
            raise InputError(f"{key} in {source}", f"{most:.4g} rad/s over a second", bound)


def _refuse_mad_gain(t: Vec, data: Mapping[str, Vec], columns: Mapping[str, Column], source: str) -> None:
    if "ax" not in data:
        return
    gain = float(np.trapezoid(data["ax"], t))
    if abs(gain) > GAIN and len(t) > 2 and t[-1] > LEVEL:
        hint = f"a sensor that is not level, or {columns['ax'].name!r} in a wrong unit or sign?"
        bound = f"within ±{GAIN:g} m/s, or with a column of speed that explains it ({hint})"
        raise InputError(f"speed gained by ax in {source}", f"{gain:.4g} m/s", bound)


def _refuse_frozen(t: Vec, data: Mapping[str, Vec], speed: Vec, source: str) -> None:
    if "ax" not in data:
        return
    forces = np.stack([data[key] for key in ("ax", "ay") if key in data], axis=1)
    still = np.r_[False, (np.diff(forces, axis=0) == 0.0).all(axis=1), False]
    edges = np.flatnonzero(np.diff(still.astype(np.int8))).reshape(-1, 2)
    for first, last in edges:
        change = abs(float(speed[last] - speed[first]) - float(data["ax"][first] * (t[last] - t[first])))
        if t[last] - t[first] > FROZEN and change > FROZEN_GAIN:
            where = f"forces in {source} from {t[first]:.4g} s to {t[last]:.4g} s"
            raise InputError(where, "unchanging while the speed changes", "alive (is the sensor frozen?)")


def _refuse_exchanged(
    means: Mapping[str, Vec], expected: Mapping[str, Vec], columns: Mapping[str, Column], source: str
) -> None:
    if not {"ax", "ay"} <= means.keys() or "ay" not in expected:
        return
    ax, ay = means["ax"], means["ay"]
    straight = abs(_correlation(_smooth("ax", ax), expected["ax"])), abs(_correlation(ay, expected["ay"]))
    crossed = abs(_correlation(ax, expected["ay"])), abs(_correlation(_smooth("ax", ay), expected["ax"]))
    if min(crossed) > AGREE and max(straight) < 0.5:
        remedy = f"map ax={columns['ay'].name} and ay={columns['ax'].name}, with signs"
        bound = f"ax for the change of speed and ay for turning (exchanged? {remedy})"
        raise InputError(f"ax and ay in {source}", "following turning and the change of speed", bound)


def _refuse_turned_sign(
    key: str,
    other: str,
    means: Mapping[str, Vec],
    expected: Vec | None,
    place: tuple[Mapping[str, Column], str],
) -> list[str]:
    """Refuse a clear contradiction; a note about a likely one."""
    if expected is None or key not in means or len(expected) <= LEAST:
        return []
    columns, source = place
    correlation = _correlation(_smooth(key, means[key]), expected)
    if correlation < -AGREE:
        turned = [key, "yaw_rate"] if key == "ay" else [key]
        ways = [f"{quantity}=-{columns[quantity].name}" for quantity in turned]
        ways += ["vx=none to leave the check out"] if "vx" in means else []
        bound = f"of the same sign (map {', or '.join(ways)})"
        raise InputError(f"{key} in {source}", f"against {other} (correlation {correlation:.2f})", bound)
    if correlation < -ODD:
        return [f"doubtful: {key} runs against {other} (correlation {correlation:.2f}); is a sign turned?"]
    return []


def _refuse_unit(
    key: str, other: str, values: Vec, expected: Vec, place: tuple[Mapping[str, Column], str]
) -> list[str]:
    """Refuse a factor that only a wrong unit explains; a note where the correlation is weak."""
    values = _smooth(key, values)
    correlation = _correlation(values, expected)
    if correlation < ODD:
        return []
    columns, source = place
    factor = correlation * float(np.std(values) / np.std(expected))  # the slope: noise does not raise it
    if 1.0 / FACTOR < factor < FACTOR:
        return []
    meant = next((unit for ratio, unit in CONVERSIONS if 0.8 < factor / ratio < 1.25), "")
    candidates = {"g": key, "deg/s": "yaw_rate", "km/h": "vx"}
    suspect = candidates.get(meant, key)
    guess = f"is {suspect} in {meant}? then map {suspect}={columns[suspect].name}:{meant}"
    used = ", ".join(f"{k} in {columns[k].unit}" for k in (key, "yaw_rate", "vx") if k in columns)
    remedy = f"{guess if meant else f'read were {used}: map their units'}; or vx=none"
    if correlation < AGREE:
        return [f"doubtful: {key} is {factor:.2g} times {other} ({remedy})"]
    raise InputError(f"{key} in {source}", f"{factor:.2g} times {other}", f"about 1 times ({remedy})")


def _offset(key: str, values: Vec, expected: Vec) -> dict[str, float]:
    """What is left of `values` [m/s²] where `expected` is zero, if it is more than a level sensor shows.

    By a straight line, since body roll and pitch add a tenth to a cornering car's force; a drive that hardly
    accelerates says nothing about the line's slope, which is then one.
    """
    if len(values) < LEVEL:
        return {}
    values = _smooth(key, values)
    slope = 1.0
    if _correlation(values, expected) > AGREE:
        slope = float(np.polyfit(expected, values, 1)[0])
    left = values - slope * expected
    constant, noise = float(np.mean(left)), float(np.std(left)) / np.sqrt(len(left))
    return {key: constant} if abs(constant) > max(OFFSET, 3.0 * noise) else {}
