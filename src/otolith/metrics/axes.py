"""Which axes a run cued, by the names of its degrees of freedom."""

from otolith.core.frames import AXES, DOFS
from otolith.simulate import Run


def force_axes(run: Run) -> dict[str, int]:
    """Specific-force axes (0 x, 1 y, 2 z) that were cued, by name of the degree of freedom."""
    return {name: DOFS[name].felt for name in run.dofs if not DOFS[name].feels_rate}


def rate_axes(run: Run) -> dict[str, int]:
    """Angular rates (2 z) that were cued for their own sake, by name of the degree of freedom."""
    return {name: DOFS[name].felt for name in run.dofs if DOFS[name].feels_rate}


def moving_axes(run: Run) -> dict[str, int]:
    """Axes of the platform that were used, by name, with their index in a six-vector."""
    return {AXES[i]: i for name in run.dofs for i in DOFS[name].axes}
