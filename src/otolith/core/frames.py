"""Frames, signs and degrees of freedom: the only module that converts planar models to the six axes.

The axes are x forward, y left, z up (ISO 8855), with roll, pitch and yaw about them (intrinsic z-y-x), so
positive pitch is nose-down. A six-vector is ordered surge x, sway y, heave z, roll, pitch, yaw.

A *degree of freedom* that is cued is either an axis pair or a single axis. An axis pair couples one
translation and one tilt through one specific force. Its planar model writes f = a + g sin(tilt); the sign
between this tilt and the platform's own angle is defined here only.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError, one_of

GRAVITY: Final = 9.81  # [m/s²] the value used in the thesis
AXES: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass(frozen=True, slots=True)
class Dof:
    """A degree of freedom that is cued: an axis pair or a single axis.

    A pair produces one specific force by moving along its translation and by tilting about its rotation. A
    single axis produces a specific force (heave) or an angular rate (yaw) by its motion alone.
    """

    name: str  # name on the command line: the names of its axes, joined by "-"
    along: str  # name of the cued quantity in scenarios: longitudinal, lateral, vertical or yaw
    # Indices in a six-vector: translation and rotation, or the single axis; 6 more for an axis of the base
    axes: tuple[int, ...]
    sign: float = 1.0  # tilt = sign · angle, chosen so that f = a + g sin(tilt)

    @property
    def is_pair(self) -> bool:
        """True for an axis pair, in which a tilt supports the translation."""
        return len(self.axes) == 2

    @property
    def is_base(self) -> bool:
        """True for an axis of the base that carries the platform, see `otolith.platforms.carriers`."""
        return self.axes[0] >= len(AXES)

    @property
    def feels_rate(self) -> bool:
        """True when an angular rate is cued, False when a specific force is."""
        return self.axes[0] % len(AXES) >= 3

    @property
    def felt(self) -> int:
        """Index of the cued component in a (3,) specific force or angular rate."""
        return self.axes[0] % 3

    @property
    def translation(self) -> int:
        """Index of a pair's translation in a six-vector."""
        return self.axes[0]

    @property
    def rotation(self) -> int:
        """Index of a pair's rotation in a six-vector."""
        return self.axes[1]

    @property
    def signs(self) -> tuple[float, ...]:
        """Sign of the model's coordinate relative to the platform's, one for each of `axes`."""
        return (1.0, self.sign)[: len(self.axes)]


SURGE_PITCH: Final = Dof("surge-pitch", "longitudinal", axes=(0, 4), sign=-1.0)
SWAY_ROLL: Final = Dof("sway-roll", "lateral", axes=(1, 3), sign=+1.0)
HEAVE: Final = Dof("heave", "vertical", axes=(2,))
YAW: Final = Dof("yaw", "yaw", axes=(5,))
DOFS: Final = {dof.name: dof for dof in (SURGE_PITCH, SWAY_ROLL, HEAVE, YAW)}
# Axes of the base by the axis of the platform that they carry; cued by themselves only where the platform is
# not cued with them
BASES: Final = {
    0: Dof("base-surge", "longitudinal", axes=(6,)),
    1: Dof("base-sway", "lateral", axes=(7,)),
    5: Dof("base-yaw", "yaw", axes=(11,)),
}
PAIRS: Final = tuple(dof.name for dof in DOFS.values() if dof.is_pair)


def dofs_named(names: Iterable[str], known: Sequence[str] = tuple(DOFS)) -> tuple[Dof, ...]:
    """Look up degrees of freedom by name and return them in the order of `DOFS`.

    Raises
    ------
    InputError : a name is not one of `known`.
    """
    asked = list(names)
    for name in asked:
        if name not in known:
            raise InputError("--dofs", repr(name), one_of(known, name, otherwise=", or several with commas"))
    return tuple(dof for name, dof in DOFS.items() if name in asked)


def pairs_of(dofs: Iterable[Dof]) -> tuple[Dof, ...]:
    """Return the axis pairs among the given degrees of freedom."""
    return tuple(dof for dof in dofs if dof.is_pair)


def bases_of(dofs: Iterable[Dof]) -> tuple[Dof, ...]:
    """Return the axes of a base that would carry the given degrees of freedom."""
    return tuple(BASES[dof.axes[0]] for dof in dofs if dof.axes[0] in BASES)


def specific_force(acceleration_driver: Vec, attitude: Vec) -> Vec:
    """Specific force felt in the driver's frame, without the standing 1 g.

    f = a + Rᵀ g ẑ − g ẑ with R = Rz(yaw) Ry(pitch) Rx(roll), so that
    f_x = a_x − g sin(pitch) and f_y = a_y + g cos(pitch) sin(roll).

    Parameters
    ----------
    acceleration_driver : (..., 3) [m/s²] acceleration of the head, in the driver's frame.
    attitude : (..., 3) [rad] roll, pitch, yaw of the driver's frame in world.

    Returns
    -------
    (..., 3) [m/s²].
    """
    roll, pitch = attitude[..., 0], attitude[..., 1]
    up_driver = np.stack(
        [-np.sin(pitch), np.cos(pitch) * np.sin(roll), np.cos(pitch) * np.cos(roll) - 1.0], axis=-1
    )
    force: Vec = acceleration_driver + GRAVITY * up_driver
    return force
