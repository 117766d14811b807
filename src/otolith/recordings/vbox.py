"""Units of the columns of a Racelogic .vbo file, from the sections before its table.

In Racelogic's description of the format, ``[header]`` lists a title for each column, with its unit where
there is one ("velocity kmh", "Long accel g"), and ``[column names]`` lists their short names. Latitude and
longitude are in minutes of arc, with north and *west* positive. Other programs that write this format may
count east as positive. Only the heading, which a VBOX always logs, can reveal that, so positions without a
heading are not read.
"""

from collections.abc import Sequence
from typing import Final

from otolith.recordings.words import split_unit

COORDINATES: Final = {
    "lat": "arcmin",
    "latitude": "arcmin",
    "long": "arcmin west",
    "longitude": "arcmin west",
    "lon": "arcmin west",
}
UNREAD: Final = "min"  # not a unit of angle, so the column is left out


def is_vbox(preamble: Sequence[str]) -> bool:
    """Return whether the lines before a table are those of a .vbo file."""
    return {"[column names]", "[data]"} <= {line.strip().lower() for line in preamble}


def stated_units(names: Sequence[str], units: Sequence[str], preamble: Sequence[str]) -> list[str]:
    """Return the units (c,) of the columns of a .vbo file: those found elsewhere, else those of its header.

    Titles count only if there is one for each column.
    """
    titles, compass = _titles(preamble), any(name.lower() == "heading" for name in names)
    if len(titles) != len(names):
        titles = [""] * len(names)
    places = COORDINATES if compass else dict.fromkeys(COORDINATES, UNREAD)
    return [
        unit or places.get(name.lower(), "") or split_unit(title)[1]
        for name, unit, title in zip(names, units, titles, strict=True)
    ]


def _titles(preamble: Sequence[str]) -> list[str]:
    """Return the lines of the section ``[header]``."""
    lines = [line.strip() for line in preamble]
    marks = [i for i, line in enumerate(lines) if line.startswith("[")]
    start = next((i for i in marks if lines[i].lower() == "[header]"), None)
    if start is None:
        return []
    return [line for line in lines[start + 1 : min(i for i in [*marks, len(lines)] if i > start)] if line]
