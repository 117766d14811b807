"""Options of the command line that state how a recorded drive is to be read."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Final

import typer

from otolith import files
from otolith.core.errors import InputError
from otolith.recordings.settings import PLAIN, LogSettings

NEEDS: Final = {"surge-pitch": "ax", "sway-roll": "ay", "heave": "az", "yaw": "yaw_rate"}
OPTIONS: Final = ("column", "header", "units", "axes", "events", "offsets", "mapping")  # only for logs

Columns = Annotated[
    list[str] | None,
    typer.Option(
        "--column",
        metavar="QUANTITY=COLUMN[:UNIT]",
        help="Where a log keeps a quantity, e.g. ax=LongAcc:g; repeatable.",
    ),
]
Header = Annotated[
    int | None, typer.Option(metavar="LINE", help="Line of a log that holds the names of its columns.")
]
Units = Annotated[
    int | None, typer.Option(metavar="LINE", help="Line of a log that holds the units of its columns.")
]
Axes = Annotated[
    str | None,
    typer.Option(help="Axes of a log: iso (y left, z up) or sae (y right, z down); default: as it proves."),
]
Events = Annotated[
    str | None,
    typer.Option(help="What is not driving in a log: refuse (default), mark or cut pauses, jumps, strays."),
]
Offsets = Annotated[
    str | None,
    typer.Option(help="What a tilted sensor adds to a log: keep (default) or remove."),
]
MappingFile = Annotated[
    Path | None,
    typer.Option(metavar="TOML", help="How a log is read, as 'otolith log check --save-mapping' wrote it."),
]


def log_settings(chosen: Mapping[str, Any]) -> LogSettings:
    """Return the settings of the options; an option takes precedence over the file of `--mapping`."""
    settings = PLAIN if chosen.get("mapping") is None else files.read_log_settings(Path(chosen["mapping"]))
    columns = assignments("--column", chosen.get("column") or [])
    needs = [NEEDS[dof] for dof in (chosen.get("dofs") or "").split(",") if dof in NEEDS]
    plain = ("header", "units", "axes", "events", "offsets")
    given = {name: chosen[name] for name in plain if chosen.get(name) is not None}
    return replace(settings, columns={**settings.columns, **columns}, needs=needs, **given)


def assignments(option: str, texts: Sequence[str]) -> dict[str, str]:
    """Return values by name from "name=value"; a repeated name is refused because one value would be lost."""
    values: dict[str, str] = {}
    for text in texts:
        name, value = assignment(option, text)
        if name in values:
            raise InputError(f"{option} {name}", "given twice", "given once")
        values[name] = value
    return values


def assignment(option: str, text: str) -> tuple[str, str]:
    """Split NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise InputError(option, repr(text), "of the form NAME=VALUE")
    return name.strip(), value.strip()
