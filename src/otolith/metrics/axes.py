"""The axes that a run cued, by the names of its degrees of freedom."""

from otolith.core.arrays import Vec
from otolith.core.frames import AXES, DOFS
from otolith.loop import Run


def force_axes(run: Run) -> dict[str, int]:
    """Return the specific-force axes (0 x, 1 y, 2 z) that were cued, by degree of freedom."""
    return {name: DOFS[name].felt for name in run.dofs if not DOFS[name].feels_rate}


def rate_axes(run: Run) -> dict[str, int]:
    """Return the angular rates (2 z) that were cued themselves, by degree of freedom."""
    return {name: DOFS[name].felt for name in run.dofs if DOFS[name].feels_rate}


def moving_axes(run: Run) -> dict[str, int]:
    """Return the platform's axes that were used, by name, with their index among the six axes."""
    return {AXES[i]: i for name in run.dofs for i in DOFS[name].axes}


def by_force(run: Run, values: Vec) -> dict[str, float]:
    """Return the entries of the forces along x, y, z (3,) that were cued, by degree of freedom."""
    return {name: float(values[axis]) for name, axis in force_axes(run).items()}


def by_axis(run: Run, values: Vec) -> dict[str, float]:
    """Return the entries of the platform's axes (6,) that were used, by axis."""
    return {name: float(values[axis]) for name, axis in moving_axes(run).items()}


def by_rate(run: Run, values: Vec) -> dict[str, float]:
    """Return the entries of the rates about x, y, z (3,) that were cued themselves, by degree of freedom."""
    return {name: float(values[axis]) for name, axis in rate_axes(run).items()}
