"""The fixed split of one planned motion between a platform and its base, by a first-order low-pass.

Notation, per axis that both have: c the planned motion, h the platform's part on the base, b the base's, with
p, v, a place, speed, acceleration; T and T_b their lags; τ = 1/(2π · 2 Hz). The base shall be at p_c/(1 +
τs), so that a_b = (v_c − v_b)/τ. With a slow pull towards the places, which commands alone would lose,

    y = (v_c − v_b)/τ + k ((p_c − p_b)/τ − v_b),    u_b = y + T_b (a_c − a_b)/τ,
    u_h = u_c − a_b − T (u_b − a_b)/T_b,

so that the lag of the base delays its share of the motion but not the sum (y and a_c in the middle of the
period). A low-pass leaves no limit of what
it is given; the rest, p_c − p_b = τ v_b and so on, stays within the platform's own limits if

    V_c ≤ min(V_b, S_h/τ),    A_c ≤ min(A_b, V_h/τ, A_h/2).
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import AXES, PAIRS, Dof
from otolith.interfaces import Command, Cueing, Outcome, PlatformState, Reference, Status
from otolith.platforms import AxisLimits, Platform
from otolith.platforms.axes import Rotation, Translation
from otolith.safety.invariant.axis import LEAST_LAG
from otolith.safety.stopping import Stopping

CROSSOVER: Final = 2.0  # [Hz] of Bruschetta, Maran & Beghi (2017)
TIME: Final = 1.0 / (2.0 * math.pi * CROSSOVER)  # τ [s]
_PULL: Final = 1.0  # k [1/s]


def as_one(platform: Platform, dofs: Sequence[Dof]) -> Platform:
    """Return a platform whose axes move as far as base and platform do by the split, and that has no base.

    A limit circle of the platform's own becomes a square inside it.
    """
    own = platform.boxed()
    changed: dict[str, object] = {"base": None, "workspace": own.workspace}
    for dof in platform.bases(dofs):
        name = AXES[dof.axes[0] % 6]
        (below,) = platform.limits(dof)
        changed[name] = _together(getattr(own, name), below)
    return own.model_copy(update=changed)


def _together(own: Translation | Rotation, base: AxisLimits) -> Translation | Rotation:
    """Return the limits of the planned motion along one axis; see this module's docstring."""
    turns = isinstance(own, Rotation)
    of = own.limits(1.0, [own.rate_degps or math.inf]) if isinstance(own, Rotation) else own.limits
    reach, most = min(-of.position[0], of.position[1]), min(of.acceleration, of.command)
    speed = min(base.velocity, reach / TIME)
    acceleration = min(base.acceleration, of.velocity / TIME, 0.5 * most)
    if turns:
        ends = (math.degrees(base.position[0]), math.degrees(base.position[1]))
        rates = {"rate_degps": math.degrees(speed), "acceleration_degps2": math.degrees(acceleration)}
        return own.model_copy(update={"angle_deg": ends, **rates})
    return own.model_copy(
        update={
            "position_m": base.position,
            "velocity_mps": speed,
            "acceleration_mps2": acceleration,
            "command_mps2": None,
        }
    )


class Split:
    """One algorithm that plans as if a single carrier moved the driver, and the split of what it commands.

    Parameters
    ----------
    inner : made for `as_one` of the platform.

    Raises
    ------
    InputError : the platform has no base.
    """

    carriers: Final = 2

    def __init__(self, inner: Cueing, platform: Platform, dofs: Sequence[Dof]) -> None:
        if platform.base is None:
            what = f"[base] of platform {platform.name}"
            raise InputError(what, "missing", "in its file for commands to be split")
        if platform.base.interference:
            what = f"[[base.interference]] of platform {platform.name}"
            raise InputError(
                what, "given", "left out for split, whose low-pass knows no rows; joint keeps them"
            )
        bases = platform.bases(dofs)
        self._inner = inner
        self._lags = max(platform.actuators.lag_s, LEAST_LAG), platform.base.lag_s
        self._shared = [dof.axes[0] % 6 for dof in bases]
        circle = platform.circle if set(PAIRS) <= {dof.name for dof in dofs} else None
        own = Stopping(platform, dofs, circle=circle, lag=self._lags[0], period=inner.period)
        self._stopping = own, Stopping(platform, bases, lag=self._lags[1], period=inner.period)

    @property
    def period(self) -> float:
        """Return the time between two decisions [s]."""
        return self._inner.period

    @property
    def soft(self) -> frozenset[str]:
        """Return the limits that the algorithm may pass with a penalty."""
        return frozenset(getattr(self._inner, "soft", ()))

    def reset(self, state: PlatformState) -> None:
        """Start from `state`."""
        self._inner.reset(self._joined(state))
        self._stopping[0].reset(state)
        self._stopping[1].reset(state.base or PlatformState())

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide for both together, and split the command; brake if one of them could not stop after it."""
        planned = self._inner.step(self._joined(state), reference)
        own, base = self._stopping
        outcome = planned.outcome
        seen = own.observe(state) and base.observe(state.base or PlatformState())
        u_h, u_b = self._split(planned.acceleration) if seen else (np.zeros(6), np.zeros(6))
        if not seen:
            outcome = Outcome(status=Status.INVALID, residual=np.inf)
        elif not (own.allows(u_h) and base.allows(u_b)):
            outcome = replace(outcome, status=Status.REFUSED)
        given = 1 if outcome.status is Status.DECIDED else 0
        command = own.decided(u_h[None][:given], outcome)
        return replace(command, base=base.decided(u_b[None][:given], outcome))

    def _joined(self, state: PlatformState) -> PlatformState:
        """Return the motion of both along the axes that both have; the others are the platform's own."""
        base = state.base or PlatformState()
        rows = [own.copy() for own in (state.pose, state.twist, state.acceleration)]
        for row, below in zip(rows, (base.pose, base.twist, base.acceleration), strict=True):
            row[self._shared] += below[self._shared]
        return PlatformState(pose=rows[0], twist=rows[1], acceleration=rows[2])

    def _split(self, u: Vec) -> tuple[Vec, Vec]:
        """Return the commands (6,) of the platform and of its base; see this module's docstring."""
        T, T_b = self._lags
        h, b = (one.belief.believed[:, self._shared] for one in self._stopping)
        p, v, a = h + b
        share = T / self.period * -math.expm1(-self.period / T)
        a = u[self._shared] + share * (a - u[self._shared])  # mean of the coming period
        change = (a - b[2]) / TIME
        y = (v - b[1]) / TIME + _PULL * ((p - b[0]) / TIME - b[1]) + 0.5 * self.period * change
        of_base = y + T_b * change
        u_h, u_b = u.copy(), np.zeros(6)
        most = self._stopping[1].reach.command[self._shared]
        u_b[self._shared] = np.clip(of_base, -most, most)
        u_h[self._shared] -= b[2] + T * (u_b[self._shared] - b[2]) / T_b
        most = self._stopping[0].reach.command
        return np.clip(u_h, -most, most), u_b
