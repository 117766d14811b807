"""The errands of a rig: its axis map is learned, this host is tested, every axis is moved alone."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path

from otolith.commander.errands import Errand


def errands(folder: Path) -> Mapping[str, Errand]:
    """Return all errands by their names; what they need is imported when they begin.

    Parameters
    ----------
    folder : the Commander's own.
    """
    return {"learn": partial(_learn, folder)}


def _learn(folder: Path, *arguments: object) -> str:
    from otolith.commander.learning import learn_axes

    return learn_axes(folder, *arguments)  # type: ignore[arg-type]
