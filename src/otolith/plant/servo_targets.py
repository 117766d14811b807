"""From commanded accelerations to the targets of the leg servos, once per servo period.

Set-points are the commanded accelerations integrated behind the lag of eq. 4.9, exactly as the ideal plant
moves. Inverse kinematics turns them into leg lengths and speeds. The supervisor passes on what the legs can
do. If it reduces the motion, the set-points continue from its output, so missed motion is not made up for
later.
"""

from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.rotation import place_of, pose_of, twist_of
from otolith.interfaces import PlatformState
from otolith.plant.dynamics import Machine, carry, damping_bounds, machine
from otolith.plant.ideal import axis_dynamics, move_axes
from otolith.platforms.hexapod import MOST, Hexapod, NoPose
from otolith.platforms.kinematics import forward, inverse, leg_motion, solve
from otolith.safety.supervisor import Keeps, Supervisor, supervise

PERIOD: Final = 1e-3  # [s] servo period
CLOSE: Final = 1e-12  # [m] tolerance on leg lengths when a pose is computed from them


@kernel
def _tick(
    motion: Mat,
    dynamics: tuple[Mat, Mat],
    command: Vec,
    of: Machine,
    legs: Mat,
    passed: tuple[Vec, Vec],
    keeps: Keeps,
    dt: float,
    place: Vec,
    targets: Mat,
) -> tuple[int, int]:
    """Advance one period: set-points, supervisor and, if it changed nothing, the servos' targets.

    Returns
    -------
    The result of `otolith.safety.supervisor.supervise`.
    """
    move_axes(motion, dynamics[0], dynamics[1], command)
    leg_motion(motion[0], motion[1], motion[2], of.joints, of.anchors, legs)
    reason, leg = supervise(legs[0], legs[1], passed[0], passed[1], keeps, dt)
    if reason == 0:
        place_of(motion[0], place)
        _aim(place, passed, of, targets)
    return reason, leg


@kernel
def _aim(place: Vec, passed: tuple[Vec, Vec], of: Machine, targets: Mat) -> None:
    """Write lengths, speeds and the weight in this pose into the targets (3, 6)."""
    targets[0] = passed[0]
    targets[1] = passed[1]
    carry(place, of, targets[2])


@kernel
def _resume(motion: Mat, place: Vec, before: Vec, lengths: Vec, speeds: Vec, of: Machine, dt: float) -> bool:
    """Write the motion (3, 6) that has these leg lengths and speeds; `place` is the guess and the result."""
    if forward(lengths, of.joints, of.anchors, place, CLOSE, MOST) < 0:
        return False
    J, velocity = np.empty((6, 6)), speeds.copy()
    inverse(place, of.joints, of.anchors, np.empty(6), J, np.empty((6, 3)))
    if not solve(J, velocity):
        return False
    pose_of(place, motion[0])
    twist_of(motion[0], velocity, motion[1])
    for axis in range(6):
        motion[2, axis] = (motion[1, axis] - before[axis]) / dt
    return True


class ServoTargets:
    """Set-point generator, inverse kinematics, supervisor, and the weight that the servos carry."""

    def __init__(self, hexapod: Hexapod, *, lag: float, period: float = PERIOD) -> None:
        check_gains(hexapod, period)
        self.supervisor = Supervisor(hexapod, period=period)
        self.period, self.targets = period, np.zeros((3, 6))  # lengths, speeds, weights
        self.machine = machine(hexapod)
        self._dynamics = axis_dynamics(lag, period)
        self._passed = (self.supervisor.lengths, self.supervisor.speeds)  # arrays that the supervisor writes
        # Motion of the set-points; leg motion that they require
        self._motion, self._legs = np.zeros((3, 6)), np.empty((3, 6))
        self._place, self._before = np.zeros(7), np.zeros(6)
        self.reset(PlatformState())
        self._go_on()  # compiled now, so that no period waits for the compiler
        self.reset(PlatformState())

    def reset(self, state: PlatformState) -> None:
        """Start from a state; errors are those of the supervisor."""
        self.supervisor.reset(state.pose, state.twist)
        self._motion[0], self._motion[1], self._motion[2] = state.pose, state.twist, state.acceleration
        place_of(state.pose, self._place)
        self._aim()

    def tick(self, acceleration: Vec) -> Mat:
        """Return the targets (3, 6) of the servos at the end of the next period: lengths, speeds, weights."""
        self._before[:] = self._motion[1]
        supervisor = self.supervisor
        code, leg = _tick(
            self._motion,
            self._dynamics,
            acceleration,
            self.machine,
            self._legs,
            self._passed,
            supervisor.keeps,
            self.period,
            self._place,
            self.targets,
        )
        if supervisor.account(code, leg, self._legs[0]):
            self._go_on()
            self._aim()
        return self.targets

    def _go_on(self) -> None:
        """Continue the set-points from the output of the supervisor."""
        lengths, speeds = self.supervisor.lengths, self.supervisor.speeds
        if not _resume(
            self._motion, self._place, self._before, lengths, speeds, self.machine, self.period
        ):  # the legs fold within their strokes, which a sensible geometry excludes
            raise NoPose(f"no pose of the leg lengths {lengths} m")

    def _aim(self) -> None:
        _aim(self._place, self._passed, self.machine, self.targets)


def check_gains(hexapod: Hexapod, period: float) -> None:
    """Refuse servo gains with which the platform would oscillate.

    Raises
    ------
    InputError : the damping is not between the bounds of `otolith.plant.dynamics.damping_bounds`.
    """
    low, high = damping_bounds(hexapod, period)
    if not low < hexapod.damping < high:
        raise InputError(
            "hexapod.legs.damping_nspm",
            f"{hexapod.damping:.4g}",
            f"between {low:.4g} and {high:.4g} N s/m for a stable servo of {1e3 * period:g} ms "
            f"and {hexapod.stiffness:.4g} N/m",
        )
