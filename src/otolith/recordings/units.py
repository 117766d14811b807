"""Units of recorded drives, in their many spellings."""

import math
import re
from collections.abc import Mapping
from typing import Final

STANDARD_GRAVITY: Final = 9.80665  # [m/s²]; "1 g" in a log

SI: Final = {
    "time": "s",
    "acceleration": "m/s2",
    "rate": "rad/s",
    "speed": "m/s",
    "length": "m",
    "angle": "rad",
}
READABLE: Final = {
    "time": "s, ms, us, ns, min, h, d",
    "acceleration": "m/s2, g, mg, cm/s2, mm/s2, ft/s2",
    "rate": "rad/s, deg/s, mrad/s, deg/h, rpm",
    "speed": "m/s, km/h, mph, kn, ft/s, mm/s",
    "length": "m, km, mm, cm, ft, mi",
    "angle": "rad, deg",
}
_DEGREE: Final = math.pi / 180.0
# canonical spelling (see `canonical`) -> factor to SI
UNITS: Final[Mapping[str, Mapping[str, float]]] = {
    "time": {
        **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "unixtime", "epoch", "unix"), 1.0),
        **dict.fromkeys(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"), 1e-3),
        **dict.fromkeys(("us", "µs", "usec", "micros", "microsecond", "microseconds"), 1e-6),
        **dict.fromkeys(("ns", "nsec", "nanos", "nanosecond", "nanoseconds"), 1e-9),
        **dict.fromkeys(("min", "minute", "minutes"), 60.0),
        **dict.fromkeys(("h", "hour", "hours"), 3600.0),
        **dict.fromkeys(("d", "day", "days"), 86400.0),
    },
    "acceleration": {
        **dict.fromkeys(("mps2", "mpss", "ms2", "ms-2", "mpspps", "mpsps", "mpsec2", "mpsecpsec"), 1.0),
        **dict.fromkeys(("meterspsecond2", "metersps2", "meterps2", "mss", "mpsecond2", "mpsec^2"), 1.0),
        **dict.fromkeys(("g", "gs", "gee", "g0", "gn", "gforce", "gravity"), STANDARD_GRAVITY),
        **dict.fromkeys(("mg", "millig", "milligs"), 1e-3 * STANDARD_GRAVITY),
        "cmps2": 1e-2,
        "mmps2": 1e-3,
        "ftps2": 0.3048,
        "ftpss": 0.3048,
        "gal": 1e-2,
    },
    "rate": {
        **dict.fromkeys(("radps", "rads", "rads-1", "radpsec", "radianps", "radiansps", "rps-1"), 1.0),
        **dict.fromkeys(("radpsecond", "radianspsec", "radianspsecond", "radsec"), 1.0),
        **dict.fromkeys(("mradps", "mrads"), 1e-3),
        **dict.fromkeys(("degps", "dps", "degs", "degs-1", "degpsec", "degreesps", "degreeps"), _DEGREE),
        **dict.fromkeys(("degpsecond", "degreespsec", "degreespsecond", "degreepsec", "degsec"), _DEGREE),
        **dict.fromkeys(("mdps", "mdegps"), 1e-3 * _DEGREE),
        **dict.fromkeys(("degph", "degphour", "degreesph"), _DEGREE / 3600.0),
        **dict.fromkeys(("rpm", "revpmin", "1pmin"), 2.0 * math.pi / 60.0),
    },
    "speed": {
        **dict.fromkeys(("mps", "ms", "ms-1", "mpsec", "mpsecond"), 1.0),
        **dict.fromkeys(("meterps", "metersps", "meterspsecond"), 1.0),
        **dict.fromkeys(("kmh", "kph", "kmph", "kmh-1", "kmphr", "kmhr", "kilometersph"), 1.0 / 3.6),
        **dict.fromkeys(("kmphour", "kilometerspperh", "kilometersphour"), 1.0 / 3.6),
        **dict.fromkeys(("mph", "milesph", "miph", "milesphour"), 0.44704),
        **dict.fromkeys(("kn", "kt", "kts", "knot", "knots"), 1852.0 / 3600.0),
        **dict.fromkeys(("fps", "ftps"), 0.3048),
        **dict.fromkeys(("mmps",), 1e-3),
        **dict.fromkeys(("cmps",), 1e-2),
    },
    "length": {
        **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
        **dict.fromkeys(("km", "kilometer", "kilometers", "kilometre", "kilometres"), 1e3),
        **dict.fromkeys(("cm", "centimeter", "centimeters"), 1e-2),
        **dict.fromkeys(("mm", "millimeter", "millimeters"), 1e-3),
        **dict.fromkeys(("ft", "foot", "feet"), 0.3048),
        **dict.fromkeys(("mi", "mile", "miles"), 1609.344),
    },
    "angle": {
        **dict.fromkeys(("rad", "radian", "radians"), 1.0),
        **dict.fromkeys(("deg", "degree", "degrees"), _DEGREE),
        "arcmin": _DEGREE / 60.0,
        "arcminwest": -_DEGREE / 60.0,  # longitudes of a VBOX, positive to the west
    },
}
SHORT: Final = (
    "s",
    "g",
    "m",
    "h",
    "d",
    "min",
    "gs",
    "rad",
    "unix",
    "epoch",
    "gravity",
)  # words of other kinds
# units of what is not read, so that a bracket or a row of units is known for what it is
OTHERS: Final = frozenset(
    {"%", "v", "a", "ma", "n", "kn", "nm", "bar", "mbar", "kpa", "psi", "hpa", "degc", "c", "degf", "f", "k"}
    | {"hz", "khz", "1pm", "l", "kg", "count", "counts", "bool", "-", "ratio", "percent", "kw", "hp", "ppm"}
    | {"lpkm", "w", "j", "lambda", "#", "none", "raw", "1", "ft-lb", "nmi", "utc", "hpm", "afr", "t"}
)


def canonical(unit: str) -> str:
    """Return one spelling per unit: ``mps2`` for ``m/s^2`` and ``M/S²``, ``degps`` for ``°/s``."""
    unit = (
        unit.strip()
        .lower()
        .replace("|", "/")
        .replace("²", "2")
        .replace("°", "deg")
        .replace("º", "deg")
        .replace("μ", "µ")
    )
    unit = re.sub(r"\bper\b|(?<=[a-z])_per_", "/", unit.replace("⁻¹", "-1").replace("⁻²", "-2"))
    return re.sub(r"[\s^*·._]", "", unit).replace("/", "p")


def factor(dimension: str, unit: str) -> float | None:
    """Return the size of one `unit` in SI units; None if it is not a unit of this dimension."""
    return UNITS[dimension].get(canonical(unit))


def is_unit(text: str) -> bool:
    """Return whether a text is a unit of any kind that occurs in logs."""
    spelled = canonical(text)
    return spelled in OTHERS or any(spelled in units for units in UNITS.values())
