"""The platforms that are shipped with the package."""

from importlib.resources import files

from otolith.core.errors import InputError, one_of
from otolith.platforms.platform import Platform, parse_platform

_FOLDER = files("otolith.platforms") / "catalog"


def catalog() -> tuple[str, ...]:
    """Names of the shipped platforms, sorted."""
    names = (entry.name.removesuffix(".toml") for entry in _FOLDER.iterdir() if entry.name.endswith(".toml"))
    return tuple(sorted(names))


def load(name: str) -> Platform:
    """A shipped platform by name.

    Raises
    ------
    InputError : there is none of that name.
    """
    known = catalog()
    if name not in known:
        raise InputError("platform", repr(name), one_of(known, name))
    return parse_platform((_FOLDER / f"{name}.toml").read_text(encoding="utf-8"), f"{name}.toml")
