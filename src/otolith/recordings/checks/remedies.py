"""Remedies for a drive that contradicts itself, tried on the drive before they are proposed.

A remedy turns signs, reads a quantity in another unit, or exchanges a_x and a_y. It is proposed only if it
resolves the contradiction and every relation that agreed before still agrees. Of those, the ones with the
fewest changes that bring most relations into agreement are proposed. There may be several, or none, and the
messages say so.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

from otolith.recordings.checks.kinematics import Kinematics
from otolith.recordings.checks.relations import SLOPES, Relation
from otolith.recordings.columns import QUANTITIES, Column, unit_in_name
from otolith.recordings.units import factor

# Another unit is accepted only if the slope is then within these bounds. Bounds are closer for a stated unit,
# because a leaning vehicle or a banked road can cause any factor below one.
CLOSE: Final = (0.75, 1.3)
STATED: Final = (0.85, 1.2)
SURE: Final = 0.9  # least correlation that can contradict a stated unit
TRIED: Final = {"acceleration": ("g", "m/s2"), "rate": ("deg/s", "rad/s"), "speed": ("m/s", "km/h", "mph")}
UNSAID: Final = {
    "acceleration": ("mg", "ft/s2"),
    "rate": (),
    "speed": ("kn",),
}  # and these too if none is stated
GROUPS: Final = (("ax", "ay", "az"), ("roll_rate", "pitch_rate", "yaw_rate"), ("vx",))
MOST: Final = 4  # largest number of changes in one remedy


@dataclass(frozen=True, slots=True)
class Change:
    """One change of how columns are read."""

    factors: Mapping[str, float]  # quantity -> factor on its values
    unit: str = ""  # the new unit; empty if only signs change


@dataclass(frozen=True, slots=True)
class Remedy:
    """Changes that bring a drive into agreement with itself."""

    changes: tuple[Change, ...]
    mapping: Mapping[str, str]  # quantity -> its new mapping

    @property
    def turns(self) -> bool:
        """Return whether a sign is turned."""
        return any(not change.unit for change in self.changes)

    def __str__(self) -> str:
        way = "map " + " and ".join(f"{key}={text}" for key, text in self.mapping.items())
        if len(self.changes) == 1 and self.changes[0].unit:
            keys = list(self.changes[0].factors)
            return f"{'is' if len(keys) == 1 else 'are'} {listed(keys)} in {self.changes[0].unit}? then {way}"
        return way


def remedies(
    drive: Kinematics, faults: Sequence[Relation], *, stated: Sequence[str] = (), sure: float = SURE
) -> list[Remedy]:
    """Return the remedies with the fewest changes that resolve all faults; of these, the most effective.

    Parameters
    ----------
    faults : relations of the drive that do not agree.
    stated : quantities whose unit the user has stated; these are not questioned.
    sure : least correlation from which a unit that the file states is questioned.
    """
    columns = {key: channel.column for key, channel in drive.channels.items()}
    concerned = {key for fault in faults for key in fault.powers}
    single = list(_changes(columns, concerned, stated))
    for count in range(1, MOST + 1):
        fitting = [
            chosen
            for chosen in combinations(single, count)
            if _apart(chosen) and _mend(chosen, drive.relations, faults, columns, sure)
        ]
        if fitting:
            agreeing = [_agreeing(chosen, drive.relations) for chosen in fitting]
            best = [c for c, n in zip(fitting, agreeing, strict=True) if n == max(agreeing)]
            return [Remedy(chosen, _mapping(chosen, columns)) for chosen in best if not _part(chosen, best)]
    return []


def _part(chosen: Sequence[Change], others: Sequence[Sequence[Change]]) -> bool:
    """Return whether another remedy is the same but reads more columns of one kind in the new unit.

    Columns that are written alike are meant alike, even those that nothing in the drive can judge.
    """

    def within(one: Change, other: Change) -> bool:
        return one.unit == other.unit and one.factors.items() <= other.factors.items()

    return any(
        other is not chosen and all(within(a, b) for a, b in zip(chosen, other, strict=True))
        for other in others
    )


def turns(drive: Kinematics, fault: Relation) -> list[Remedy]:
    """Return the sign changes that correct the sign of a relation and keep its size."""
    columns = {key: channel.column for key, channel in drive.channels.items()}
    single = [change for change in _changes(columns, set(fault.powers), ()) if not change.unit]
    others = [one for one in drive.relations if one.agrees]
    return [
        Remedy((change,), _mapping((change,), columns))
        for change in single
        if all(one.fits(one.factor(change.factors), SLOPES) for one in others)
    ]


def exchange(drive: Kinematics) -> Remedy | None:
    """Return the remedy that exchanges a_x and a_y, signs included, if only that explains both."""
    crossed = drive.crossed()
    if crossed is None or not all(one.strong and one.fits(_sign(one), SLOPES) for one in crossed):
        return None
    straight = [abs(r.correlation) for r in drive.relations if r.key in ("ax", "ay")]
    if max(straight, default=0.0) >= 0.5:
        return None
    columns = {key: drive.channels[key].column for key in ("ax", "ay")}
    ahead, aside = crossed
    mapping = {
        "ax": spelled(columns["ay"], _sign(ahead)),
        "ay": spelled(columns["ax"], _sign(aside)),
    }
    return Remedy((), mapping)


def forward(drive: Kinematics) -> str:
    """Return the mapping of a_x to the column of a_z, for games with y up; empty if that explains nothing."""
    found = drive.forward_in_az()
    if found is None or not found.strong or not found.fits(_sign(found), SLOPES):
        return ""
    return f"ax={spelled(drive.channels['az'].column, _sign(found))}"


def spelled(column: Column, sign: float = 1.0, unit: str = "") -> str:
    """Write the mapping that reads this column with another sign or unit."""
    dimension = QUANTITIES[column.key][0]
    unturned = factor(dimension, column.unit) or 1.0  # negative if the unit itself reverses the sign
    minus = "-" if sign * column.factor * unturned < 0.0 else ""
    known = column.assumed or factor(dimension, unit_in_name(column.key, column.name)) == abs(column.factor)
    written = unit or ("" if known else column.unit)
    return f"{minus}{column.address or column.name}{':' if written else ''}{written}"


def either(found: Sequence[Remedy], otherwise: Sequence[str] = ()) -> str:
    """Write the remedies as the end of a sentence, which says so if several fit the drive."""
    ways = [*map(str, found), *otherwise]
    if len(ways) == 1:
        return f"{ways[0]}, which makes this file agree"
    return f"more than one thing makes this file agree, and nothing in it shows which: {'; or '.join(ways)}"


def listed(keys: Sequence[str]) -> str:
    """Write quantities as a list in words: "ay, pitch rate and yaw rate"."""
    names = list(keys)
    return " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else "".join(names)


def _sign(one: Relation) -> float:
    return 1.0 if one.correlation > 0.0 else -1.0


def _changes(columns: Mapping[str, Column], concerned: set[str], stated: Sequence[str]) -> Iterator[Change]:
    for key in ("ax", "ay", "yaw_rate"):
        if key in concerned:
            yield Change({key: -1.0})
    for group in GROUPS:
        present = [key for key in group if key in columns]
        if concerned.isdisjoint(present):
            continue
        alike = [key for key in present if columns[key].unit == columns[present[0]].unit]
        sets = {tuple(alike)} | {(key,) for key in present if key in concerned}
        for keys in sorted(sets):
            if not set(keys) & set(stated):
                yield from _units(keys, columns[keys[0]])


def _units(keys: Sequence[str], column: Column) -> Iterator[Change]:
    dimension = QUANTITIES[keys[0]][0]
    for unit in TRIED[dimension] + (UNSAID[dimension] if column.assumed else ()):
        ratio = (factor(dimension, unit) or 0.0) / abs(column.factor)
        if ratio and not 0.99 < ratio < 1.01:
            yield Change(dict.fromkeys(keys, ratio), unit)


def _apart(chosen: Sequence[Change]) -> bool:
    """Return whether no quantity has its unit changed twice."""
    keys = [key for change in chosen if change.unit for key in change.factors]
    return len(keys) == len(set(keys))


def _mend(
    chosen: Sequence[Change],
    relations: Sequence[Relation],
    faults: Sequence[Relation],
    columns: Mapping[str, Column],
    sure: float,
) -> bool:
    """Return whether these changes make all faults agree and keep every agreement."""
    factors = _factors(chosen)
    for fault in faults:
        resized = [key for change in chosen if change.unit for key in change.factors if key in fault.powers]
        stated = any(not columns[key].assumed for key in resized)
        if stated and abs(fault.correlation) < sure:
            return False
        slopes = SLOPES if not resized else STATED if stated else CLOSE
        if not fault.fits(fault.factor(factors), slopes):
            return False
    return all(one.fits(one.factor(factors), SLOPES) for one in relations if one.agrees)


def _agreeing(chosen: Sequence[Change], relations: Sequence[Relation]) -> int:
    """Count the relations that agree after the changes."""
    factors = _factors(chosen)
    return sum(one.strong and one.fits(one.factor(factors), SLOPES) for one in relations)


def _factors(chosen: Sequence[Change]) -> dict[str, float]:
    factors: dict[str, float] = {}
    for change in chosen:
        for key, ratio in change.factors.items():
            factors[key] = factors.get(key, 1.0) * ratio
    return factors


def _mapping(chosen: Sequence[Change], columns: Mapping[str, Column]) -> dict[str, str]:
    signs: dict[str, float] = {}
    units: dict[str, str] = {}
    for change in chosen:
        for key, ratio in change.factors.items():
            signs[key] = signs.get(key, 1.0) * (1.0 if change.unit else ratio)
            units[key] = change.unit or units.get(key, "")
    return {key: spelled(columns[key], signs[key], units[key]) for key in signs}
