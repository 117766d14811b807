"""Packages whose names are imported when they are first used.

A command waits only for what it calls: the package of a drive's roads, for one, would otherwise bring numba
and half of SciPy along before a list of road names could be printed.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def on_first_use(package: str, where: Mapping[str, str]) -> Callable[[str], Any]:
    """Make the `__getattr__` of a package that imports each of its names on first use.

    A type checker sees nothing of this: the package states the same imports below `if TYPE_CHECKING:`.
    A name may not be that of a module of the package too, for the module would hide it once imported.

    Parameters
    ----------
    package : full name of the package, its `__name__`.
    where : for each name "module:attribute", or "module" for an attribute of the same name; the module is
        one of the package.
    """

    def found(name: str) -> Any:
        if name not in where:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, _, attribute = where[name].partition(":")
        value = getattr(import_module(f"{package}.{module}"), attribute or name)
        setattr(import_module(package), name, value)
        return value

    return found
