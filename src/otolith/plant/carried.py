"""A platform on a base: any plant for the platform, and axes with a lag for the base below it.

The driver feels both. The force is that of their joint motion in world (`otolith.core.carried`), at the head
if the platform's file gives its place; otherwise it is the planar models' force along the world's axes.
"""

from typing import Any, Final, NamedTuple

import numpy as np

from otolith.compiled import FOLLOW, offered
from otolith.core.arrays import Mat, Vec
from otolith.core.carried import carried
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel
from otolith.core.methods import NO_METHOD, Bound, Method
from otolith.core.rotation import felt
from otolith.interfaces import Command, Plant, PlatformState
from otolith.plant.actuator import Actuator
from otolith.plant.ideal import Ideal
from otolith.platforms import Platform
from otolith.safety.supervisor import Intervention

_follow_one = FOLLOW.call


class _Both(NamedTuple):
    own: Method  # of the platform's plant
    below: Method  # of the base
    head: Vec  # (3,) [m]
    senses: bool
    world: Mat  # (3, 6) of both together


@kernel
def _feel(of: Any, motion: Mat, force: Vec) -> None:
    """Write what a driver feels of a motion (6, 6)."""
    carried(motion, of.world)
    pose, a = of.world[0], of.world[2]
    if of.senses:
        felt(of.head, pose, of.world[1], a, force)
    else:
        sp, cp, sr, cr = np.sin(pose[4]), np.cos(pose[4]), np.sin(pose[3]), np.cos(pose[3])
        force[0] = a[0] - GRAVITY * sp
        force[1] = a[1] + GRAVITY * cp * sr
        force[2] = a[2] + GRAVITY * (cp * cr - 1.0)


@kernel
def _follow(of: Any, command: Vec, motion: Mat, force: Mat) -> int:
    """Follow a command (12,) for n steps; see `otolith.compiled.FOLLOW`."""
    n = len(motion)
    own, below = np.empty((n, 3, 6)), np.empty((n, 3, 6))
    unused = np.empty((n, 3))
    _follow_one(of.own, (command[:6], own, unused))
    _follow_one(of.below, (command[6:], below, unused))
    for k in range(n):
        for row in range(3):
            for axis in range(6):
                motion[k, row, axis] = own[k, row, axis]
                motion[k, 3 + row, axis] = below[k, row, axis]
        _feel(of, motion[k], force[k])
    return 0


class OnBase:
    """A platform's plant carried by a base, whose axes follow their commands with a lag of their own.

    The base has the dead time of the platform's plant.

    Raises
    ------
    InputError : the platform has no base, or its plant offers no compiled method.
    """

    carriers: Final = 2  # platform and base

    def __init__(self, own: Plant, platform: Platform) -> None:
        if platform.base is None:
            raise InputError(
                f"[base] of platform {platform.name}", "missing", "in its file for it to be moved"
            )
        self._own, self._head, lag = own, platform.head, platform.base.lag_s
        self._base = Actuator(lag, own.dead_time) if own.dead_time else Ideal(lag)
        self._motion, self._force = np.empty((1, 6, 6)), np.empty((1, 3))
        self._dt = 0.0  # [s] of the method
        self._method: Bound | None = None  # made on first use
        if offered(own, 1e-3) is None:
            raise InputError("the plant", type(own).__name__, "compiled, to be carried by a base")

    @property
    def dead_time(self) -> float | None:
        """Return the dead time of the platform's plant [s]."""
        return self._own.dead_time

    @property
    def interventions(self) -> tuple[Intervention, ...]:
        """Return those of the platform's plant."""
        return tuple(getattr(self._own, "interventions", ()))

    def reset(self, state: PlatformState) -> None:
        """Set platform and base to `state`."""
        self._own.reset(state)
        self._base.reset(state.base or PlatformState())

    def step(self, command: Command, dt: float) -> PlatformState:
        """Let both follow their commands for dt [s]; a base without a command keeps its speed."""
        method = self.compiled(dt)
        _follow(method.held, command.accelerations(self.carriers), self._motion, self._force)
        return PlatformState.of_motion(self._motion[0], self._force[0])

    def compiled(self, dt: float) -> Bound:
        """Return the method of both for steps of dt [s]."""
        if self._method is None or dt != self._dt:
            own, below = offered(self._own, dt), offered(self._base, dt)
            self._parts = own, below  # keeps their data alive
            head = np.zeros(3) if self._head is None else np.array(self._head, dtype=np.float64)
            both = _Both(
                own=NO_METHOD if own is None else own.method,
                below=NO_METHOD if below is None else below.method,
                head=head,
                senses=self._head is not None,
                world=np.zeros((3, 6)),
            )
            self._dt, self._method = dt, FOLLOW.bind(_follow, both)
        return self._method
