"""Drives a road: the speed is planned, then driver and car are simulated."""

from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.errors import InputError, OtolithError
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel
from otolith.vehicle.car import Car, CarNumbers
from otolith.vehicle.driver import PERIOD, Driver, DriverNumbers, decide
from otolith.vehicle.dynamics import EXTRAS, STATES, RoadNumbers, advance, at
from otolith.vehicle.lap import Lap, lap_from_records
from otolith.vehicle.profile import Plan, plan_speed
from otolith.vehicle.road import Road

STEP: Final = 1e-3  # [s]; half of it changes the results by less than 1e-4 m/s², see the tests
OFF_ROAD: Final = 8.0  # [m] distance from the path at which a drive is aborted
TIME_FACTOR: Final = 2.0  # longest duration of a drive, relative to the plan …
TIME_EXTRA: Final = 30.0  # [s] … plus this time
AT_REST: Final = 0.02  # [m/s]
RESTING: Final = 2.0  # [s] that are recorded after the car has come to rest
ROLL_IN: Final = 6.0  # [s] of driving before a flying start, after which the initial state no longer matters


class LeftTheRoad(OtolithError):
    """The car went too far from the path, or stopped on it."""


def drive(
    road: Road,
    car: Car,
    driver: Driver,
    *,
    standing: bool = False,
    step: float = STEP,
    rate_hz: float = 100.0,
) -> Lap:
    """Drive a road from its first node to its last.

    Parameters
    ----------
    standing : whether to start from rest; otherwise at the planned speed (on a closed road: a flying lap).
    step : [s] of the integration; must divide the driver's period of 10 ms.
    rate_hz : sampling rate of the record, at most 1/step and a divisor of it.

    Raises
    ------
    InputError : step or rate is not such a divisor.
    LeftTheRoad : the car went more than 8 m off the path, or stopped before the end.
    """
    every = _divides("step", PERIOD, step)
    keep = _samples_between(rate_hz, step)
    p = car.numbers()
    plan = plan_speed(road, driver.limits, power=p.P, mass=p.m, standing=standing)
    planned = float(np.sum(road.step / np.maximum(0.5 * (plan.speed[1:] + plan.speed[:-1]), 0.5)))
    numbers = road_numbers(road, plan)
    x, command = np.zeros(STATES), np.zeros(2)
    if not standing:
        _roll_in(x, command, numbers, (p, driver.numbers(car)), (step, every))
    rows = int((TIME_FACTOR * planned + TIME_EXTRA) / (keep * step)) + 2
    records = np.empty((rows, STATES + EXTRAS))
    clockwork = np.array([step, every, keep, road.length])
    count = _run(x, command, numbers, p, driver.numbers(car), records, clockwork)
    records = records[:count]
    check_arrival(records, road, rows)
    time = np.arange(count, dtype=np.float64) * (keep * step)
    return lap_from_records(time, records, road=road, car=car, plan=plan)


def _roll_in(
    x: Vec,
    command: Vec,
    road: RoadNumbers,
    who: tuple[CarNumbers, DriverNumbers],
    clock: tuple[float, int],
) -> None:
    """Replace state `x` and `command`, both zero, by those of a car that rolls to the first node.

    The car drives the last `ROLL_IN` seconds before that node: on a closed road its end, on an open road a
    continuation of its beginning, at the speed of its first node. If it were put into a bend without this, it
    would have to start turning at once, and its lateral acceleration would overshoot by a fifth.
    """
    p, d = who
    length = road.step * (road.table.shape[1] - 1)
    if not road.closed:
        held = np.ascontiguousarray(np.repeat(road.table[:, :1], 2, axis=1))
        held[[3, 5]] = 0.0  # without crest and acceleration
        road = road._replace(table=held, profile=np.zeros((2, 2)), profile_step=1.0)
    x[0] = -min(ROLL_IN * road.table[4, 0], length)
    x[3], a = (at(road.table[row], road.step, road.closed, x[0]) for row in (4, 5))
    x[13] = command[1] = a + p.drag * x[3] ** 2 / p.m + p.roll_resistance * GRAVITY
    _approach(x, command, road, p, d, np.array(clock))
    if not (x[0] >= 0.0 and abs(x[1]) < OFF_ROAD):
        raise LeftTheRoad("the car did not arrive at the start: the road begins too steep or too tight")
    x[0] = 0.0


def road_numbers(road: Road, plan: Plan) -> RoadNumbers:
    """Return the road and the plan in the form of the compiled equations."""
    rows = [road.curvature, road.grade, road.banking, road.crest, plan.speed, plan.acceleration]
    profile = np.zeros((2, 2)) if road.profile is None else np.ascontiguousarray(road.profile.T)
    return RoadNumbers(
        table=np.ascontiguousarray(np.stack(rows)),
        step=road.step,
        closed=road.closed,
        profile=profile,
        profile_step=road.length / (profile.shape[1] - 1),
    )


@kernel
def _approach(x: Vec, command: Vec, road: RoadNumbers, p: CarNumbers, d: DriverNumbers, clock: Vec) -> None:
    """Advance `x` and `command` from a negative distance to the first node.

    Parameters
    ----------
    clock : step [s], steps per decision.
    """
    work, k = np.zeros((6, STATES)), 0
    while x[0] < 0.0 and x[3] > AT_REST and abs(x[1]) < OFF_ROAD:
        if k % int(clock[1]) == 0:
            decide(x, road, p, d, command)
        advance(x, command, road, p, clock[0], work)
        k += 1


@kernel
def _run(
    x: Vec, command: Vec, road: RoadNumbers, p: CarNumbers, d: DriverNumbers, records: Mat, clockwork: Vec
) -> int:
    """Fill `records` row by row until the road ends; return the number of rows, and leave `x` at the end.

    Parameters
    ----------
    clockwork : step [s], steps per decision, steps per record, length of the road [m].
    """
    dt, every, keep, length = clockwork[0], int(clockwork[1]), int(clockwork[2]), clockwork[3]
    work, rest, count, k = np.zeros((6, STATES)), 0.0, 0, 0
    while count < len(records) and x[0] < length and abs(x[1]) < OFF_ROAD and rest < RESTING:
        if k % every == 0:
            decide(x, road, p, d, command)
        if k % keep == 0:
            copy_to(records[count, :STATES], x)
        advance(x, command, road, p, dt, work)
        if k % keep == 0:
            copy_to(records[count, STATES:], work[5, :EXTRAS])
            count += 1
        k += 1
        resting = abs(x[3]) < AT_REST and k * dt > 1.0
        rest = rest + dt if resting else 0.0
    return count


def _samples_between(rate_hz: float, step: float) -> int:
    """Return the number of integration steps between samples of the record."""
    highest = round(1.0 / step)
    every = round(highest / rate_hz) if 1.0 <= rate_hz <= highest else 0
    if every < 1 or abs(every * rate_hz - highest) > 1e-6 * highest:
        some = ", ".join(f"{highest / k:g}" for k in (1, 2, 5, 10, 20, 50) if highest % k == 0)
        raise InputError(
            "rate", f"{rate_hz:g} Hz", f"{highest} Hz or a whole fraction of it, such as {some} Hz"
        )
    return every


def _divides(name: str, whole: float, step: float) -> int:
    """Return how often `step` fits into `whole`, or refuse a step that does not divide it."""
    ratio = round(whole / step) if step > 0.0 else 0
    if ratio < 1 or abs(ratio * step - whole) > 1e-9:
        raise InputError(name, f"{step:g} s for {whole:g} s", "a whole number of steps")
    return ratio


def check_arrival(records: Mat, road: Road, rows: int) -> None:
    """Refuse a drive that went wrong, because none of it may become a reference."""
    s, e, v = records[-1, 0], records[-1, 1], records[-1, 3]
    where = f"at {s:.0f} m of {road.name}"
    if not np.isfinite(records).all():
        raise LeftTheRoad(f"the car lost all grip {where}: lower the speed or the limits")
    if abs(e) > OFF_ROAD - 1.0:
        raise LeftTheRoad(f"the car is {abs(e):.1f} m off the path {where}: lower the speed or the limits")
    stopped = v < AT_REST and road.speed_limit[-1] > 0.0
    if len(records) == rows or stopped:
        raise LeftTheRoad(f"the car did not arrive, it does {3.6 * v:.1f} km/h {where}")
