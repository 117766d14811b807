"""The emulator of chapter 6: a rigid body on six legs, moved by the servos of its legs."""

from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
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
from otolith.plant.servo_targets import PERIOD, ServoTargets
from otolith.platforms import Platform
from otolith.platforms.hexapod import Hexapod, NoPose
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
        self.reset(PlatformState())

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
        drive = self.servo_targets
        for _ in range(periods(dt, drive.period)):
            before = drive.targets.copy()  # targets at the start of the period, when the legs are sampled
            drive.tick(command.acceleration)
            moved = advance(
                self._place,
                self._velocity,
                self._acceleration,
                self.legs,
                before,
                drive.machine,
                drive.period,
            )
            if not moved:
                raise NoPose("the legs folded: no force of theirs moves the platform")
        return observed(self._place, self._velocity, self._acceleration, self._head)


def hexapod(platform: Platform) -> HexapodPlant:
    """Return the platform on its own legs.

    Raises
    ------
    InputError : its file describes no legs, or their servos are unstable.
    """
    return HexapodPlant(platform.six_legs(), lag=platform.actuators.lag_s)
