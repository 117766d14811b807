"""The same hexapod in MuJoCo, an independent model and integrator, which checks our own.

A leg is a universal joint on the base, a slide whose armature is the leg's moving mass, and a `connect`
constraint at the platform's joint. Our lumped legs have no weight and no rotation. Here they have little
mass; with a hundredth of it the constraints chatter (5 m/s² in heave). Set-points, supervisor and servos are
ours, so that dynamics are compared and not controllers.

MuJoCo's joints are springs, which causes the difference: if their time constant, four steps, and the step
itself are made 4 and 32 times shorter, the largest difference of the felt force in the hardest scenario
(`step-2`, at its jump) falls from 8.3e-3 to 3.7e-3 and 1.1e-3 m/s². MuJoCo's defaults drift by 0.6 mm. A
servo period is several steps of MuJoCo with the forces held.
"""

from typing import Any, Final

import mujoco  # type: ignore[import-untyped,import-not-found,unused-ignore]
import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY
from otolith.core.rotation import place_of, velocity_of
from otolith.interfaces import Command, PlatformState
from otolith.plant.dynamics import servo
from otolith.plant.hexapod import observed, periods
from otolith.plant.servo_targets import PERIOD, ServoTargets
from otolith.platforms import Platform
from otolith.platforms.hexapod import Hexapod
from otolith.safety.supervisor import Intervention

STEPS: Final = 8  # MuJoCo's steps in a servo period; twice as many take twice the time
LEG: Final = 0.1  # [kg], [kg m²] mass and inertia of each part of a leg, in addition to its armature
SETTLING: Final = 100  # servo periods at rest until the soft constraints carry the weight
STIFF: Final = 4.0  # time constant of the joints' springs, in steps; from 32 steps on, 2 give the same result


class MujocoHexapod:
    """`otolith.plant.hexapod.HexapodPlant` with the dynamics of MuJoCo.

    Parameters
    ----------
    steps : MuJoCo's steps in a servo period; more steps make the joints stiffer.

    Raises
    ------
    InputError : the platform is on cranks, which this model lacks, or its servos are unstable.
    """

    dead_time: Final = 0.0

    def __init__(
        self, hexapod: Hexapod, *, lag: float = 0.01, period: float = PERIOD, steps: int = STEPS
    ) -> None:
        if hexapod.cranks is not None:
            raise InputError("plant", "hexapod-mujoco", "hexapod, for a platform on cranks")
        self.servo_targets, self._steps = ServoTargets(hexapod, lag=lag, period=period), steps
        self.model: Any = mujoco.MjModel.from_xml_string(mjcf(hexapod, period / steps))
        self.data: Any = mujoco.MjData(self.model)
        self._hexapod = hexapod
        self._slides = [self.model.joint(f"slide{i}").qposadr[0] for i in range(6)]
        self._rates = [self.model.joint(f"slide{i}").dofadr[0] for i in range(6)]
        self._neutral = hexapod.lengths(np.zeros(6))
        self._legs = np.zeros((3, 6))
        self.reset(PlatformState())

    @property
    def interventions(self) -> tuple[Intervention, ...]:
        """Return when and why the supervisor reduced the motion."""
        return self.servo_targets.supervisor.interventions

    def reset(self, state: PlatformState) -> None:
        """Set the platform to `state`; errors are those of the supervisor."""
        self.servo_targets.reset(state)
        data, place, velocity = self.data, np.empty(7), np.empty(6)
        mujoco.mj_resetData(self.model, data)
        place_of(state.pose, place)
        velocity_of(state.pose, state.twist, velocity)
        data.qpos[:7], data.qvel[:6] = place, velocity
        data.qvel[3:6] = _rotation(data).T @ velocity[3:]  # a free joint's rate is in its body's frame
        self._close_the_legs(place)
        mujoco.mj_forward(self.model, data)
        if not state.twist.any():
            for _ in range(SETTLING):
                self._hold()

    def _hold(self) -> None:
        """Advance one servo period: sample the legs, hold their forces, move."""
        data = self.data
        self._legs[0] = self._neutral + data.qpos[self._slides]
        self._legs[1] = data.qvel[self._rates]
        servo(self._legs, self.servo_targets.targets, self.servo_targets.machine)
        data.ctrl[:] = self._legs[2]
        mujoco.mj_step(self.model, data, self._steps)

    def _close_the_legs(self, place: Vec) -> None:
        """Set the leg joints so that every leg ends at its platform joint."""
        hexapod = self._hexapod
        ends = place[:3] + hexapod.joints @ _rotation(self.data).T - hexapod.anchors
        neutral = hexapod.joints - hexapod.anchors
        for i in range(6):
            about_x, about_y = _universal(ends[i], neutral[i])
            at = self._slides[i]
            self.data.qpos[at - 2 : at] = about_x, about_y
            self.data.qpos[at] = np.linalg.norm(ends[i]) - self._neutral[i]

    def step(self, command: Command, dt: float) -> PlatformState:
        """Follow the commanded accelerations (6,) for dt [s], a multiple of the servo period."""
        drive, data = self.servo_targets, self.data
        for _ in range(periods(dt, drive.period)):
            before = self._velocity()
            self._hold()
            after = self._velocity()
            drive.tick(command.acceleration)
        return observed(data.qpos[:7].copy(), after, (after - before) / drive.period, self._hexapod.head)

    def _velocity(self) -> Vec:
        """Return (v, ω) (6,) in world."""
        velocity = self.data.qvel[:6].copy()
        velocity[3:] = _rotation(self.data) @ velocity[3:]
        return np.asarray(velocity, dtype=np.float64)


def _rotation(data: Any) -> Vec:
    R = np.empty(9)
    mujoco.mju_quat2Mat(R, data.qpos[3:7])
    return R.reshape(3, 3)


def _universal(end: Vec, neutral: Vec) -> tuple[float, float]:
    """Return the angles about the leg's x, then y axis that turn its neutral direction into that of `end`."""
    x, y, z = _frame(neutral).T @ (end / np.linalg.norm(end))
    return float(-np.arctan2(y, z)), float(np.arcsin(x))


def _frame(neutral: Vec) -> Vec:
    """Return the axes (3, 3) in world of a leg whose z axis points along it in the neutral pose."""
    z = neutral / np.linalg.norm(neutral)
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def mjcf(hexapod: Hexapod, timestep: float) -> str:
    """Return the machine in MuJoCo's XML, in the neutral pose, with world's origin at the reference point."""

    def numbers(values: Vec | tuple[float, ...]) -> str:
        return " ".join(f"{value:.12g}" for value in values)

    soft = f'solref="{STIFF * timestep:.12g} 1" solimp="0.9999 0.99999 0.001"'
    legs, connects, motors = [], [], []
    for i, (anchor, joint) in enumerate(zip(hexapod.anchors, hexapod.joints, strict=True)):
        frame, length = _frame(joint - anchor), float(np.linalg.norm(joint - anchor))
        small = f'mass="{LEG}" diaginertia="{LEG} {LEG} {LEG}" pos="0 0 0"'
        legs.append(
            f'<body pos="{numbers(anchor)}" xyaxes="{numbers(frame[:, 0])} {numbers(frame[:, 1])}">'
            f'<joint type="hinge" axis="1 0 0"/><joint type="hinge" axis="0 1 0"/>'
            f"<inertial {small}/>"
            f'<body name="rod{i}" pos="0 0 {length:.12g}">'
            f'<joint name="slide{i}" type="slide" axis="0 0 1" armature="{hexapod.leg_mass:.12g}"/>'
            f"<inertial {small}/></body></body>"
        )
        connects.append(f'<connect body1="platform" body2="rod{i}" anchor="{numbers(joint)}" {soft}/>')
        motors.append(f'<motor joint="slide{i}"/>')
    return (
        f'<mujoco><option timestep="{timestep:.12g}" gravity="0 0 {-GRAVITY}" iterations="100" '
        f'tolerance="1e-12" integrator="implicitfast"/>'
        f'<worldbody><body name="platform"><freejoint/>'
        f'<inertial pos="{numbers(hexapod.centre)}" mass="{hexapod.mass:.12g}" '
        f'diaginertia="{numbers(hexapod.inertia)}"/></body>{"".join(legs)}</worldbody>'
        f"<equality>{''.join(connects)}</equality><actuator>{''.join(motors)}</actuator></mujoco>"
    )


def hexapod_mujoco(platform: Platform) -> MujocoHexapod:
    """Return the platform's legs in MuJoCo."""
    return MujocoHexapod(platform.six_legs(), lag=platform.actuators.lag_s)
