"""Boundary curves of the motion cueing test, from a user's file, because the standard's are not free to copy.

The file is CSV with the columns of `COLUMNS`, one line per test and frequency. An empty cell means no bound.
Between the frequencies of a test, bounds are linear in the logarithm of frequency.
"""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec, freeze
from otolith.core.disk import check_lines
from otolith.core.errors import InputError, one_of
from otolith.metrics.frequency_response import Response
from otolith.scenarios.cueing_tests import TESTS

COLUMNS: Final = ("test", "omega_radps", "modulus_low", "modulus_high", "phase_low_deg", "phase_high_deg")
_LONGEST_LINE: Final = 1_000  # characters


@dataclass(frozen=True, slots=True, kw_only=True)
class Boundary:
    """Bounds of one test at increasing frequencies; a missing bound is infinite."""

    omega: Vec  # (n,) [rad/s]
    modulus_low: Vec  # (n,)
    modulus_high: Vec  # (n,)
    phase_low_deg: Vec  # (n,)
    phase_high_deg: Vec  # (n,)

    def __post_init__(self) -> None:
        n = (len(self.omega),)
        freeze(self, omega=n, modulus_low=n, modulus_high=n, phase_low_deg=n, phase_high_deg=n)

    def holds(self, response: Response) -> bool | None:
        """Return whether a response is within the bounds; None outside the range of frequencies.

        Phases are compared within (−180°, 180°]. A response without a phase is judged by its modulus alone.
        """
        if not self.omega[0] * (1 - 1e-3) <= response.omega <= self.omega[-1] * (1 + 1e-3):
            return None
        within = [self._at(response, "modulus_low") <= response.modulus <= self._at(response, "modulus_high")]
        if not math.isnan(response.phase_deg):
            within.append(
                self._at(response, "phase_low_deg")
                <= response.phase_deg
                <= self._at(response, "phase_high_deg")
            )
        return all(within)

    def _at(self, response: Response, name: str) -> float:
        """Return a bound at the response's frequency; it is infinite if either neighbour is."""
        values: Vec = getattr(self, name)
        above = int(np.clip(np.searchsorted(self.omega, response.omega), 1, max(1, len(values) - 1)))
        near = values[max(0, above - 1) : above + 1]
        if not np.isfinite(near).all():
            return -math.inf if "low" in name else math.inf
        return float(np.interp(math.log(response.omega), np.log(self.omega), values))


def parse_boundaries(text: str, source: str) -> dict[str, Boundary]:
    """Read boundaries by the name of the test from the text of a CSV file.

    Parameters
    ----------
    source : name of the file, for errors.

    Raises
    ------
    InputError : a column is missing, a test is unknown, a cell is not a number, or frequencies do not
        increase.
    """
    check_lines(text.splitlines(), source, most=_LONGEST_LINE)
    reader = csv.DictReader(io.StringIO(text))
    missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        raise InputError(f"column {missing[0]} of {source}", "missing", f"there: {', '.join(COLUMNS)}")
    rows: dict[str, list[list[float]]] = {}
    try:
        for cells in reader:
            where = f"line {reader.line_num} of {source}"
            rows.setdefault(_test(cells["test"], where), []).append(_bounds(cells, where))
    except csv.Error as error:
        raise InputError(f"line {reader.line_num} of {source}", f"no CSV ({error})", "a row") from error
    return {name: _boundary(name, values, source) for name, values in rows.items()}


def _test(cell: str | None, where: str) -> str:
    """Return a test's name, given its name or its number."""
    names = {str(test.number): test.name for test in TESTS} | {test.name: test.name for test in TESTS}
    text = (cell or "").strip()
    if text not in names:
        raise InputError(f"the test in {where}", repr(text), "1 to 10 or " + one_of(names.values(), text))
    return names[text]


def _bounds(cells: Mapping[str, str | None], where: str) -> list[float]:
    bounds = []
    for name in COLUMNS[1:]:
        text = (cells[name] or "").strip()
        try:
            bounds.append(float(text) if text else (-math.inf if "low" in name else math.inf))
        except ValueError:
            raise InputError(f"{name} in {where}", repr(text), "a number or empty") from None
    if not 0.0 < bounds[0] < math.inf or any(math.isnan(bound) for bound in bounds):
        raise InputError(f"omega_radps in {where}", bounds[0], "greater than 0 rad/s and finite")
    return bounds


def _boundary(name: str, rows: Sequence[Sequence[float]], source: str) -> Boundary:
    omega, *bounds = np.array(rows).T
    if np.any(np.diff(omega) <= 0.0):
        raise InputError(f"omega_radps of {name} in {source}", omega.tolist(), "increasing from line to line")
    return Boundary(omega=omega, **dict(zip(COLUMNS[2:], bounds, strict=True)))
