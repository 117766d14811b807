"""The platforms that are shipped with the package."""

import tomllib
from importlib.resources import files
from typing import TYPE_CHECKING

from otolith.core.errors import InputError, one_of

if TYPE_CHECKING:
    from otolith.platforms.platform import Platform

_FOLDER = files("otolith.platforms") / "catalog"


def catalog() -> tuple[str, ...]:
    """Return the names of the shipped platforms, sorted."""
    names = (entry.name.removesuffix(".toml") for entry in _FOLDER.iterdir() if entry.name.endswith(".toml"))
    return tuple(sorted(names))


def descriptions() -> dict[str, str]:
    """Return the description in each shipped platform's file, by name, without making the platform."""
    return {name: tomllib.loads(_text(name))["description"] for name in catalog()}


def load(name: str) -> "Platform":
    """Return a shipped platform by name.

    Raises
    ------
    InputError : there is none of this name.
    """
    from otolith.platforms.platform import parse_platform  # imported here, so that listing names stays fast

    known = catalog()
    if name not in known:
        raise InputError("platform", repr(name), one_of(known, name))
    return parse_platform(_text(name), f"{name}.toml")


def _text(name: str) -> str:
    return (_FOLDER / f"{name}.toml").read_text(encoding="utf-8")
