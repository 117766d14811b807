"""Which column of a recorded drive holds what, in which unit: from its name, or as the user maps it."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from otolith.core.errors import InputError, one_of

STANDARD_GRAVITY: Final = 9.80665  # [m/s²], what "1 g" means in a log

# quantity -> (dimension, in words); axes x forward, y left, z up
QUANTITIES: Final = {
    "t": ("time", "time"),
    "ax": ("acceleration", "longitudinal acceleration"),
    "ay": ("acceleration", "lateral acceleration"),
    "az": ("acceleration", "vertical acceleration"),
    "roll_rate": ("rate", "roll rate"),
    "pitch_rate": ("rate", "pitch rate"),
    "yaw_rate": ("rate", "yaw rate"),
    "vx": ("speed", "speed, for checks only"),
    "x": ("length", "position x, for maps only"),
    "y": ("length", "position y, for maps only"),
}
SI: Final = {"time": "s", "acceleration": "m/s2", "rate": "rad/s", "speed": "m/s", "length": "m"}
READABLE: Final = {
    "time": "s, ms, us, ns, min",
    "acceleration": "m/s2, g, mg, cm/s2, mm/s2, ft/s2",
    "rate": "rad/s, deg/s, mrad/s",
    "speed": "m/s, km/h, mph",
    "length": "m, km, mm, ft",
}
# canonical spelling (see `canonical`) -> factor to SI
UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {"s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3}
    | {"milliseconds": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0},
    "acceleration": {"mps2": 1.0, "mpss": 1.0, "ms2": 1.0, "ms-2": 1.0, "mpspps": 1.0, "mpsps": 1.0}
    | {"g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY, "cmps2": 1e-2, "mmps2": 1e-3, "ftps2": 0.3048},
    "rate": {"radps": 1.0, "rads": 1.0, "rads-1": 1.0, "radpsec": 1.0, "mradps": 1e-3}
    | dict.fromkeys(("degps", "dps", "degs", "degs-1", "degpsec", "degreesps"), math.pi / 180.0),
    "speed": {"mps": 1.0, "ms-1": 1.0}
    | dict.fromkeys(("kmh", "kph", "kmph", "kmh-1"), 1.0 / 3.6)
    | dict.fromkeys(("mph", "milesph"), 0.44704),
    "length": {"m": 1.0, "meter": 1.0, "metre": 1.0, "km": 1e3, "mm": 1e-3, "ft": 0.3048},
}
OPTIONAL_CHECKS: Final = ("vx", "x", "y")  # used where they are sound, ignored where not
OMITTED: Final = "none"  # as a mapping: leave this quantity out although a column has its name

_NOISE: Final = {
    "car",
    "vhcl",
    "vehicle",
    "ego",
    "imu",
    "gps",
    "cg",
    "cog",
    "body",
    "chassis",
    "sensor",
    "linear",
    "lin",
}
_ACCELERATION: Final = "(?:a|acc|accel|acceleration|accelerometer)"
_AXES: Final = {
    "ax": "long|lon|longitudinal|surge|inline",
    "ay": "lat|lateral|sway",
    "az": "vert|vertical|heave",
}
_RATE: Final = "(?:rate|velocity|vel|angularvelocity|angularrate|speed)"
_TURN: Final = "(?:gyro|gyroscope|omega|w|angularvelocity|angularrate|angvel|rotationrate)"
_PATTERNS: Final = {
    "t": re.compile(
        "(?:t|time|timestamp|timestamps|elapsed|timeelapsed|elapsedtime|secondselapsed|sessiontime)"
    ),
    **{
        key: re.compile(f"{_ACCELERATION}(?:{key[1]}|{words})|(?:{key[1]}|{words}){_ACCELERATION}")
        for key, words in _AXES.items()
    },
    "roll_rate": re.compile(f"roll{_RATE}|{_TURN}x"),
    "pitch_rate": re.compile(f"pitch{_RATE}|{_TURN}y"),
    "yaw_rate": re.compile(f"yaw{_RATE}|{_TURN}z"),
    "vx": re.compile("v|vx|speed|velocity|vehiclespeed|groundspeed|speedkmh|velocityx|longitudinalvelocity"),
    "x": re.compile("x|posx|positionx"),
    "y": re.compile("y|posy|positiony"),
}
_FORCE: Final = re.compile(
    "(?:f|specificforce)([xyz])"
)  # [m/s²]; in other units it is a force of another kind
_IN_G: Final = {
    key: re.compile(f"g(?:{words})|(?:{words})g|gforce(?:{key[1]}|{words})|(?:{key[1]}|{words})gforce")
    for key, words in _AXES.items()
}
_BRACKETS: Final = re.compile(r"^(.*?)[\s_]*[\[({]([^\])}]*)[\])}]\s*$")


@dataclass(frozen=True, slots=True)
class Column:
    """One column that is read: value in SI = factor · number in the file."""

    key: str  # of QUANTITIES
    index: int  # of the column, from 0
    name: str  # as in the file
    factor: float  # to SI, with the sign
    unit: str  # as found or assumed
    assumed: bool  # nobody stated the unit
    twins: tuple[str, ...] = ()  # names of other columns that hold the same numbers
    why: str = ""  # why this column and no other, where there was a choice

    def __str__(self) -> str:
        how = ", no unit stated, taken as SI" if self.assumed else ""
        turned = ", sign turned" if self.factor < 0.0 else ""
        twins = f" (the same as {', '.join(map(repr, self.twins))})" if self.twins else ""
        return f"{self.key}: column {self.name!r} in {self.unit}{how}{turned}{twins}"


def _differ(_one: Column, _other: Column) -> bool:
    return True


def canonical(unit: str) -> str:
    """One spelling per unit: ``m/s^2``, ``M/S²`` and ``mps2`` become ``mps2``, ``°/s`` becomes ``degps``."""
    unit = unit.strip().lower().replace("²", "2").replace("°", "deg").replace("μ", "µ").replace("⁻¹", "-1")
    return re.sub(r"[\s^*·.]", "", unit).replace("/", "p")


def recognise(name: str) -> tuple[str, str] | None:
    """Quantity and unit (empty where none is stated) of a column by its name; None if it tells nothing.

    Examples
    --------
    >>> recognise("Accel X [m/s^2]"), recognise("yaw_rate_degps"), recognise("throttle")
    (('ax', 'm/s^2'), ('yaw_rate', 'degps'), None)
    """
    bracketed = _BRACKETS.match(name)
    if bracketed:
        key = _quantity(bracketed.group(1), bracketed.group(2))
        return None if key is None else (key, bracketed.group(2).strip(" -"))
    parts = re.split(r"[\s_]+", name.strip())
    for k in (2, 1):
        unit = "/".join(parts[-k:])
        key = _quantity("_".join(parts[:-k]), unit)
        if key is not None and canonical(unit) in UNITS[QUANTITIES[key][0]]:
            return key, unit
    key = _quantity(name, "")
    if key is None:
        key = _named_in_g(_squeezed(name))
        return None if key is None else (key, "g")
    return key, ""


def choose(
    names: Sequence[str],
    source: str,
    mapping: Mapping[str, str],
    units: Sequence[str],
    *,
    differ: Callable[[Column, Column], bool] = _differ,
) -> list[Column]:
    """The columns to read: as mapped by the user, else as their names tell.

    Parameters
    ----------
    names : (c,) column names as in the file.
    mapping : quantity -> ``NAME``, ``NAME:UNIT``, ``-NAME`` (sign turned) or ``none``.
    units : (c,) units from a row of their own, empty strings where there is none.
    differ : whether two columns that tell the same quantity hold different numbers. Where they do not, the
        first is taken.

    Raises
    ------
    InputError : unknown quantity, name or unit; two columns for one quantity; no time or no ``ax``.
    """
    for key in mapping:
        if key not in QUANTITIES:
            raise InputError("mapped quantity", repr(key), one_of(QUANTITIES, key))
    told = [recognise(name) for name in names]
    chosen = []
    for key in QUANTITIES:
        if key in mapping:
            column = _mapped(key, mapping[key], names, source, units)
        else:
            column = _told(key, told, (names, units, source), differ)
        if column is not None:
            chosen.append(column)
        elif key in ("t", "ax"):
            raise _missing(key, names, source)
    return chosen


def _quantity(base: str, unit: str) -> str | None:
    squeezed = _squeezed(base)
    key = next((k for k, pattern in _PATTERNS.items() if pattern.fullmatch(squeezed)), None)
    if key in ("x", "y") and canonical(unit) not in UNITS["length"]:
        return None  # a position only where its unit says so
    force = _FORCE.fullmatch(squeezed)
    if force and canonical(unit) in UNITS["acceleration"]:
        return f"a{force.group(1)}"
    if key is None and canonical(unit) in UNITS["acceleration"]:  # "Lat [g]"; alone, lat is a latitude
        key = next((k for k, words in _AXES.items() if re.fullmatch(words, squeezed)), _named_in_g(squeezed))
    return key


def _named_in_g(squeezed: str) -> str | None:
    return next((key for key, pattern in _IN_G.items() if pattern.fullmatch(squeezed)), None)


def _squeezed(name: str) -> str:
    words: list[str] = re.findall("[a-z0-9]+", name.lower())
    while len(words) > 1 and words[0] in _NOISE:
        words = words[1:]
    return "".join(words)


def _told(
    key: str,
    told: Sequence[tuple[str, str] | None],
    table: tuple[Sequence[str], Sequence[str], str],
    differ: Callable[[Column, Column], bool],
) -> Column | None:
    """The column whose name tells the quantity; `table` is names, units and source."""
    names, units, source = table
    found = [(index, entry[1]) for index, entry in enumerate(told) if entry is not None and entry[0] == key]
    optional = key in OPTIONAL_CHECKS
    if optional:
        known = {"", *UNITS[QUANTITIES[key][0]]}
        found = [(index, stated) for index, stated in found if canonical(stated or units[index]) in known]
    if not found:
        return None
    columns = [_column(key, index, names[index], stated or units[index], source) for index, stated in found]
    if any(differ(columns[0], other) for other in columns[1:]):
        if optional:
            return None
        listed = " and ".join(f"{column.name!r} (column {column.index + 1})" for column in columns)
        bound = f"one column (rename one, or map {key}=NAME)"
        raise InputError(f"{key} in {source}", f"given by {listed}", bound)
    return replace(columns[0], twins=tuple(column.name for column in columns[1:]))


def _mapped(key: str, text: str, names: Sequence[str], source: str, units: Sequence[str]) -> Column | None:
    if text.strip().lower() == OMITTED:
        return None
    whole, parted = (text, ""), text.rpartition(":")[::2]
    for name, unit in (whole, parted) if ":" in text else (whole,):
        for sign, candidate in ((1.0, name.strip()), (-1.0, name.strip().removeprefix("-"))):
            if names.count(candidate) > 1:
                raise InputError(
                    f"{key}={text}", f"the name of {names.count(candidate)} columns", "of one only"
                )
            if candidate in names:
                index = names.index(candidate)
                entry = recognise(candidate)
                stated = unit or units[index] or (entry[1] if entry is not None and entry[0] == key else "")
                return _column(key, index, candidate, stated, source, sign)
    raise InputError(
        f"{key} in {source}", f"mapped to {text!r}", f"NAME or NAME:UNIT with NAME {_listed(names)}"
    )


def _column(key: str, index: int, name: str, unit: str, source: str, sign: float = 1.0) -> Column:
    dimension = QUANTITIES[key][0]
    known = UNITS[dimension]
    if unit.strip(" -") and canonical(unit) not in known:
        bound = f"one of {READABLE[dimension]} (map it, for example {key}={name}:{SI[dimension]})"
        raise InputError(f"unit of {name!r} in {source}", repr(unit), bound)
    if not unit.strip(" -"):
        return Column(key, index, name, sign, SI[dimension], assumed=True)
    factor = known[canonical(unit)]
    shown = SI[dimension] if factor == 1.0 else unit.strip()
    return Column(key, index, name, sign * factor, shown, assumed=False)


def _missing(key: str, names: Sequence[str], source: str) -> InputError:
    dimension, words = QUANTITIES[key]
    field = f"{words} ({key}) in {source}"
    return InputError(
        field, "missing", f"mapped as {key}=NAME:UNIT, UNIT such as {SI[dimension]}, NAME {_listed(names)}"
    )


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(repr(name) for name in names[:20])
    more = f" and {len(names) - 20} more" if len(names) > 20 else ""
    return f"one of {shown}{more}"
