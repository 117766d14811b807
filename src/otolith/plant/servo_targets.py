"""From commanded accelerations to the targets of the leg servos, once per servo period.

Set-points are the commanded accelerations integrated behind the lag of eq. 4.9, exactly as the ideal plant
moves. Inverse kinematics turns them into leg lengths and speeds. The supervisor passes on what the legs can
do. If it reduces the motion, the set-points continue from its output, so missed motion is not made up for
later.
"""

from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.rotation import place_of, pose_of, twist_of
from otolith.interfaces import PlatformState
from otolith.plant.dynamics import Machine, carry, damping_bounds, machine
from otolith.plant.ideal import axis_dynamics, move_axes
from otolith.platforms.hexapod import MOST, Hexapod
from otolith.platforms.kinematics import forward, inverse, leg_motion, solve
from otolith.platforms.unreachable import NoPose
from otolith.safety.supervisor import Keeps, Log, Supervisor, record, supervise

PERIOD: Final = 1e-3  # [s] servo period
CLOSE: Final = 1e-12  # [m] tolerance on leg lengths when a pose is computed from them


class Drive(NamedTuple):
    """The set-points, the supervisor and the targets, in a form that kernels take."""

    motion: Mat  # (3, 6) of the set-points
    A: Mat  # (3, 3) of one axis, over one period
    B: Mat  # (3, 1)
    machine: Machine
    legs: Mat  # (3, 6) motion of the legs that the set-points require
    lengths: Vec  # (6,) [m] passed on by the supervisor …
    speeds: Vec  # (6,) [m/s]
    keeps: Keeps
    log: Log
    dt: float  # [s]
    place: Vec  # (7,) of the set-points
    before: Vec  # (6,) twist of the set-points a period ago
    targets: Mat  # (3, 6) lengths, speeds, weights


@kernel
def tick(of: Drive, command: Vec) -> bool:
    """Advance one period: set-points, supervisor, targets of the servos; False if no pose has the lengths."""
    dt, behind = of.dt, 0.0
    for axis in range(6):
        of.before[axis] = of.motion[1, axis]
    move_axes(of.motion, of.A, of.B, command)
    leg_motion(of.motion[0], of.motion[1], of.motion[2], of.machine.actuators, of.legs)
    reason, leg = supervise(of.legs[0], of.legs[1], of.lengths, of.speeds, of.keeps, dt)
    for i in range(6):
        behind = max(behind, abs(of.legs[0, i] - of.lengths[i]))
    record(of.log, reason, leg, behind, dt)
    if reason == 0:
        place_of(of.motion[0], of.place)
    elif not _resume(of.motion, of.place, of.before, of.lengths, of.speeds, of.machine, dt):
        return False
    aim(of)
    return True


@kernel
def aim(of: Drive) -> None:
    """Write lengths, speeds and the weight in this pose into the targets (3, 6)."""
    for i in range(6):
        of.targets[0, i], of.targets[1, i] = of.lengths[i], of.speeds[i]
    carry(of.place, of.machine, of.targets[2])


@kernel
def _resume(motion: Mat, place: Vec, before: Vec, lengths: Vec, speeds: Vec, of: Machine, dt: float) -> bool:
    """Write the motion (3, 6) that has these leg lengths and speeds; `place` is the guess and the result."""
    if forward(lengths, of.actuators, place, CLOSE, MOST) < 0:
        return False
    J, velocity = np.empty((6, 6)), speeds.copy()
    inverse(place, of.actuators, np.empty(6), J, np.empty((6, 3)))
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
        self.supervisor = supervisor = Supervisor(hexapod, period=period)
        A, B = axis_dynamics(lag, period)
        self.period = period
        self.drive = Drive(
            motion=np.zeros((3, 6)),
            A=A,
            B=B,
            machine=machine(hexapod),
            legs=np.empty((3, 6)),
            lengths=supervisor.lengths,
            speeds=supervisor.speeds,
            keeps=supervisor.keeps,
            log=supervisor.log,
            dt=period,
            place=np.zeros(7),
            before=np.zeros(6),
            targets=np.zeros((3, 6)),
        )
        self.reset(PlatformState())
        self.tick(np.zeros(6))  # compiled now, so that no period waits for the compiler
        self.reset(PlatformState())

    @property
    def targets(self) -> Mat:
        """Targets (3, 6) of the servos: lengths, speeds, weights."""
        return self.drive.targets

    @property
    def machine(self) -> Machine:
        """The numbers of the hexapod, as kernels take them."""
        return self.drive.machine

    def reset(self, state: PlatformState) -> None:
        """Start from a state; errors are those of the supervisor."""
        of = self.drive
        self.supervisor.reset(state.pose, state.twist)
        of.motion[0], of.motion[1], of.motion[2] = state.pose, state.twist, state.acceleration
        place_of(state.pose, of.place)
        aim(of)

    def tick(self, acceleration: Vec) -> Mat:
        """Return the targets (3, 6) of the servos at the end of the next period: lengths, speeds, weights.

        Raises
        ------
        NoPose : the legs fold within their strokes, which a sensible geometry excludes.
        """
        if not tick(self.drive, acceleration):
            raise NoPose(f"no pose of the leg lengths {self.supervisor.lengths} m")
        return self.targets


def check_gains(hexapod: Hexapod, period: float) -> None:
    """Refuse servo gains with which the platform would oscillate.

    Raises
    ------
    InputError : the damping is not between the bounds of `otolith.plant.dynamics.damping_bounds`.
    """
    low, high = damping_bounds(hexapod, period)
    if low < hexapod.damping < high:
        return
    field, unit, stiffness, square = "hexapod.legs.damping_nspm", "N s/m", "N/m", 1.0
    if hexapod.cranks is not None:
        field, unit, stiffness = "hexapod.cranks.damping_nmsprad", "N m s/rad", "N m/rad"
        square = hexapod.cranks.radius**2
    servo = f"for a stable servo of {1e3 * period:g} ms and {square * hexapod.stiffness:.4g} {stiffness}"
    bound = f"between {square * low:.4g} and {square * high:.4g} {unit} {servo}"
    raise InputError(field, f"{square * hexapod.damping:.4g}", bound)
