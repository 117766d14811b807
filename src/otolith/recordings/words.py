"""The meaning of a column's name, read as whole words of a fixed vocabulary to avoid chance matches.

A name is split at blanks, underscores, signs, brackets and capitals (``LateralAcc``, ``x_rate_of_rotation``),
and where two words of the vocabulary are joined (``yawrate``, ``accx``). Every word must be in the
vocabulary: one that is not, such as ``steering`` or ``target``, makes the name meaningless. Words of
direction without a word of acceleration are geographic: ``lat`` is a latitude, ``lat_acc`` and ``Lat [g]``
are not.
"""

import functools
import re
from typing import Final, NamedTuple

from otolith.recordings.units import SHORT, canonical, factor, is_unit


def _set(text: str) -> frozenset[str]:
    return frozenset(text.split())


QUALIFIERS: Final = _set(
    "car vhcl vehicle ego imu cg cog body chassis sensor linear lin can signal data value in ins ecu obd adl "
    "main raw measured meas telemetry physics motion driver axis of the com local frame device user sample "
    "log message msg location indicated values m canbus field calibrated bodyframe orientation state real "
    "dynamics"
)
DERIVED: Final = _set("gps gnss calc calculated derived est estimated estimate computed obd2")
FILTERED: Final = _set("filtered filt smooth smoothed lp lowpass avg mean comp corr corrected")
LONGITUDINAL: Final = _set("long lon longitudinal longit inline surge forward fwd fore lng")
LATERAL: Final = _set("lat lateral sway transverse sideways sideway")
VERTICAL: Final = _set("vert vertical heave")
LETTERS: Final = frozenset("xyz")
ACCELERATION: Final = _set("a acc accel acceleration accelerations accelerometer accl accelero")
G_FORCE: Final = _set("g gforce gee gs force")
ROTATION: Final = _set("roll pitch yaw")
GYRO: Final = _set("gyro gyroscope gyr omega w angular ang angvel rotation rot rotational")
RATE: Final = _set("rate rates velocity velocities vel speed")
SPEED: Final = _set("v speed velocity velocities vel")
SPEED_EXTRA: Final = _set("ground over x long lon longitudinal forward wheelspeed")
TIME: Final = _set("t ts time timestamp stamp utime cts elapsed utc epoch datetime date interval")
TIME_EXTRA: Final = _set(
    "in seconds secs sec s ms milliseconds us ns unix session relative rel abs absolute since start iso sim "
    "meta simulation system sys recording logger record logging run"
)
POSITION: Final = _set("pos position coord coordinate world")
VOCABULARY: Final = frozenset().union(
    QUALIFIERS, DERIVED, FILTERED, LONGITUDINAL, LATERAL, VERTICAL, LETTERS, ACCELERATION, G_FORCE, ROTATION,
    GYRO, RATE, SPEED, SPEED_EXTRA, TIME, TIME_EXTRA, POSITION,
    _set("turn specific f latitude longitude heading course bearing azimuth track angle north true"),
)  # fmt: skip
_GLUED: Final = sorted(
    {w for w in VOCABULARY if len(w) >= 3} | {"kmh", "kph", "mph"}, key=lambda w: (-len(w), w)
)
_DIRECTIONS: Final = (("ax", LONGITUDINAL, "x"), ("ay", LATERAL, "y"), ("az", VERTICAL, "z"))
_TURNS: Final = (("roll_rate", "roll", "x"), ("pitch_rate", "pitch", "y"), ("yaw_rate", "yaw", "z"))
_BRACKETS: Final = re.compile(r"^(.*?)[\s_,;:/]*[\[({<]([^\])}>]*)[\])}>]\s*$")
_ANGULAR: Final = re.compile("[Aa][Vv][xyz]")  # angular velocity, as CarSim writes it
_UNIT_OF_WORD: Final = {"utime": "us", "cts": "ms"}  # names of clocks that imply a unit


class NameMeaning(NamedTuple):
    """The meaning of a column's name."""

    key: str  # quantity, one of `columns.QUANTITIES`
    unit: str  # unit that the name states; empty where it states none
    letter: bool  # whether the direction is only x, y or z, which may be an axis of a device, not of the car
    derived: bool  # whether it comes from satellites or a calculation, not from a sensor
    filtered: bool  # whether it is filtered, or numbered as one of several


def recognise(name: str) -> tuple[str, str] | None:
    """Return the quantity and the unit (empty if none is stated) that a column's name means; None if unknown.

    Examples
    --------
    >>> recognise("Accel X [m/s^2]"), recognise("yaw_rate_degps"), recognise("throttle")
    (('ax', 'm/s^2'), ('yaw_rate', 'degps'), None)
    """
    meaning = interpret(name)
    return None if meaning is None else (meaning.key, meaning.unit)


@functools.lru_cache(maxsize=4096)
def interpret(name: str, unit: str = "") -> NameMeaning | None:
    """Interpret a column's name; None if it has no known meaning.

    Parameters
    ----------
    unit : the unit that the file states elsewhere, such as in a row of units.
    """
    base, stated = split_unit(name)
    for bare, own in ((base, stated), (name, "")) if stated else ((name, ""),):
        meaning = _meaning(words(bare), own or unit, stated_in_name=own)
        if meaning is not None:
            return meaning
    return None


def stated_unit(name: str) -> tuple[str, bool]:
    """Return the unit in a name, whatever the name means, and whether it can only be a unit."""
    unit = split_unit(name)[1]
    return unit, bool(unit) and (canonical(unit) not in SHORT or bool(_BRACKETS.match(name)))


def split_unit(name: str) -> tuple[str, str]:
    """Split a name into the name without its unit, and the unit, which is empty if none is recognised."""
    name, _, source = name.partition(" *")  # "Speed (kph) *gps"
    if source:
        base, unit = split_unit(name)
        return f"{base} {source}", unit
    bracketed = _BRACKETS.match(name)
    if bracketed and (is_unit(bracketed.group(2)) or not bracketed.group(2).strip(" -")):
        return bracketed.group(1), bracketed.group(2).strip(" -")
    if bracketed:
        return name, ""
    parts = re.split(r"[\s_]+", name.strip())
    for k in (4, 3, 2, 1):
        tail = " ".join(parts[-k:]) if "per" in parts[-k:] else "/".join(parts[-k:])
        if k < len(parts) and is_unit(tail):
            return "_".join(parts[:-k]), tail
    tail = _capitals(parts[-1])[-1] if parts[-1] else ""
    if len(tail) > 2 and len(tail) < len(parts[-1]) and is_unit(tail):  # SpeedKmh, but not LongG or AccX
        return "_".join([*parts[:-1], parts[-1][: -len(tail)]]), tail
    return name, ""


def words(name: str) -> tuple[str, ...]:
    """Return the words of a name in small letters, without symbols."""
    found: list[str] = []
    for piece in re.findall(r"[A-Za-z]+|\d+|[^\x00-\x7f]+", name):
        for part in [piece] if _ANGULAR.fullmatch(piece) else _capitals(piece):
            found += _unglued(part.lower())
    return tuple(found)


def _capitals(word: str) -> list[str]:
    parts = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[^A-Za-z]+", word)
    return [part for part in parts if part] or [word]


def _unglued(word: str) -> list[str]:
    """Split words of the vocabulary that are joined; return the word itself if they do not cover it."""
    if word in VOCABULARY or word.isdigit():
        return [word]
    if re.fullmatch("a[xyz]|v[x]|w[xyz]|f[xyz]", word):
        return [word[0], word[1]]
    if _ANGULAR.fullmatch(word):
        return ["w", word[2]]
    ending = re.fullmatch(r"(.{3,})([xyzg])", word) or re.fullmatch(r"(g)([a-z]{3,})", word)
    if ending and all(part in VOCABULARY for part in ending.groups()):
        return list(ending.groups())
    for first in _GLUED:
        if word.startswith(first) and len(word) > len(first):
            rest = _unglued(word[len(first) :])
            if all(part in VOCABULARY or part in _GLUED for part in rest):
                return [first, *rest]
    return [word]


def _meaning(said: tuple[str, ...], unit: str, *, stated_in_name: str) -> NameMeaning | None:
    bag = {word for word in said if not word.isdigit()}
    derived, filtered = bool(bag & DERIVED), bool(bag & FILTERED) or any(word.isdigit() for word in said)
    core = bag - DERIVED - FILTERED
    found = None
    for reading in (
        core,
        core - QUALIFIERS,
    ):  # a qualifier may itself carry the meaning: "sample time", "cog"
        found = found or _key(frozenset(reading), unit)
    if found is None:
        return None
    key, own_unit, letter = found
    return NameMeaning(key, stated_in_name or own_unit, letter, derived, filtered)


def _key(bag: frozenset[str], unit: str) -> tuple[str, str, bool] | None:
    """Return the quantity, the unit that the words imply, and whether a letter gave the direction."""
    if not bag:
        return None
    return _turning(bag, unit) or _acceleration(bag, unit) or _speed(bag, unit) or _other(bag, unit)


def _turning(bag: frozenset[str], unit: str) -> tuple[str, str, bool] | None:
    in_rate = factor("rate", unit) is not None
    for key, word, letter in _TURNS:
        rest = bag - {word, letter, "of", "axis"}
        if word in bag and ({word} | rest | {letter}) >= bag:
            if rest and rest <= (RATE | GYRO) and (rest & (RATE | GYRO)):
                return key, "", False
            if not rest and letter not in bag and in_rate:  # "Yaw [deg/s]"
                return key, "", False
        if letter in bag and rest <= (RATE | GYRO) and (rest & GYRO) and word not in bag:
            return key, "", True
    if bag <= {"turn", "heading"} | RATE and bag & {"turn", "heading"} and bag & RATE:
        return "yaw_rate", "", False
    return None


def _acceleration(bag: frozenset[str], unit: str) -> tuple[str, str, bool] | None:
    in_acceleration = factor("acceleration", unit) is not None
    for key, directions, letter in _DIRECTIONS:
        pointing = bag & (directions | {letter})
        rest = bag - pointing
        if not pointing:
            continue
        mere = not bag & directions
        if rest == {"g", "f"} and not unit:  # gFx
            return key, "g", mere
        if rest and rest <= (ACCELERATION | G_FORCE):
            if rest & ACCELERATION:
                return key, "g" if rest & {"g", "gs", "gforce"} and not unit else "", mere
            if rest == {"force"} and not in_acceleration:
                continue
            if rest == {"g"} and mere and unit and not in_acceleration:
                continue
            if not (rest == {"g"} and mere and not unit):
                return key, "" if unit else "g", mere
        if rest in ({"specific", "force"}, {"f"}) and in_acceleration:
            return key, "", mere
        if not rest and in_acceleration:  # "Lat [g]", "x (m/s²)"
            return key, "", mere
    return None


def _speed(bag: frozenset[str], unit: str) -> tuple[str, str, bool] | None:
    said = bag - {"kmh", "kph", "mph"}
    in_words = next(iter(bag & {"kmh", "kph", "mph"}), "")
    if said & SPEED and said <= SPEED | SPEED_EXTRA and not (unit and factor("speed", unit) is None):
        return "vx", in_words, "x" in said
    return None


def _other(bag: frozenset[str], unit: str) -> tuple[str, str, bool] | None:
    angular = not unit or factor("angle", unit) is not None
    if bag & TIME and bag <= TIME | TIME_EXTRA and not ("interval" in bag and not factor("time", unit)):
        bound = next((_UNIT_OF_WORD[word] for word in bag if word in _UNIT_OF_WORD), "")
        said = next((word for word in ("seconds", "sec", "secs", "ms", "us", "ns") if word in bag), bound)
        return "t", said, False
    places = {"x": ("x",), "y": ("y",)}
    for key, letters in places.items():
        if bag & set(letters) and bag <= set(letters) | POSITION and factor("length", unit) is not None:
            return key, "", False
    if angular and bag in ({"latitude"}, {"lat"}):
        return "lat", "", False
    if angular and bag in ({"longitude"}, {"long"}, {"lon"}, {"lng"}):
        return "lon", "", False
    if angular and bag & {"heading", "course", "bearing"} and bag <= _COMPASS:
        return "heading", "", False
    if angular and "yaw" in bag and bag <= {"yaw", "angle"}:
        return "yaw", "", False
    return None


_COMPASS: Final = frozenset({"heading", "course", "bearing", "over", "ground", "true", "angle", "north"})
