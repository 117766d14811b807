"""The errands of a rig: its axis map is learned, this host is tested, every axis is moved alone."""

from collections.abc import Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, Final

from otolith.commander.errands import Errand, Talk

_MADE: Final = {  # module and function, imported when an errand begins: the process waits with little memory
    "learn": ("otolith.commander.learning", "learn_axes"),
    "check": ("otolith.commander.trials", "try_host"),
    "axis": ("otolith.commander.trials", "try_axes"),
}


def errands(folder: Path) -> Mapping[str, Errand]:
    """Return all errands by their names.

    Parameters
    ----------
    folder : the Commander's own.
    """
    return {word: partial(_carry_out, folder, *where) for word, where in _MADE.items()}


def _carry_out(folder: Path, module: str, name: str, talk: Talk, values: Mapping[str, Any]) -> str:
    sentence: str = getattr(import_module(module), name)(folder, talk, values)
    return sentence
