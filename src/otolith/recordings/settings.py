"""How a recorded drive is to be read, beyond what its file states; a mapping file stores these settings."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

from otolith.core.errors import InputError, one_of

EVENTS: Final = "refuse"
OFFSETS: Final = "keep"


@dataclass(frozen=True, slots=True, kw_only=True)
class LogSettings:
    """What the user states about a recorded drive; the defaults state nothing."""

    columns: Mapping[str, str] = field(
        default_factory=dict
    )  # quantity -> NAME[:UNIT], see `reading.recording`
    needs: Sequence[str] = ()  # quantities that will be cued; empty if unknown
    header: int | None = None  # line of the names, from 1; None to find it by content
    units: int | None = None  # line of the units, from 1; None to find it by content
    axes: str | None = None  # "iso" or "sae"; None for the axes that the file proves
    events: str = EVENTS  # treatment of what is not driving: "refuse", "mark" or "cut"
    offsets: str = OFFSETS  # treatment of the constant force of a tilted sensor: "keep" or "remove"

    def __post_init__(self) -> None:
        """Check what differs from the defaults; only then are the checks of logs imported."""
        if self.axes is not None:
            from otolith.recordings.checks.orientation import parse_axes

            parse_axes(self.axes)
        if self.events != EVENTS:
            from otolith.recordings.events import parse_events

            parse_events(self.events)
        if self.offsets != OFFSETS:
            from otolith.recordings.checks.offsets import parse_offsets

            parse_offsets(self.offsets)


PLAIN: Final = LogSettings()


def settings_to_toml(settings: LogSettings, source: str) -> str:
    """Return the text of a mapping file with all settings that differ from the defaults."""
    lines = [f"# How otolith reads {source}: otolith run --log {source} --mapping THIS_FILE"]
    plain = {"header": settings.header, "units": settings.units, "axes": settings.axes}
    plain |= {"events": settings.events if settings.events != EVENTS else None}
    plain |= {"offsets": settings.offsets if settings.offsets != OFFSETS else None}
    lines += [f"{key} = {_toml(value)}" for key, value in plain.items() if value is not None]
    lines += ["", "[columns]", *(f"{key} = {_toml(text)}" for key, text in settings.columns.items())]
    return "\n".join(lines) + "\n"


def settings_from_toml(text: str, source: str) -> LogSettings:
    """Read settings from the text of a mapping file.

    Raises
    ------
    InputError : the text is not TOML, or a field is unknown or of a wrong type.
    """
    from otolith.recordings.columns import QUANTITIES

    try:
        data: dict[str, Any] = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            f"mapping {source}", f"not TOML ({error})", "a file as --save-mapping writes it"
        ) from None
    kinds = {"header": int, "units": int, "axes": str, "events": str, "offsets": str, "columns": dict}
    for key, value in data.items():
        if key not in kinds:
            raise InputError(f"field of {source}", repr(key), one_of(kinds, key))
        if not isinstance(value, kinds[key]) or isinstance(value, bool):
            raise InputError(f"{key} in {source}", repr(value), f"of kind {kinds[key].__name__}")
    for key, value in data.get("columns", {}).items():
        if key not in QUANTITIES or not isinstance(value, str):
            raise InputError(
                f"columns.{key} in {source}", repr(value), f"a text for {one_of(QUANTITIES, key)}"
            )
    return LogSettings(**data)


def _toml(value: int | str) -> str:
    """Write a number, or a basic string with TOML's escapes."""
    if isinstance(value, int):
        return str(value)
    escaped = value.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped) + '"'
