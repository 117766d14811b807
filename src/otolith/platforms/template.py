"""A platform file to start from, with every field explained and the valid numbers of a small rig."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from typing import Final, Literal

from otolith.core.toml import toml_value

Kind = Literal["axes", "legs", "cranks"]  # of machines, as forms know them
Name = Literal["axes", "legs", "cranks", "posts", "seat"]  # of templates
Value = float | str | tuple[float, ...] | None
_FOLDER: Final = files("otolith.platforms") / "templates"
# A table's head or a field, also one that is commented out, with the comment behind it.
_HEAD: Final = re.compile(r"(?:# ?)?\[(?P<table>[a-z_.]+)\](?P<rest>\s*(?:#.*)?)")
_FIELD: Final = re.compile(
    r"(?:# ?)?(?P<key>[a-z_0-9]+)(?P<before> *= *)"
    r'(?P<value>"(?:[^"\\]|\\.)*"|\[.*\]|[^#\s]+)(?P<rest>\s*(?:#.*)?)'
)


def template(name: Name) -> str:
    """Return the text of a commented platform file.

    Parameters
    ----------
    name : "axes" for a machine whose axes move one by one, such as a surge-pitch rig; "legs" for one on six
    linear
        actuators, "cranks" for one on six cranks; "posts" for one on four upright actuators; "seat" for a
        seat mover.
    """
    return (_FOLDER / f"{name}.toml").read_text(encoding="utf-8")


def filled(text: str, values: Mapping[str, Value]) -> str:
    """Return the text of a platform file with other values, its comments and all else as they were.

    Parameters
    ----------
    values : by names such as "surge.velocity_mps". None comments the field out, and with the last of its
        fields a whole table. A field or a table that was commented out, or is not there, is put in.
    """
    tables = _tables(text)
    named: dict[str, dict[str, Value]] = {}
    for name, value in values.items():
        table, _, key = name.rpartition(".")
        named.setdefault(table, {})[key] = value
    for table, fields in named.items():
        if table not in tables and any(value is not None for value in fields.values()):
            tables[table] = _Table(head=f"\n[{table}]")
    return "".join(f"{line}\n" for name, one in tables.items() for line in one.filled(named.get(name)))


@dataclass
class _Table:
    """The lines of one table of a file: its head, and what follows until the next one."""

    head: str | None = None  # None above the first table
    lines: list[str] = field(default_factory=list)

    def filled(self, values: Mapping[str, Value] | None) -> list[str]:
        """Return the lines with these values; None leaves them as they are."""
        if values is None:
            return [*([] if self.head is None else [self.head]), *self.lines]
        rests: dict[str, Value] = {key: value for key, value in values.items() if value is not None}
        if not rests and self.head is not None:
            return [_commented(line) for line in (self.head, *self.lines)]
        written = [self._line(line, values, rests) for line in self.lines]
        added = [f"{key} = {_toml(value)}" for key, value in rests.items()]
        head = [] if self.head is None else [self.head.removeprefix("# ").removeprefix("#")]
        return [*head, *added, *written]

    @staticmethod
    def _line(line: str, values: Mapping[str, Value], rests: dict[str, Value]) -> str:
        found = _FIELD.fullmatch(line)
        if found is None or found["key"] not in values:
            return line
        value = values[found["key"]]
        if value is None:
            return _commented(line)
        rests.pop(found["key"], None)
        return f"{found['key']}{found['before']}{_toml(value)}{found['rest']}"


def _tables(text: str) -> dict[str, _Table]:
    """Return the tables of a file by their names, in their order; "" is what stands above the first."""
    tables = {"": _Table()}
    latest = tables[""]
    for line in text.splitlines():
        found = _HEAD.fullmatch(line)
        if found is None:
            latest.lines.append(line)
        else:
            latest = tables.setdefault(found["table"], _Table())
            latest.head = line
    return tables


def _commented(line: str) -> str:
    return line if not line.strip() or line.startswith("#") else f"# {line}"


def _toml(value: Value) -> str:
    """Return a value as TOML; ends of equal distance are one number."""
    if isinstance(value, tuple):
        if len(value) == 2 and value[0] == -value[1]:
            return repr(value[1])
        return f"[{', '.join(map(repr, value))}]"
    return toml_value(value)
