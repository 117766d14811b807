"""Comparison of our number with a published one, and the verdict on the difference.

One rule holds for every number of every table:

- agrees: within 2 %, or within half a unit of the last printed digit if that is more;
- close: within 10 %;
- same order: within a factor of 2, and the number keeps its place in its row. It keeps its place if no two
  numbers of the row that differ by more than 2 % in both versions are in a different order;
- differs: everything else.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

AGREES: Final = 0.02
CLOSE: Final = 0.10
ORDER: Final = 2.0
TIE: Final = 0.02


class Verdict(StrEnum):
    """The verdict on our number relative to the published one."""

    AGREES = "agrees"
    CLOSE = "within 10 %"
    ORDER = "same order"
    DIFFERS = "differs"


@dataclass(frozen=True, slots=True, kw_only=True)
class Number:
    """One published number and ours."""

    row: str
    column: str
    published: float
    ours: float
    digits: int = 4  # number of printed digits after the point
    at_least: bool = False  # whether the thesis gives only a lower bound, from a computation that was stopped
    verdict: Verdict = Verdict.DIFFERS

    @property
    def ratio(self) -> float | None:
        """Return ours over published; None if the published number is 0."""
        return self.ours / self.published if self.published else None


def judged(group: Sequence[Number]) -> tuple[Number, ...]:
    """Return the numbers of one row of a table with their verdicts."""
    return tuple(_with_verdict(number, group) for number in group)


def judged_row(
    row: str, printed: Mapping[str, Any], ours: Mapping[str, float], *, digits: int = 4
) -> tuple[Number, ...]:
    """Return a row of a table, whose columns are the keys of `ours`, with verdicts.

    Parameters
    ----------
    printed : the published row, with the same keys.
    """
    return judged(
        [
            Number(row=row, column=column, published=float(printed[column]), ours=value, digits=digits)
            for column, value in ours.items()
        ]
    )


def _with_verdict(number: Number, group: Sequence[Number]) -> Number:
    ranked = all(_same_way(number, other) for other in group)
    return Number(
        row=number.row,
        column=number.column,
        published=number.published,
        ours=number.ours,
        digits=number.digits,
        at_least=number.at_least,
        verdict=verdict(number, ranked=ranked),
    )


def verdict(number: Number, *, ranked: bool) -> Verdict:
    """Apply the rule above; `ranked` states whether the number keeps its place in its row."""
    gap, size = abs(number.ours - number.published), abs(number.published)
    if not math.isfinite(number.ours):
        return Verdict.DIFFERS
    if number.at_least:
        return Verdict.AGREES if number.ours >= number.published else Verdict.DIFFERS
    if gap <= max(AGREES * size, 0.5 * 10.0**-number.digits):
        return Verdict.AGREES
    if gap <= CLOSE * size:
        return Verdict.CLOSE
    same_size = number.ours * number.published > 0.0 and size / ORDER <= abs(number.ours) <= ORDER * size
    return Verdict.ORDER if same_size and ranked else Verdict.DIFFERS


def _same_way(a: Number, b: Number) -> bool:
    published, ours = _apart(a.published, b.published), _apart(a.ours, b.ours)
    return published * ours >= 0


def _apart(a: float, b: float) -> int:
    """Return the sign of a − b, 0 if they are tied."""
    if abs(a - b) <= TIE * max(abs(a), abs(b)):
        return 0
    return 1 if a > b else -1
