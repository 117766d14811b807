"""Choice between several columns for one quantity."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings.cells import Samples
from otolith.recordings.channels import FELT

SAME: Final = 0.01  # RMS difference of two columns, relative to their RMS, below which they count as equal
ALIKE: Final = 0.9  # least correlation of two columns that measure one quantity …
FINER: Final = 1.5  # ratio of the numbers of distinct values from which a column is finer
SLOPE: Final = 1.25  # … and largest ratio of their standard deviations
AGREES: Final = 0.7  # least correlation of the right column with what speed and yaw rate predict
DISAGREES: Final = 0.5  # … and largest correlation of the others


@dataclass(frozen=True, slots=True)
class Choice:
    """The columns that were chosen, and those that were not."""

    chosen: Mapping[str, Samples]  # by quantity
    others: Mapping[str, tuple[Samples, ...]]  # sound columns that were not chosen, best first
    notes: tuple[str, ...]


def choose(read: Sequence[Samples], needed: Collection[str], source: str) -> Choice:
    """Choose for each quantity the first sound column, unless speed and yaw rate clearly support another one.

    Candidates arrive in the order of their quality, see `columns.candidates`. A column with the same numbers
    as the chosen one is recorded as its twin; one that differs is left out with a note.

    Raises
    ------
    InputError : a needed quantity has no sound column, or two columns of equal quality contradict each other
        and nothing shows which is right.
    """
    by_key: dict[str, list[Samples]] = {}
    for one in read:
        by_key.setdefault(one.column.key, []).append(one)
    chosen: dict[str, Samples] = {}
    others: dict[str, tuple[Samples, ...]] = {}
    notes: list[str] = []
    for key in sorted(
        by_key, key=lambda key: key in ("ax", "ay", "az")
    ):  # forces last: they are compared with the other quantities
        sound = [one for one in by_key[key] if one.fault is None]
        faulty = [one for one in by_key[key] if one.fault is not None]
        if not sound and key in needed:
            raise faulty[0].fault or AssertionError
        notes += [f"{key}: {one.column.name!r} is not used: {one.fault}" for one in faulty]
        if sound:
            chosen[key], left = _one(sound, chosen, source, required=key in FELT)
            others |= {key: tuple(left)} if left else {}
    return Choice(chosen, others, tuple(notes))


def _one(
    sound: list[Samples], chosen: Mapping[str, Samples], source: str, *, required: bool
) -> tuple[Samples, list[Samples]]:
    """Return the column to use, with its twins and the reason noted, and the columns that differ from it."""
    if len(sound) == 1:
        return sound[0], []
    supported = _supported(sound, chosen)
    first = supported or sound[0]
    twins = [one for one in sound if one is not first and _same(first, one)]
    left = [one for one in sound if one is not first and one not in twins]
    finest = max([first, *twins], key=lambda one: len(np.unique(one.values)))
    if len(np.unique(finest.values)) > FINER * len(np.unique(first.values)):  # another column has more digits
        twins = [one for one in [first, *twins] if one is not finest]
        first = finest
    rivals = [one for one in left if _rank(one) == _rank(first) and not _alike(first, one)]
    if rivals and required and supported is None:
        listed = " and ".join(
            f"{one.column.name!r} (column {one.column.index + 1})" for one in (first, *rivals)
        )
        key = first.column.key
        raise InputError(f"{key} in {source}", f"given by {listed}", f"one column (map {key}=NAME)")
    why = ""
    if left:
        others = " and ".join(repr(one.column.name) for one in left)
        why = f"taken before {others}, different numbers: {_reason(first, left[0], supported)}"
    names = tuple(one.column.name for one in twins)
    return replace(first, column=replace(first.column, twins=names, why=why)), left


def _reason(first: Samples, other: Samples, supported: Samples | None) -> str:
    """State why the chosen column is better than the next one, in the order of `columns.candidates`."""
    if supported is not None:
        return "it follows speed and yaw rate, they do not"
    better = (mine < theirs for mine, theirs in zip(first.column.rank, other.column.rank, strict=True))
    reasons = ("its name says which way", "it was measured, not derived", "it is not filtered",
            "it is finer", "its unit is stated", "it comes first")  # fmt: skip
    return next((reason for reason, holds in zip(reasons, better, strict=True) if holds), "it is mapped")


def _rank(one: Samples) -> tuple[int, ...]:
    return one.column.rank[:-1]


def _same(one: Samples, other: Samples) -> bool:
    """Return whether two columns hold the same numbers."""
    a, b = _both(one, other)
    size = float(np.sqrt(np.mean(a**2)))
    return bool(len(a)) and float(np.sqrt(np.mean((a - b) ** 2))) <= SAME * size


def _alike(one: Samples, other: Samples) -> bool:
    """Return whether both columns clearly measure one quantity, apart from noise."""
    a, b = _both(one, other)
    if len(a) < 2 or np.std(a) == 0.0 or np.std(b) == 0.0:
        return False
    ratio = float(np.std(a) / np.std(b))
    return float(np.corrcoef(a, b)[0, 1]) > ALIKE and 1.0 / SLOPE < ratio < SLOPE


def _both(one: Samples, other: Samples) -> tuple[Vec, Vec]:
    """Return the values of both columns in SI units on their common time, at the slower one's instants."""
    slow, fast = (one, other) if len(one.t) <= len(other.t) else (other, one)
    inside = (slow.t >= fast.t[0]) & (slow.t <= fast.t[-1])
    a = slow.values[inside] * slow.column.factor
    b = np.interp(slow.t[inside], fast.t, fast.values) * fast.column.factor
    return (a, b) if slow is one else (b, a)


def _supported(sound: list[Samples], chosen: Mapping[str, Samples]) -> Samples | None:
    """Return the only column that follows what speed and yaw rate predict; None if that is not clear."""
    key = sound[0].column.key
    if key not in ("ax", "ay") or "vx" not in chosen or (key == "ay" and "yaw_rate" not in chosen):
        return None
    speed = chosen["vx"]
    start, end = max(one.t[0] for one in (*sound, speed)), min(one.t[-1] for one in (*sound, speed))
    seconds = np.arange(start + 0.5, end - 0.5)
    if len(seconds) < 10:
        return None
    v = _means(speed, seconds)
    expected = np.gradient(v) if key == "ax" else v * _means(chosen["yaw_rate"], seconds)
    if np.std(expected) == 0.0:
        return None
    found = [_correlation(_means(one, seconds), expected) for one in sound]
    best = int(np.argmax(found))
    rest = [value for place, value in enumerate(found) if place != best]
    return sound[best] if found[best] > AGREES and max(rest) < DISAGREES else None


def _means(one: Samples, seconds: Vec) -> Vec:
    """Return the means over the second around each of these instants."""
    fine = seconds[:, None] + np.linspace(-0.45, 0.45, 10)
    values = np.interp(fine.ravel(), one.t, one.values).reshape(fine.shape)
    return np.asarray(values.mean(axis=1) * one.column.factor, dtype=np.float64)


def _correlation(a: Vec, b: Vec) -> float:
    return 0.0 if np.std(a) == 0.0 else float(np.corrcoef(a, b)[0, 1])
