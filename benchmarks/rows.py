"""Rows of the table of speed: what was measured, before and now. Scripts write them with `--json FILE`."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Row:
    """One figure of two versions, measured in one run."""

    what: str
    before: float
    now: float
    unit: str
    goal: float | None  # the ratio that was aimed at; None where there is none

    @property
    def ratio(self) -> float:
        """How many times less this version needs."""
        return self.before / self.now


def write_rows(path: Path, rows: list[Row]) -> None:
    """Write rows as JSON; every one states its ratio, too."""
    path.write_text(json.dumps([{**asdict(row), "ratio": row.ratio} for row in rows], indent=2) + "\n")


def read_rows(path: Path) -> list[Row]:
    """Read the rows that a script has written."""
    return [
        Row(**{key: value for key, value in row.items() if key != "ratio"})
        for row in json.loads(path.read_text())
    ]


def as_lines(rows: list[Row]) -> list[str]:
    """Return rows as the lines of a table."""
    width = max(len(row.what) for row in rows)
    lines = [f"{'':{width}}{'before':>12}{'now':>12}  {'unit':10}{'ratio':>8}{'goal':>8}"]
    for row in rows:
        goal = "" if row.goal is None else f"{row.goal:g}"
        cells = f"{row.before:12.4g}{row.now:12.4g}  {row.unit:10}{row.ratio:8.1f}{goal:>8}"
        lines.append(f"{row.what:{width}}{cells}")
    return lines
