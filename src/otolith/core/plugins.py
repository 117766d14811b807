"""Load objects from outside this package: named on the command line, or declared by installed packages.

A *target* is "module:attribute", or "path/to/file.py:attribute" for a file of the user's own. Packages
declare targets as entry points. Any failure in someone else's code becomes one sentence that names its
origin.
"""

import importlib.util
import sys
import traceback
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from otolith.core.errors import InputError, OtolithError

IN_WORDS = "MODULE:ATTRIBUTE, of an installed module or of a file as in washout.py:HighPass"


class BrokenPlugin(OtolithError):
    """Code from outside this package failed; the message names the code, the error and the line."""

    def __init__(self, who: str, what: str, error: BaseException) -> None:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        super().__init__(f"{who} {what}: {reason}{_place(error)}")


def _place(error: BaseException) -> str:
    """File and line in which an error was raised, as text for a message."""
    frames = traceback.extract_tb(error.__traceback__)
    return f" (line {frames[-1].lineno} of {Path(frames[-1].filename).name})" if frames else ""


def declared(group: str) -> dict[str, EntryPoint]:
    """Entry points of a group by name; installed packages are searched once, on first use.

    A name that several distributions declare is among them, and is refused when it is loaded.
    """
    return _search(group)[0]


def doubtful(group: str) -> dict[str, str]:
    """Names of a group that two distributions declare, each with a sentence that says so.

    It would be a matter of luck which of the two is used, so neither is.
    """
    return _search(group)[1]


@cache
def _search(group: str) -> tuple[dict[str, EntryPoint], dict[str, str]]:
    found: dict[str, EntryPoint] = {}
    twice: dict[str, str] = {}
    for one in entry_points(group=group):
        other = found.setdefault(one.name, one)
        if other.value != one.value:
            twice[one.name] = (
                f"{one.name!r} of {group} is declared by {distribution(other)} and by {distribution(one)}: "
                "uninstall one of them"
            )
    return found, twice


def distribution(entry_point: EntryPoint) -> str:
    """The distribution that declares an entry point, with its version."""
    dist = entry_point.dist
    return f"{dist.name} {dist.version}" if dist is not None else "an unknown distribution"


def load_entry_point(entry_point: EntryPoint) -> Any:
    """Import the object that an entry point names.

    Raises
    ------
    BrokenPlugin : it cannot be imported; the message names the distribution.
    OtolithError : another distribution declares the same name.
    """
    if entry_point.name in doubtful(entry_point.group):
        raise OtolithError(doubtful(entry_point.group)[entry_point.name])
    try:
        return entry_point.load()
    except Exception as error:  # code of others may raise anything
        who = f"{entry_point.group} {entry_point.name!r} of {distribution(entry_point)}"
        raise BrokenPlugin(who, "could not be imported", error) from error


def load_target(field: str, target: str) -> Any:
    """Import the object that "module:attribute" or "file.py:attribute" names.

    Parameters
    ----------
    field : the option that named it, for the error message, e.g. "--cueing".

    Raises
    ------
    InputError : the module, the file or the attribute does not exist.
    BrokenPlugin : importing the module failed.
    """
    where, _, attribute = target.rpartition(":")
    if not where or not attribute.isidentifier():
        raise InputError(field, repr(target), IN_WORDS)
    module = _file(field, Path(where)) if where.endswith(".py") else _module(field, where)
    if not hasattr(module, attribute):
        public = [name for name, value in vars(module).items() if _is_own(value, module)]
        bound = f"an attribute of {where}" + (f", such as {', '.join(public)}" if public else "")
        raise InputError(field, repr(target), bound)
    return getattr(module, attribute)


def _is_own(value: Any, module: ModuleType) -> bool:
    """True when the module itself defines this class or function."""
    name = getattr(value, "__name__", "_")
    return getattr(value, "__module__", None) == module.__name__ and not name.startswith("_")


def _module(field: str, name: str) -> ModuleType:
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and (name == error.name or name.startswith(error.name + ".")):
            raise InputError(field, f"of a module {name!r} that is not installed", IN_WORDS) from None
        raise BrokenPlugin(f"module {name}", "could not be imported", error) from error
    except Exception as error:
        raise BrokenPlugin(f"module {name}", "could not be imported", error) from error


def _file(field: str, path: Path) -> ModuleType:
    if not path.is_file():
        raise InputError(field, f"in a file {str(path)!r} that does not exist", IN_WORDS)
    return _module_of_file(path.resolve(), path.stat().st_mtime_ns)


@cache
def _module_of_file(path: Path, changed: int) -> ModuleType:
    """Load the module in a file, not as the main program. It is loaded again when the time `changed`
    differs.
    """
    del changed
    name = f"otolith_file_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:  # cannot happen for a file that ends in .py
        raise ImportError(f"{path} cannot be imported")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look up their module by name
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise BrokenPlugin(str(path), "could not be imported", error) from error
    return module
