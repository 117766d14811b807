"""Which column of a recorded drive holds which quantity and in which unit, from its name or a mapping."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

from otolith.core.errors import InputError, one_of
from otolith.recordings.units import READABLE, SI, STANDARD_GRAVITY, UNITS, canonical, factor
from otolith.recordings.words import NameMeaning, interpret, recognise, stated_unit

__all__ = [
    "QUANTITIES",
    "SI",
    "STANDARD_GRAVITY",
    "UNITS",
    "Column",
    "Header",
    "candidates",
    "canonical",
    "recognise",
    "unit_in_name",
]

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
    "lat": ("angle", "latitude, for checks only"),
    "lon": ("angle", "longitude, for checks only"),
    "heading": ("angle", "heading clockwise from north, for checks only"),
    "yaw": ("angle", "yaw angle, for checks only"),
}
OMITTED: Final = "none"  # a mapping that leaves this quantity out although a column has its name
EVERY: Final = "every"  # a mapping of time for evenly spaced rows, ``every:0.05s`` or ``every:20Hz``
# quantity -> the mapping that asks to derive it
DERIVATIONS: Final = {"ax": "from-speed", "ay": "from-yaw-rate"}
DEGREES: Final = ("lat", "lon", "heading")  # in degrees where no unit is stated, by common convention


@dataclass(frozen=True, slots=True)
class Column:
    """One column that is read: the value in SI units is factor · number in the file."""

    key: str  # quantity, one of QUANTITIES
    index: int  # index of the column, from 0; -1 where the quantity is derived from others
    name: str  # as in the file
    factor: float  # to SI, with the sign
    unit: str  # as found or assumed
    assumed: bool  # whether no unit was stated
    twins: tuple[str, ...] = ()  # names of other columns that hold the same numbers
    why: str = ""  # why this column was chosen, where there was a choice
    address: str = ""  # its name in a mapping: ``NAME#2`` where several columns have the same name
    # orders several columns for one quantity: smaller is better, the last entry is the index
    rank: tuple[int, ...] = ()

    def __str__(self) -> str:
        how = f", no unit stated, taken as {self._taken()}" if self.assumed else ""
        turned = ", sign turned" if self.factor < 0.0 else ""
        twins = f" (the same as {', '.join(map(repr, self.twins))})" if self.twins else ""
        why = f"; {self.why}" if self.why else ""
        return f"{self.key}: column {self.name!r} in {self.unit}{how}{turned}{twins}{why}"

    def _taken(self) -> str:
        return "SI" if self.unit == SI[QUANTITIES[self.key][0]] else self.unit


class Header(NamedTuple):
    """What a file states about its columns."""

    source: str  # name of the file
    names: Sequence[str]  # (c,)
    units: Sequence[str]  # (c,) from a row of units or the file's own description, empty where there is none
    origins: Sequence[str] = ()  # (c,) from a row of sources, such as "100: gps"; empty where there is none
    clocked: bool = False  # whether each channel has its own clock, so that no column has to be the time


def candidates(header: Header, mapping: Mapping[str, str]) -> dict[str, list[Column]]:
    """Return the columns that may hold each quantity, best first, as mapped or as their names suggest.

    A word of direction (lateral, yaw) ranks before a letter, which may mean the axes of a device; a measured
    quantity before one from satellites or calculations; a stated unit before none; then the first column.

    Parameters
    ----------
    mapping : quantity -> ``NAME``, ``NAME:UNIT``, ``-NAME`` (sign turned), ``NAME#2`` (the second column of
        that name), ``none``, or one of the words of `DERIVATIONS` and `EVERY`, which give no candidate here.

    Raises
    ------
    InputError : the mapping names an unknown quantity, column or unit.
    """
    for key in mapping:
        if key not in QUANTITIES:
            raise InputError("mapped quantity", repr(key), one_of(QUANTITIES, key))
    found = {
        key: [column] if (column := _mapped(key, text, header)) is not None else []
        for key, text in mapping.items()
    }
    ranked: dict[str, list[Column]] = {}
    for index, name in enumerate(header.names):
        unit = header.units[index]
        meaning = interpret(name, unit)
        if meaning is None or meaning.key in mapping:
            continue
        if factor(QUANTITIES[meaning.key][0], meaning.unit or unit) is None and (meaning.unit or unit).strip(
            " -"
        ):
            continue  # another kind of quantity, such as a voltage
        column = _column(meaning.key, index, header, meaning.unit)
        ranked.setdefault(meaning.key, []).append(replace(column, rank=_rank(meaning, column, header)))
    _leave_lone_letters(ranked, header)
    return found | {key: sorted(some, key=lambda column: column.rank) for key, some in ranked.items()}


def _leave_lone_letters(ranked: dict[str, list[Column]], header: Header) -> None:
    """Leave out rates about x or y whose axis is only a letter, where there is no rate about z.

    Beside accelerations that are named by words of direction, such as ``G_LAT``, a lone ``ROTY`` comes from a
    game whose y axis points up.
    """
    worded = any(one.rank[0] == 0 for key in ("ax", "ay") for one in ranked.get(key, []))
    if "yaw_rate" in ranked or not worded:
        return
    for key in ("roll_rate", "pitch_rate"):
        meaning = ((one, interpret(one.name, header.units[one.index])) for one in ranked.get(key, []))
        kept = [one for one, means in meaning if means is not None and not means.letter]
        if kept:
            ranked[key] = kept
        else:
            ranked.pop(key, None)


def missing(key: str, header: Header) -> InputError:
    """Return the error for a needed quantity that no column holds, with the remedy."""
    dimension, words = QUANTITIES[key]
    field = f"{words} ({key}) in {header.source}"
    alien = [
        f"{name!r} in {unit!r}"
        for name, unit in zip(header.names, header.units, strict=True)
        if (meaning := interpret(name, unit)) is not None
        and meaning.key == key
        and (meaning.unit or unit).strip(" -")
        and factor(dimension, meaning.unit or unit) is None
        for unit in [meaning.unit or unit]
    ]
    derived = f", or derived with {key}={DERIVATIONS[key]}" if key in DERIVATIONS else ""
    even = ", or t=every:0.05s if the rows are evenly spaced" if key == "t" else ""
    unit = f"{SI[dimension]} (one of {READABLE[dimension]})" if alien else SI[dimension]
    return InputError(
        field,
        f"given only by {' and '.join(alien)}" if alien else "missing",
        f"mapped as {key}=NAME:UNIT, UNIT such as {unit}, NAME {_listed(header.names)}{derived}{even}",
    )


def _rank(meaning: NameMeaning, column: Column, header: Header) -> tuple[int, ...]:
    origin = (header.origins[column.index] if header.origins else "").lower()
    derived = meaning.derived or "gps" in origin or "calc" in origin
    direction = meaning.letter and meaning.key in ("ax", "ay", "az", "vx")
    late = meaning.key == "t" and not _is_plain_time(column.name)
    return (int(direction), int(derived), int(meaning.filtered), int(late), int(column.assumed), column.index)


def _is_plain_time(name: str) -> bool:
    return any(word in name.lower() for word in ("time", "elapsed", "stamp", "cts", "interval")) or (
        len(name) < 5 and "date" not in name.lower()
    )


def _mapped(key: str, text: str, header: Header) -> Column | None:
    word = text.strip().lower()
    if word == OMITTED or word == DERIVATIONS.get(key) or (key == "t" and word.startswith(f"{EVERY}:")):
        return None
    whole, with_unit = (text, ""), text.rpartition(":")[::2]
    for name, unit in (whole, with_unit) if ":" in text else (whole,):
        for sign, candidate in ((1.0, name.strip()), (-1.0, name.strip().removeprefix("-"))):
            index = _addressed(candidate, header.names, f"{key}={text}")
            if index is not None:
                return _column(key, index, header, unit or unit_in_name(key, candidate), sign)
    raise InputError(
        f"{key} in {header.source}",
        f"mapped to {text!r}",
        f"NAME or NAME:UNIT with NAME {_listed(header.names)}",
    )


def _addressed(name: str, names: Sequence[str], option: str) -> int | None:
    """Return the index of the column of that name, or of the k-th one for ``NAME#k``; None if absent."""
    places = [index for index, one in enumerate(names) if one == name]
    if len(places) > 1:
        ways = " or ".join(f"{name}#{k}" for k in range(1, len(places) + 1))
        raise InputError(option, f"the name of {len(places)} columns", f"of one only (write {ways})")
    if places:
        return places[0]
    base, mark, number = name.rpartition("#")
    places = [index for index, one in enumerate(names) if one == base]
    if mark and number.isdigit() and 1 <= int(number) <= len(places):
        return places[int(number) - 1]
    return None


def unit_in_name(key: str, name: str) -> str:
    """Return the unit of this quantity that a mapped column's name states, whatever else the name means."""
    meaning, dimension = interpret(name), QUANTITIES[key][0]
    if meaning is not None and meaning.unit and QUANTITIES[meaning.key][0] == dimension:
        return meaning.unit
    unit, certain = stated_unit(name)
    return unit if certain or factor(dimension, unit) is not None else ""


def _column(key: str, index: int, header: Header, unit: str, sign: float = 1.0) -> Column:
    dimension, name = QUANTITIES[key][0], header.names[index]
    unit = (unit or header.units[index]).strip(" -")
    known = factor(dimension, unit)
    if unit and known is None:
        bound = f"one of {READABLE[dimension]} (map it, for example {key}={name}:{SI[dimension]})"
        raise InputError(f"unit of {name!r} in {header.source}", repr(unit), bound)
    if known is None:
        assumed = "deg" if key in DEGREES else SI[dimension]
        known, unit = UNITS[dimension][canonical(assumed)], assumed
        return Column(key, index, name, sign * known, unit, assumed=True, address=_address(header, index))
    unit = SI[dimension] if known == 1.0 else unit
    return Column(key, index, name, sign * known, unit, assumed=False, address=_address(header, index))


def _address(header: Header, index: int) -> str:
    name = header.names[index]
    same = [place for place, one in enumerate(header.names) if one == name]
    return name if len(same) == 1 else f"{name}#{same.index(index) + 1}"


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(repr(name) for name in names[:20])
    more = f" and {len(names) - 20} more" if len(names) > 20 else ""
    return f"one of {shown}{more}"
