"""Cueing on a platform that is carried by a base: which of the two moves the driver.

`joint` decides for both in one problem: the base's commands are more columns of B, and the weights and lags
of both decide who does what. Without a base it is `predictive`, bit for bit.
"""

from otolith.core.frames import Dof
from otolith.cueing.design import Design, groups_of, together
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.predictive import predictive_settings
from otolith.interfaces import Cueing


def joint(design: Design) -> Cueing:
    """Make `predictive` over all carriers at once."""
    return together([_mpc(design, (*dofs, *design.platform.bases(dofs))) for dofs in groups_of(design)])


def _mpc(design: Design, dofs: tuple[Dof, ...]) -> Mpc:
    settings = predictive_settings(design.mpc, design.platform, dofs, design.liveliness)
    return Mpc(design.platform, dofs, settings)
