"""What carries a platform: a base that moves along surge and sway, and about the vertical.

A rail has two axes, x and y; a tripod has three, x, y and yaw. The platform's own axes are about its neutral
pose *on the base*, so that base and platform may both move the driver along one direction. Each has limits of
its own, and a lag of its own.
"""

from typing import Annotated, Self

from pydantic import BeforeValidator, model_validator

from otolith.core.errors import InputError
from otolith.core.frames import AXES, BASES, Dof
from otolith.platforms.axes import AxisLimits, Rotation, Table, Translation
from otolith.platforms.bounds import Delay, Within, refuse

Weight = Annotated[float, BeforeValidator(Within(1e-3, 1e3, "").number)]  # [-]


class Base(Table):
    """The carrier below a platform. Axes that it does not have are left out of the file."""

    surge: Translation | None = None
    sway: Translation | None = None
    yaw: Rotation | None = None
    lag_s: Delay = 0.08  # [s] between commanded and actual acceleration
    weight: Weight = 1.0  # cost of its commands, relative to those of the platform it carries

    @model_validator(mode="after")
    def _must_move(self) -> Self:
        if not self.dofs:
            names = ", ".join(AXES[axis] for axis in BASES)
            raise refuse(f"at least one of {names}", field="the set of axes", value="empty")
        if self.yaw is not None and None in (self.yaw.rate_degps, self.yaw.acceleration_degps2):
            raise refuse("given for the yaw of a base", field="rate or acceleration", value="missing")
        return self

    @property
    def dofs(self) -> tuple[Dof, ...]:
        """Return the base's axes as degrees of freedom."""
        return tuple(dof for axis, dof in BASES.items() if getattr(self, AXES[axis]) is not None)

    def limits(self, dof: Dof) -> AxisLimits:
        """Return the limits of one of its axes.

        Raises
        ------
        InputError : the base lacks the axis.
        """
        name = AXES[dof.axes[0] % len(AXES)]
        table: Translation | Rotation | None = getattr(self, name)
        if table is None:
            raise InputError(f"{name} of the base", "missing", f"in the platform's file for {dof.name}")
        if isinstance(table, Translation):
            return table.limits
        return table.limits(1.0, [table.rate_degps or 0.0])
