"""The driver: sees path and planned speed somewhat ahead, steers, accelerates and brakes.

Steering: what the curvature ahead needs in a steady turn, δ = κ (L + K v²), minus a correction of the car's
predicted offset from the path after the distance D = D₀ + T_D v: δ_c = −k 2 L/D² (e + D sin(χ − χ_κ)), where
χ_κ is the steady turn's own angle to the path. Speed: the planned acceleration ahead, a correction of the
speed error, and compensation of drag and slope, within the limits and with bounded jerk. The preview
compensates the lag of actuators and jerk (0.25 to 0.30 s); a driver without it overshoots corners.
"""

from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel
from otolith.vehicle.car import Car, CarNumbers
from otolith.vehicle.dynamics import RoadNumbers, at
from otolith.vehicle.profile import Limits

PERIOD: Final = 0.01  # [s] between two decisions
MARGIN: Final = 1.04  # factor by which corrections may exceed the limits of the plan
# Share of the jerk when drive builds up: a foot presses the brake faster than the throttle
RELEASE: Final = 0.7
REST: Final = 1.0  # [m/s]: if the plan ends at rest, the driver brakes steadily below this speed


@dataclass(frozen=True, slots=True, kw_only=True)
class Driver:
    """Limits and habits of a driver; defaults are thesis eq. 6.3, and values that suit the shipped car."""

    limits: Limits = field(default_factory=Limits)
    jerk: float = 10.0  # [m/s³]
    steering_preview: float = 0.25  # [s]
    speed_preview: float = 0.30  # [s]
    sight: float = 4.0  # D₀ [m]
    sight_time: float = 0.7  # T_D [s]
    correction: float = 1.3  # k [-]
    speed_gain: float = 2.0  # [1/s]

    def __post_init__(self) -> None:
        for name, value in self.limits._asdict().items():
            _within(f"driver's {name} limit", value, 0.5, 20.0)
        _within("driver's jerk", self.jerk, 0.5, 100.0)
        for name in ("steering_preview", "speed_preview"):
            _within(f"driver's {name}", getattr(self, name), 0.0, 2.0)
        for name in ("sight", "sight_time", "correction", "speed_gain"):
            _within(f"driver's {name}", getattr(self, name), 0.05, 50.0)

    def numbers(self, car: Car) -> "DriverNumbers":
        """Return the numbers of the compiled driver, who knows the car's steady turns."""
        p = car.numbers()
        return DriverNumbers(
            L=car.wheelbase,
            K=car.understeer_gradient,
            l_r=p.l_r,
            K_side=1.0 / (car.tyres.rear_stiffness * GRAVITY),
            drive=self.limits.drive,
            brake=self.limits.brake,
            jerk=self.jerk * PERIOD,
            T_steer=self.steering_preview,
            T_speed=self.speed_preview,
            D_0=self.sight,
            T_D=self.sight_time,
            k=self.correction,
            k_v=self.speed_gain,
        )


class DriverNumbers(NamedTuple):
    """SI numbers of the driver."""

    L: float  # wheelbase
    K: float  # understeer gradient
    l_r: float
    K_side: float  # slip angle of the rear axle per lateral acceleration
    drive: float
    brake: float
    jerk: float  # [m/s²] largest change per decision
    T_steer: float
    T_speed: float
    D_0: float
    T_D: float
    k: float
    k_v: float


@kernel
def decide(x: Vec, road: RoadNumbers, p: CarNumbers, d: DriverNumbers, command: Vec) -> None:
    """Replace `command` (2,), steering angle [rad] and longitudinal acceleration [m/s²]."""
    command[0] = steering(x, road, d)
    wanted = acceleration(x, road, p, d)
    command[1] = max(command[1] - d.jerk, min(command[1] + RELEASE * d.jerk, wanted))


@kernel
def steering(x: Vec, road: RoadNumbers, d: DriverNumbers) -> float:
    """Return the steering angle [rad]."""
    v = max(x[3], 0.0)
    here = at(road.table[0], road.step, road.closed, x[0])
    ahead = at(road.table[0], road.step, road.closed, x[0] + v * d.T_steer)
    steady = -here * (d.l_r - d.K_side * v * v)
    D = d.D_0 + d.T_D * v
    off = x[1] + D * np.sin(x[2] - steady)
    return float(ahead * (d.L + d.K * v * v) - d.k * 2.0 * d.L / D**2 * off)


@kernel
def acceleration(x: Vec, road: RoadNumbers, p: CarNumbers, d: DriverNumbers) -> float:
    """Return the acceleration [m/s²] requested from the actuators, before the bound on jerk."""
    v = x[3]
    planned = at(road.table[4], road.step, road.closed, x[0])
    ahead = at(road.table[5], road.step, road.closed, x[0] + v * d.T_speed)
    if v < REST and planned < 2.0 * REST and ahead < 0.0:
        return -1.0
    a = min(max(ahead + d.k_v * (planned - v), -MARGIN * d.brake), MARGIN * d.drive)
    grade = at(road.table[1], road.step, road.closed, x[0])
    return float(a + GRAVITY * np.sin(grade) + p.drag * v * v / p.m + p.roll_resistance * GRAVITY)


def _within(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise InputError(name, f"{value:g}", f"between {low:g} and {high:g}")
