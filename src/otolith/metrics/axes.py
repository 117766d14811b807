"""Which axes a run cued, by the names of its degrees of freedom."""

from otolith.core.arrays import Vec
from otolith.core.frames import AXES, DOFS
from otolith.loop import Run


def force_axes(run: Run) -> dict[str, int]:
    """Specific-force axes (0 x, 1 y, 2 z) that were cued, by name of the degree of freedom."""
    return {name: DOFS[name].felt for name in run.dofs if not DOFS[name].feels_rate}


def rate_axes(run: Run) -> dict[str, int]:
    """Angular rates (2 z) that were cued for their own sake, by name of the degree of freedom."""
    return {name: DOFS[name].felt for name in run.dofs if DOFS[name].feels_rate}


def moving_axes(run: Run) -> dict[str, int]:
    """Axes of the platform that were used, by name, with their index in a six-vector."""
    return {AXES[i]: i for name in run.dofs for i in DOFS[name].axes}


def by_force(run: Run, values: Vec) -> dict[str, float]:
    """Values of the forces along x, y, z (3,), by name of the degrees of freedom that were cued."""
    return {name: float(values[axis]) for name, axis in force_axes(run).items()}


def by_axis(run: Run, values: Vec) -> dict[str, float]:
    """Values of the platform's axes (6,), by name of the axes that were used."""
    return {name: float(values[axis]) for name, axis in moving_axes(run).items()}


def by_rate(run: Run, values: Vec) -> dict[str, float]:
    """Values of the rates about x, y, z (3,), by name of the degrees of freedom cued for their rate."""
    return {name: float(values[axis]) for name, axis in rate_axes(run).items()}
