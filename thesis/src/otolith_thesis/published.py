"""Numbers printed in the thesis, from the data files of this package.

The keys of a row are the thesis's words. Where a table compares the four cueing models, the keys are their
names in `otolith.registry`.
"""

import tomllib
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any, Final

from otolith.core.errors import InputError, one_of

Row = dict[str, Any]
FILES: Final = ("chapter-5", "explicit", "chapter-6", "appendix-b", "appendix-c")


@dataclass(frozen=True, slots=True, kw_only=True)
class Published:
    """One printed table."""

    name: str  # e.g. "table-5.2"
    title: str
    section: str  # where the thesis discusses it, e.g. "5.2.4"
    rows: tuple[Row, ...]
    average: Row = field(default_factory=dict)  # the last line of the table, if it has one


@cache
def _printed() -> dict[str, Row]:
    tables: dict[str, Row] = {}
    for name in FILES:
        text = (files("otolith_thesis") / "data" / f"{name}.toml").read_text(encoding="utf-8")
        tables |= tomllib.loads(text)
    return tables


def published(table: str) -> Published:
    """Return the printed table of that name, e.g. "table-5.2".

    Raises
    ------
    InputError : there is no such table.
    """
    tables, key = _printed(), table.replace(".", "-")  # a dot would nest in TOML
    if key not in tables:
        raise InputError("table", repr(table), one_of([name.replace("-", ".") for name in tables], table))
    entry = tables[key]
    return Published(
        name=table,
        title=entry["title"],
        section=entry["section"],
        rows=tuple(entry["rows"]),
        average=entry.get("average", {}),
    )
