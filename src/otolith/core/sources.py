"""Find the source files that a module depends on, and compute a fingerprint of their content.

A module names everything that it takes from others, functions and constants alike, in import statements.
These are followed recursively within the module's own package and Otolith. Conditional imports and imports
for types alone are followed too: a file too many costs a compilation, one too few a wrong result.
"""

import functools
import hashlib
import os
import re
from pathlib import Path
from typing import Final

OWN: Final = __name__.partition(".")[0]
_ROOT: Final = str(Path(__file__).parents[2])
_IMPORT: Final = re.compile(
    rb"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)|import[ \t]+([\w.]+))", re.MULTILINE
)


def fingerprint(file: str, module: str) -> str:
    """SHA-256 of the source of a module and of all that it imports from its own package and from Otolith.

    Parameters
    ----------
    file : path of the module's source.
    module : full name of the module, from which the root of its package follows.

    Raises
    ------
    OSError : a source file cannot be read.
    """
    place, parts = Path(file).resolve(), module.split(".")
    depth = len(parts) - (place.stem != "__init__")
    packages = ((OWN, _ROOT), (parts[0], str(place.parents[depth]))) if depth else ((OWN, _ROOT),)
    return _together(str(place), packages)


Packages = tuple[tuple[str, str], ...]  # name and root folder of each package that is followed


@functools.cache
def _together(file: str, packages: Packages) -> str:
    seen: set[str] = set()
    waiting = [file]
    while waiting:
        if (one := waiting.pop()) not in seen:
            seen.add(one)
            waiting += _read(one, packages)[1]
    digests = sorted(_read(one, packages)[0] for one in seen)
    return hashlib.sha256("".join(digests).encode()).hexdigest()


@functools.cache
def _read(file: str, packages: Packages) -> tuple[str, tuple[str, ...]]:
    """SHA-256 of a file, and the paths of the files that it imports."""
    text = Path(file).read_bytes()
    imported = {found for name in _names(text, file, packages) if (found := _found(name, packages))}
    return hashlib.sha256(text).hexdigest(), tuple(imported)


def _names(text: bytes, file: str, packages: Packages) -> set[str]:
    """Full names that occur in the import statements of a text and may be modules."""
    names = set()
    for statement in _IMPORT.finditer(text):
        base = (statement[1] or statement[3]).decode()
        if base.startswith("."):
            base = _absolute(base, file, packages)
        parts = re.findall(r"\w+", (statement[2] or b"").decode())
        names |= {base, *(f"{base}.{part}" for part in parts)}
    return names


def _absolute(base: str, file: str, packages: Packages) -> str:
    """Resolve a relative module name, e.g. `..core` in otolith/cueing/mpc/rows.py, to its full name."""
    rest = base.lstrip(".")
    folder = Path(file).parents[len(base) - len(rest) - 1]
    root = next((root for _, root in packages if folder.is_relative_to(root)), None)
    return ".".join([*folder.relative_to(root).parts, *([rest] if rest else [])]) if root else base


@functools.cache
def _found(name: str, packages: Packages) -> str:
    """Path of a module's file if it belongs to one of the packages, else an empty string."""
    for package, root in packages:
        if name == package or name.startswith(f"{package}."):
            path = os.path.join(root, *name.split("."))  # noqa: PTH118 (many calls: pathlib takes ten times as long)
            for file in (f"{path}.py", f"{path}{os.sep}__init__.py"):
                if os.path.isfile(file):  # noqa: PTH113
                    return file
    return ""
