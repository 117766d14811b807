"""The emulator of chapter 6: a rigid body on six legs, moved by the servos of its legs."""

from typing import Any, Final, NamedTuple

import numpy as np

from otolith.compiled import FOLLOW
from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.core.methods import Bound
from otolith.core.rotation import (
    acceleration_of,
    felt_at,
    place_of,
    pose_acceleration_of,
    pose_of,
    twist_of,
    velocity_of,
)
from otolith.interfaces import Command, PlatformState
from otolith.plant.dynamics import advance
from otolith.plant.ideal import stepped
from otolith.plant.servo_targets import PERIOD, Drive, ServoTargets, tick
from otolith.platforms import Platform
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.unreachable import NoPose
from otolith.safety.supervisor import Intervention


@kernel
def _observe(place: Vec, velocity: Vec, acceleration: Vec, head: Vec, motion: Mat, force: Vec) -> None:
    """Write pose, twist and their second derivative (3, 6), and the specific force at the head (3,)."""
    pose_of(place, motion[0])
    twist_of(motion[0], velocity, motion[1])
    pose_acceleration_of(motion[0], motion[1], acceleration, motion[2])
    felt_at(head, place, velocity, acceleration, force)


def observed(place: Vec, velocity: Vec, acceleration: Vec, head: Vec) -> PlatformState:
    """Return the state that sensors would measure, given a rigid body's motion in world."""
    motion, force = np.empty((3, 6)), np.empty(3)
    _observe(place, velocity, acceleration, head, motion, force)
    return PlatformState(pose=motion[0], twist=motion[1], acceleration=motion[2], specific_force=force)


def periods(dt: float, period: float) -> int:
    """Return the number of servo periods in a step of dt [s].

    Raises
    ------
    ValueError : it is not a whole number.
    """
    n = round(dt / period)
    if n < 1 or abs(n * period - dt) > 1e-9:
        raise ValueError(f"a hexapod's step must be a multiple of its servo period, {period} s, got {dt} s")
    return n


class _Body(NamedTuple):
    drive: Drive
    ticks: int  # servo periods in a step
    before: Mat  # (3, 6) targets at the start of the period, when the legs are sampled
    place: Vec  # (7,)
    velocity: Vec  # (6,)
    acceleration: Vec  # (6,)
    legs: Mat  # (3, 6) lengths [m], speeds [m/s], forces [N]
    head: Vec  # (3,) [m]


@kernel
def _follow(of: Any, command: Vec, motion: Mat, force: Mat) -> int:
    """Follow one command for n steps; see `otolith.compiled.FOLLOW`."""
    drive = of.drive
    for k in range(len(motion)):
        for _ in range(of.ticks):
            for row in range(3):
                for i in range(6):
                    of.before[row, i] = drive.targets[row, i]
            if not tick(drive, command):
                raise NoPose("no pose has the leg lengths that the supervisor passed on")
            if not advance(
                of.place, of.velocity, of.acceleration, of.legs, of.before, drive.machine, drive.dt
            ):
                raise NoPose("the legs folded: no force of theirs moves the platform")
        _observe(of.place, of.velocity, of.acceleration, of.head, motion[k], force[k])
    return 0


class HexapodPlant:
    """A rigid body on six legs with digital servos; the legs are lumped, without friction or play.

    The commanded accelerations become set-points behind the lag of eq. 4.9 and pass the supervisor
    (`otolith.plant.servo_targets`). The servos know the platform's weight in the pose of the set-point, but
    not its inertia. Force and rate are sensed at the head, including rotation and lever arm.

    Raises
    ------
    InputError : the servos' gains are unstable.
    """

    dead_time: Final = 0.0  # servos follow set-points without a dead time; their springs add none

    def __init__(self, hexapod: Hexapod, *, lag: float = 0.01, period: float = PERIOD) -> None:
        self.servo_targets = ServoTargets(hexapod, lag=lag, period=period)
        self.legs = np.zeros((3, 6))  # lengths [m], speeds [m/s], forces [N] at the last servo period
        self._head = hexapod.head
        self._place, self._velocity, self._acceleration = np.zeros(7), np.zeros(6), np.zeros(6)
        self._dt = 0.0  # [s] of the method
        self._method: Bound | None = None
        self.reset(PlatformState())
        self.compiled(period)

    @property
    def interventions(self) -> tuple[Intervention, ...]:
        """Return when and why the supervisor reduced the motion."""
        return self.servo_targets.supervisor.interventions

    def reset(self, state: PlatformState) -> None:
        """Set the platform to `state`; errors are those of the supervisor."""
        self.servo_targets.reset(state)
        place_of(state.pose, self._place)
        velocity_of(state.pose, state.twist, self._velocity)
        acceleration_of(state.pose, state.twist, state.acceleration, self._acceleration)

    def step(self, command: Command, dt: float) -> PlatformState:
        """Follow the commanded accelerations (6,) for dt [s], a multiple of the servo period."""
        return stepped(_follow, self.compiled(dt), command, True)

    def compiled(self, dt: float) -> Bound:
        """Return the method of this plant for steps of dt [s], a multiple of the servo period."""
        if self._method is None or dt != self._dt:
            drive = self.servo_targets
            body = _Body(
                drive=drive.drive,
                ticks=periods(dt, drive.period),
                before=np.zeros((3, 6)),
                place=self._place,
                velocity=self._velocity,
                acceleration=self._acceleration,
                legs=self.legs,
                head=self._head,
            )
            self._dt, self._method = dt, FOLLOW.bind(_follow, body)
        return self._method


def hexapod(platform: Platform) -> HexapodPlant:
    """Return the platform on its own legs.

    Raises
    ------
    InputError : its file describes no legs, or their servos are unstable.
    """
    return HexapodPlant(platform.six_legs(), lag=platform.actuators.lag_s)
