"""The record of a drive: where the car was, and what the driver felt."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Mat, Vec, freeze
from otolith.core.frames import GRAVITY
from otolith.recordings import Log, sampled_log
from otolith.vehicle.car import Car
from otolith.vehicle.dynamics import STATES
from otolith.vehicle.profile import Limits, Plan
from otolith.vehicle.road import Road

# Columns of a lap's file, with units. `otolith run --log` reads force, rates, speed and position. The level
# accelerations of `Lap.acceleration` have names that it reads only if they are mapped.
COLUMNS: Final = (
    *("t_s", "fx_mps2", "fy_mps2", "fz_mps2"),
    *("roll_rate_radps", "pitch_rate_radps", "yaw_rate_radps"),
    *("x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad"),
    *("speed_mps", "way_m", "offset_m", "steer_rad", "planned_speed_mps"),
    *("level_ax_mps2", "level_ay_mps2"),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Lap:
    """A drive, evenly sampled. Axes x forward, y left, z up.

    `force` and `rate` are what an inertial sensor at the driver's head would measure, without the standing 1
    g along z; they include the body's roll and pitch. `acceleration` is that of the centre of gravity in the
    plane of the road, as vehicle simulators write it and as drivers' limits are defined.
    """

    road: Road
    car: Car
    time: Vec  # (n,) [s]
    way: Vec  # (n,) [m] along the path
    offset: Vec  # (n,) [m] to the left of the path
    position: Mat  # (n, 3) [m] point of the road surface below the centre of gravity, in world
    attitude: Mat  # (n, 3) [rad] roll, pitch, yaw of the body in world
    velocity: Mat  # (n, 2) [m/s] forward, left
    acceleration: Mat  # (n, 2) [m/s²] forward, left
    force: Mat  # (n, 3) [m/s²] specific force at the head, in the body's axes, without 1 g
    rate: Mat  # (n, 3) [rad/s] of the body, in its axes
    steer: Vec  # (n,) [rad] angle of the front wheels
    load: Mat  # (n, 4) [N] front left, front right, rear left, rear right
    planned_speed: Vec  # (n,) [m/s]

    def __post_init__(self) -> None:
        n = len(self.time)
        widths = {"position": 3, "attitude": 3, "velocity": 2, "acceleration": 2, "force": 3, "rate": 3}
        shapes = {name: (n, width) for name, width in widths.items()} | {"load": (n, 4)}
        freeze(self, **shapes, **dict.fromkeys(("time", "way", "offset", "steer", "planned_speed"), (n,)))

    def columns(self) -> Mat:
        """Return all series as a table (n, 20), see `COLUMNS`."""
        singles = (self.velocity[:, 0], self.way, self.offset, self.steer, self.planned_speed)
        return np.column_stack(
            [self.time, self.force, self.rate, self.position, self.attitude, *singles, self.acceleration]
        )

    def as_log(self, *, at_head: bool = True) -> Log:
        """Return the drive as if it had been recorded, at the driver's head or the car's centre of gravity.

        At the centre of gravity, accelerations are in the plane of the road, without roll and pitch.
        """
        n = len(self.time)
        force = self.force if at_head else np.column_stack([self.acceleration, np.zeros(n)])
        turning = self.rate if at_head else self.rate * np.array([0.0, 0.0, 1.0])
        return sampled_log(self.road.name, self.time, force, turning, place=self.position[:, :2])

    def summary(self, limits: Limits) -> dict[str, Any]:
        """Return time, ranges and how far the driver's limits were exceeded, as plain JSON values."""
        ax, ay = self.acceleration.T
        most = {"drive": ax.max(), "brake": -ax.min(), "lateral": np.abs(ay).max()}
        return {
            "road": self.road.name,
            "source": self.road.source,
            "notes": list(self.road.notes),
            "car": self.car.name,
            "estimated": list(self.car.estimates),
            "time_s": float(self.time[-1]),
            "length_m": float(self.way[-1]),
            "speed_kmh": _range(3.6 * self.velocity[:, 0]),
            "ax_mps2": _range(ax),
            "ay_mps2": _range(ay),
            "felt_x_mps2": _range(self.force[:, 0]),
            "felt_y_mps2": _range(self.force[:, 1]),
            "felt_z_mps2": _range(self.force[:, 2]),
            "yaw_rate_degps": _range(np.degrees(self.rate[:, 2])),
            "offset_m": _range(self.offset),
            "limit_excess_percent": {
                name: float(100.0 * max(0.0, value / getattr(limits, name) - 1.0))
                for name, value in most.items()
            },
        }


def lap_from_records(time: Vec, records: Mat, *, road: Road, car: Car, plan: Plan) -> Lap:
    """Make a lap from states and extras (n, 36) of `otolith.vehicle.dynamics`."""
    x, extra = records[:, :STATES], records[:, STATES:]
    s, e, chi = x[:, 0], x[:, 1], x[:, 2]
    around = np.mod(s, road.length) if road.closed else s
    psi, grade, bank = (np.interp(around, road.way, v) for v in (road.heading, road.grade, road.banking))
    body = np.stack([x[:, 8], x[:, 10], np.zeros_like(s)], axis=1)  # relative to the road
    attitude = body + np.stack([bank, -grade, psi + chi], axis=1)
    tilting = np.gradient(np.stack([bank, -grade], axis=1), time, axis=0)  # tilting of the road under the car
    rate = np.stack([x[:, 9] + tilting[:, 0], x[:, 11] + tilting[:, 1], x[:, 5]], axis=1)
    felt = in_body(extra[:, :3] + np.array([0.0, 0.0, GRAVITY]), body)
    head = car.driver_head
    force = at_point(felt, rate, extra[:, 3:6], np.array([head.x_m, head.y_m, head.z_m]))
    return Lap(
        road=road,
        car=car,
        time=time,
        way=s,
        offset=e,
        position=road.place(s, e),
        attitude=attitude,
        velocity=x[:, 3:5],
        acceleration=extra[:, :2] - GRAVITY * np.stack([np.sin(grade), np.sin(bank)], axis=1),
        force=force - np.array([0.0, 0.0, GRAVITY]),
        rate=rate,
        steer=x[:, 12],
        load=extra[:, 6:10],
        planned_speed=np.interp(around, road.way, plan.speed),
    )


def in_body(vector_road: Mat, attitude: Mat) -> Mat:
    """Rotate (n, 3) vectors from the road's axes to a body rolled and pitched by `attitude` (n, 3) [rad]."""
    x, y, z = vector_road.T
    roll, pitch = attitude[:, 0], attitude[:, 1]
    ahead = x * np.cos(pitch) - z * np.sin(pitch)
    up = x * np.sin(pitch) + z * np.cos(pitch)
    return np.stack(
        [ahead, y * np.cos(roll) + up * np.sin(roll), up * np.cos(roll) - y * np.sin(roll)], axis=1
    )


def at_point(force: Mat, rate: Mat, turning: Mat, point: Vec) -> Mat:
    """Return (n, 3) specific force at a point of a rigid body, f + ω̇ × p + ω × (ω × p).

    Parameters
    ----------
    turning : (n, 3) [rad/s²] the angular acceleration ω̇.
    """
    p = np.broadcast_to(point, force.shape)
    moved: Mat = force + np.cross(turning, p) + np.cross(rate, np.cross(rate, p))
    return moved


def _range(values: Vec) -> dict[str, float]:
    return {
        "min": float(values.min()),
        "max": float(values.max()),
        "rms": float(np.sqrt(np.mean(values**2))),
    }
