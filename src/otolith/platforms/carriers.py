"""What carries a platform: a base that moves along surge and sway, and about the vertical.

A rail has two axes, x and y; a tripod has three, x, y and yaw. The platform's own axes are about its neutral
pose *on the base*, so that base and platform may both move the driver along one direction. Each has limits of
its own, and a lag of its own.
"""

from typing import Annotated, Any, Final, Self

import numpy as np
from pydantic import BeforeValidator, Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import AXES, BASES, Dof
from otolith.platforms.axes import AxisLimits, Rotation, Table, Translation
from otolith.platforms.bounds import Delay, Radius, Within, refuse

Weight = Annotated[float, BeforeValidator(Within(1e-3, 1e3, "").number)]  # [-]
Coefficient = Annotated[float, BeforeValidator(Within(0.0, 0.0, "").finite)]  # [-] of any sign
_SUMMED: Final = ("surge", "sway", "heave", "base_surge", "base_sway")


class Interference(Table):
    """Where base and platform may be together: the sum of coefficients times places is at most a length."""

    surge: Coefficient = 0.0  # of the platform, on the base
    sway: Coefficient = 0.0
    heave: Coefficient = 0.0
    base_surge: Coefficient = 0.0
    base_sway: Coefficient = 0.0
    at_most_m: Radius

    @model_validator(mode="after")
    def _must_be_of_the_base(self) -> Self:
        if self.base_surge == 0.0 == self.base_sway:
            raise refuse(
                "other than 0, or the base has no part in it", field="base_surge or base_sway", value=0
            )
        return self

    @property
    def weights(self) -> Vec:
        """Return the coefficients (12,) of the platform's six places and of its base's six."""
        weights = np.zeros(2 * len(AXES))
        for name in _SUMMED:
            axis = AXES.index(name.removeprefix("base_")) + len(AXES) * name.startswith("base_")
            weights[axis] = getattr(self, name)
        return weights


class Base(Table):
    """The carrier below a platform. Axes that it does not have are left out of the file."""

    surge: Translation | None = None
    sway: Translation | None = None
    yaw: Rotation | None = None
    lag_s: Delay = 0.08  # [s] between commanded and actual acceleration
    weight: Weight = 1.0  # cost of its commands, relative to those of the platform it carries
    interference: tuple[Interference, ...] = Field(default=(), strict=False)

    @model_validator(mode="after")
    def _must_move(self) -> Self:
        if not self.dofs:
            names = ", ".join(AXES[axis] for axis in BASES)
            raise refuse(f"at least one of {names}", field="the set of axes", value="empty")
        if self.yaw is not None and None in (self.yaw.rate_degps, self.yaw.acceleration_degps2):
            raise refuse("given for the yaw of a base", field="rate or acceleration", value="missing")
        for number, one in enumerate(self.interference):
            for axis in ("surge", "sway"):
                name = f"base_{axis}"
                if getattr(one, name) != 0.0 and getattr(self, axis) is None:
                    field = f"interference.{number}.{name}"
                    raise refuse(f"0: the base has no {axis}", field=field, value=getattr(one, name))
        return self

    @model_serializer(mode="wrap")
    def _without_what_is_absent(self, plain: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out interference that there is not, so that digests of platforms stay as they were."""
        values: dict[str, Any] = plain(self)
        return {name: value for name, value in values.items() if name != "interference" or value}

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
