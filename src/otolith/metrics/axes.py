"""Which axes a run cued, by the names of its degrees of freedom."""

from otolith.core.frames import AXES, PAIRS
from otolith.simulate import Run


def force_axes(run: Run) -> dict[str, int]:
    """Specific-force axes (0 x, 1 y, 2 z) that were cued, by name of the degree of freedom."""
    index = {name: pair.translation for name, pair in PAIRS.items()} | {"heave": 2}
    return {name: index[name] for name in run.dofs if name in index}


def rate_axes(run: Run) -> dict[str, int]:
    """Angular rates (2 z) that were cued for their own sake, by name of the degree of freedom."""
    return {"yaw": 2} if "yaw" in run.dofs else {}


def moving_axes(run: Run) -> dict[str, int]:
    """Axes of the platform that were used, by name, with their index in a six-vector."""
    return {axis: AXES.index(axis) for name in run.dofs for axis in name.split("-")}
