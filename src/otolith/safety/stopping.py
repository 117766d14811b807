"""The stopping law at work on one platform: it tracks the state, brakes, and judges commands.

The law itself is in `otolith.safety.law`.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import Dof
from otolith.core.jit import kernel
from otolith.interfaces import Command, Outcome, PlatformState, Status
from otolith.platforms import Platform
from otolith.safety.law import HUGE, LONGEST, UNLIMITED, Reach, advance, allowed, stop, to_rest


class Belief(NamedTuple):
    """The tracked state of a platform and the law's limits there, in a form that kernels take."""

    reach: Reach
    cued: Vec  # (6,) one for the axes that are cued, zero for the others
    believed: Mat  # (3, 6) pose, twist and acceleration
    before: Mat  # (3, 6) the tracked state before the last command


@kernel
def observe(belief: Belief, motion: Mat) -> bool:
    """Adopt a measured motion (3, 6) if it is plausible; return False if a number of it is not."""
    for row in range(3):
        for i in range(6):
            if not abs(motion[row, i]) <= HUGE:  # a NaN fails every comparison
                return False
    for row in range(3):
        for i in range(6):
            belief.believed[row, i] = belief.cued[i] * motion[row, i]
    return True


@kernel
def follow(belief: Belief, command: Vec) -> None:
    """Assume that a command (6,) is followed over the period that begins now."""
    for row in range(3):
        for i in range(6):
            belief.before[row, i] = belief.believed[row, i]
    advance(belief.believed, command, belief.reach)


@kernel
def rest(belief: Belief, command: Vec) -> None:
    """Write the law's own command (6,), and assume that it is followed."""
    stop(belief.believed, belief.reach, command)
    follow(belief, command)


class Stopping:
    """The law on one platform: it brakes, judges whether the platform can still stop, and tracks its state.

    Axes that are not cued stay at zero, in the tracked state and in the commands.

    Parameters
    ----------
    dofs : the degrees of freedom that are cued.
    circle : [m] radius of the limit of surge and sway together.
    lag : T [s] between commanded and actual acceleration.
    period : Δ [s] between two decisions.
    """

    def __init__(
        self,
        platform: Platform,
        dofs: Sequence[Dof],
        *,
        circle: float | None = None,
        lag: float,
        period: float,
    ) -> None:
        self.reach = reach_of(platform, dofs)._replace(
            circle=math.inf if circle is None else circle, lag=lag, period=period
        )
        cued = (self.reach.command > 0.0).astype(np.float64)
        self.belief = Belief(self.reach, cued, np.zeros((3, 6)), np.zeros((3, 6)))
        self._measured, self._room = np.empty((3, 6)), np.zeros((2 * LONGEST, 6))
        self.rest(Outcome(status=Status.INVALID))  # compiled now, so that no decision waits for the compiler
        self.allows(np.zeros(6))
        self.reset(PlatformState())

    def reset(self, state: PlatformState) -> None:
        """Assume that the platform is at `state`."""
        self.belief.believed[:] = 0.0
        self.observe(state)

    def observe(self, state: PlatformState) -> bool:
        """Adopt a measured state if it is plausible; otherwise keep the state that the commands have led to.

        Returns
        -------
        False if a number of the state is not plausible.
        """
        measured = self._measured
        measured[0], measured[1], measured[2] = state.pose, state.twist, state.acceleration
        return bool(observe(self.belief, measured))

    def allows(self, acceleration: Vec) -> bool:
        """Return whether a platform that can stop inside its limits still can after a command (6,)."""
        return bool(allowed(self.belief.believed, acceleration, self.reach))

    def decided(self, plan: Mat, outcome: Outcome) -> Command:
        """Return the command of a plan (K, 6), K ≥ 0, which the law extends until rest.

        The first period is assumed to be followed. Without a plan, K = 0, the law brakes at once.
        """
        believed, room = self.belief.believed, self.room(len(plan))
        room[: len(plan)] = plan
        count = to_rest(believed, self.reach, len(plan), room)
        return self.command(believed, count, outcome)

    def room(self, planned: int) -> Mat:
        """Return room (K, 6) for a plan of that many commands and those that come to rest after it."""
        if planned + LONGEST > len(self._room):
            self._room = np.zeros((planned + LONGEST, 6))
        return self._room

    def command(self, after: Mat, count: int, outcome: Outcome) -> Command:
        """Return the first of the `count` commands in the room, which leads to the motion `after` (3, 6)."""
        commands, motion = self._room[: max(1, count)].copy(), after.copy()
        return Command(
            acceleration=commands[0], pose=motion[0], twist=motion[1], plan=commands[1:], outcome=outcome
        )

    def rest(self, outcome: Outcome) -> Command:
        """Return the law's own command, with a plan that comes to rest."""
        return self.decided(np.empty((0, 6)), outcome)


def reach_of(platform: Platform, dofs: Sequence[Dof]) -> Reach:
    """Return the limits of all cued axes in the platform's own signs; `dofs` are of one carrier."""
    low, high = np.full(6, -UNLIMITED), np.full(6, UNLIMITED)
    speed, command = np.full(6, UNLIMITED), np.zeros(6)
    for dof in dofs:
        for axis, sign, limits in zip(dof.axes, dof.signs, platform.limits(dof), strict=True):
            i = axis % 6
            low[i], high[i] = sorted(sign * bound for bound in limits.position)
            speed[i] = limits.velocity
            command[i] = min(limits.command, limits.acceleration, UNLIMITED)
    return Reach(low, high, speed, command, math.inf, 0.0, 0.0)
