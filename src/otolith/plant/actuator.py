"""Axes that follow their commands with a dead time and the first-order lag of eq. 4.9.

This extends the simplified dynamics of chapter 5. Networks, drives and interpolators give every platform a
dead time. A controller that does not model it tracks less well and violates limits.
"""

import math
from typing import Any, Final, NamedTuple

import numpy as np

from otolith.compiled import FOLLOW
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.methods import Bound
from otolith.interfaces import Command, PlatformState
from otolith.plant.ideal import axis_dynamics, checked_lag, move_axes, note, part_of_step, stepped
from otolith.platforms import Platform

EDGE: Final = 1e-9  # [s] times that differ by less are equal
_SAME: Final = 1e-12  # [s] durations that differ by less are equal


class _Late(NamedTuple):
    motion: Mat  # (3, 6) pose, twist, acceleration
    A: Mat  # (3, 3) of one axis, over one step
    B: Mat  # (3, 1)
    head: Vec  # (3,) [m]
    senses: bool
    lag: float  # T [s]
    dt: float  # [s]
    dead_time: float  # [s]
    now: Vec  # (1,) [s]
    held: Vec  # (6,) the command in effect
    due: Vec  # (Q,) [s] when the commands on their way take effect; a ring
    coming: Mat  # (Q, 6) these commands
    ring: Ints  # (3,) the first of them, how many they are, and whether the next command is a new one


@kernel
def _hold(of: Any, duration: float) -> None:
    """Move all axes for a duration [s] that may be only a part of a step."""
    if abs(duration - of.dt) < _SAME:
        move_axes(of.motion, of.A, of.B, of.held)
    elif duration > _SAME:
        A, B = np.zeros((3, 3)), np.zeros((3, 1))
        part_of_step(of.lag, duration, A, B)
        move_axes(of.motion, A, B, of.held)


@kernel
def _send(of: Any, command: Vec) -> None:
    """Put a command on its way."""
    place = (of.ring[0] + of.ring[1]) % len(of.due)
    of.due[place] = of.now[0] + of.dead_time
    for i in range(6):
        of.coming[place, i] = command[i]
    of.ring[1] += 1


@kernel
def _receive(of: Any) -> None:
    """Let the first command on its way take effect."""
    place = of.ring[0]
    _hold(of, of.due[place] - of.now[0])
    of.now[0] = max(of.now[0], of.due[place])
    for i in range(6):
        of.held[i] = of.coming[place, i]
    of.ring[0], of.ring[1] = (place + 1) % len(of.due), of.ring[1] - 1


@kernel
def _follow(of: Any, command: Vec, motion: Mat, force: Mat) -> int:
    """Follow what was commanded a dead time ago for n steps; see `otolith.compiled.FOLLOW`."""
    if of.ring[2] == 1:
        _send(of, command)
    for k in range(len(motion)):
        end = of.now[0] + of.dt
        while of.ring[1] > 0 and of.due[of.ring[0]] <= end - EDGE:
            _receive(of)
        _hold(of, end - of.now[0])
        of.now[0] = end
        note(of.motion, of.head, of.senses, motion[k], force[k])
    return 0


class Actuator:
    """The ideal platform, whose commands take effect `dead_time` [s] after they are given.

    The solution is exact, even if the dead time is not a whole number of steps.
    """

    def __init__(
        self, lag: float = 0.01, dead_time: float = 0.01, *, head: tuple[float, float, float] | None = None
    ) -> None:
        if not 0.0 <= dead_time <= 1.0:
            raise InputError("plant dead time", dead_time, "between 0 and 1 s")
        self._lag, self.dead_time = checked_lag(lag), dead_time
        A, B = axis_dynamics(self._lag, 0.001)
        self._memory = _Late(
            motion=np.zeros((3, 6)),
            A=A,
            B=B,
            head=np.array(head or (0.0, 0.0, 0.0)),
            senses=head is not None,
            lag=self._lag,
            dt=0.001,
            dead_time=dead_time,
            now=np.zeros(1),
            held=np.zeros(6),
            due=np.zeros(0),
            coming=np.zeros((0, 6)),
            ring=np.array([0, 0, 1]),
        )
        self._method: Bound | None = None  # made on first use
        self.reset(PlatformState())

    def reset(self, state: PlatformState) -> None:
        """Set the platform to `state`, with no pending command."""
        of = self._memory
        of.motion[0], of.motion[1], of.motion[2] = state.pose, state.twist, state.acceleration
        of.now[:], of.held[:], of.ring[:] = 0.0, 0.0, (0, 0, 1)
        self._given: Command | None = None

    def step(self, command: Command, dt: float) -> PlatformState:
        """Follow the commands that were given a dead time ago, for dt [s]."""
        method = self.compiled(dt)
        self._memory.ring[2] = command is not self._given
        self._given = command
        state = stepped(_follow, method, command, self._memory.senses)
        self._memory.ring[2] = 1
        return state

    def compiled(self, dt: float) -> Bound:
        """Return the method of this plant for steps of dt [s]."""
        if self._method is None or dt != self._memory.dt:
            self._memory = self._with_steps(dt)
            self._method = FOLLOW.bind(_follow, self._memory)
        return self._method

    def _with_steps(self, dt: float) -> _Late:
        """Return the same memory for other steps, with room for all commands of a dead time."""
        of = self._memory
        A, B = axis_dynamics(self._lag, dt)
        first, count, _ = of.ring
        waiting = (first + np.arange(count)) % max(1, len(of.due))
        Q = count + math.ceil(self.dead_time / dt) + 2
        due, coming = np.zeros(Q), np.zeros((Q, 6))
        due[:count], coming[:count] = of.due[waiting], of.coming[waiting]
        return of._replace(A=A, B=B, dt=dt, due=due, coming=coming, ring=np.array([0, count, 1]))


def actuator(platform: Platform) -> Actuator:
    """Return the actuators that the platform's file describes."""
    described = platform.actuators
    return Actuator(described.lag_s, described.dead_time_s, head=platform.head)
