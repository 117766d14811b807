"""The laps of section 6.3 as jobs: Hockenheim in 4 DOF, on the ideal plant and on the hexapod.

Changes are those of the structured engine: counting as `otolith_thesis.counting_engine` does would take ten
minutes for twelve laps. They are not iterations of the thesis's kind, so Table 6.4 compares only the savings
by guesses.

The thesis's limits exceed the reach of the legs (a disc of 0.5 m with 30 deg of tilt). On the hexapod the
laps are therefore cued with what surge, sway, roll and pitch can do in every combination (platform
`davsi-4dof`), and with the soft tilt rate of eq. 6.2: the servos, which the model does not include, can
violate it.
"""

import functools
import time
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.cueing.design import Design
from otolith.cueing.hints.coarse import Coarse
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import MpcSettings
from otolith.interfaces import Cueing, Plant
from otolith.loop import Run, simulate
from otolith.metrics import excesses
from otolith.plant import Ideal
from otolith.plant.hexapod import hexapod
from otolith.registry import CUEING
from otolith.scenarios import Scenario
from otolith.scenarios.perceived import perceived
from otolith.vehicle.car import load_car
from otolith.vehicle.closed_loop import drive
from otolith.vehicle.driver import Driver
from otolith.vehicle.roads import road
from otolith_thesis.emulator import PENALTY
from otolith_thesis.hint_loops import coarse_laws
from otolith_thesis.lap_reference import SPEEDS, hockenheim_reference
from otolith_thesis.loop import EXPLICIT, FOUR_DOF, MODELS, Closed, Loop, closed

SAYS: Final = {"longitudinal": "surge-pitch", "lateral": "sway-roll"}
TOGETHER: Final = "davsi-4dof"  # platform whose limits all four axes can reach together
SOFT: Final = {"tilt_rate": PENALTY}  # eq. 6.2
FASTEST: Final = SPEEDS[-1]  # [km/h]
STUDIED: Final = MODELS[-1]  # the thesis's own model, shown in all its figures
BRAKES: Final = 0.5  # [m/s²] a larger deceleration is braking, not rolling resistance and drag
EVERY: Final = 10  # only one training manoeuvre in this many is used for the certified guess


@functools.lru_cache(maxsize=len(SPEEDS))
def _reference(speed: int) -> Scenario:
    return hockenheim_reference(speed)


def _loop(cueing: str, platform: str = "thesis") -> Loop:
    """Return the controller of chapter 5 in 4 DOF."""
    return Loop(scenario="lap", cueing=cueing, dofs=FOUR_DOF, solver="structured", on=platform)


@dataclass(frozen=True, slots=True)
class Lap:
    """One lap of Hockenheim in 4 DOF on the ideal plant."""

    speed: int  # [km/h]
    cueing: str
    share: float = 1.0  # share of the reference that is cued
    on: str = "thesis"  # platform

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"{self.cueing} on {self.share:g} × a lap at {self.speed} km/h"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 6.0 if self.on == "thesis" else 9.0

    def run(self) -> Closed:
        """Drive the lap, then cue it."""
        loop = _loop(self.cueing, self.on)
        reference = perceived(_reference(self.speed), lambda force, _: self.share * force, name="a factor")
        return closed(loop, _cued(loop, loop.controller(), Ideal(), reference))


def _cued(loop: Loop, cueing: Cueing, plant: Plant, reference: Scenario) -> Run:
    return simulate(cueing, plant, reference, platform=loop.platform, dofs=loop.dofs)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnLegs:
    """The result of a lap on the hexapod."""

    closed: Closed
    interventions: int  # number of interventions of the supervisor
    # Number of nodes beyond a limit of the platform's file, by quantity, without zeros
    broken: dict[str, int]
    seconds: float  # [s] CPU time of the whole lap with controller, plant and record


@dataclass(frozen=True, slots=True)
class LapOnLegs:
    """One lap of Hockenheim in 4 DOF on the hexapod, within the limits of its legs."""

    speed: int  # [km/h]
    cueing: str
    on: str = TOGETHER  # platform

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"{self.cueing} on a lap at {self.speed} km/h, hexapod"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 12.0

    def run(self) -> OnLegs:
        """Drive the lap, then cue it."""
        loop, reference = _loop(self.cueing, self.on), _reference(self.speed)
        settings = MpcSettings(braking=BrakingRows.POSITION, soft=SOFT)
        design = Design(platform=loop.platform, dofs=loop.pairs, explicit=EXPLICIT[2], mpc=settings)
        plant = hexapod(loop.platform)
        cueing = CUEING[self.cueing].load()(design)
        began = time.process_time()
        run = _cued(loop, cueing, plant, reference)
        seconds = time.process_time() - began
        return OnLegs(
            closed=closed(loop, run),
            interventions=len(plant.interventions),
            broken={one.quantity: one.violations for one in excesses(run) if one.violations},
            seconds=seconds,
        )


@dataclass(frozen=True, slots=True)
class HintedLaps:
    """The laps of the implicit MPC on the ideal plant, with one certified guess for all."""

    speeds: tuple[int, ...] = SPEEDS
    every: int = EVERY

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"certified guess, laps at {', '.join(map(str, self.speeds))} km/h"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 20.0 + 8.0 * len(self.speeds)

    def run(self) -> dict[int, Closed]:
        """Learn the hint from training manoeuvres, then cue every lap; return the results by speed."""
        loop = _loop(MODELS[0])
        platform, pairs, settings = loop.platform, loop.pairs, MpcSettings(braking=BrakingRows.POSITION)
        laws = coarse_laws(platform, pairs, settings, every=self.every)
        return {
            speed: closed(
                loop,
                _cued(
                    loop,
                    Mpc(platform, pairs, settings, hint=Coarse(laws, platform, pairs, settings)),
                    Ideal(),
                    _reference(speed),
                ),
            )
            for speed in self.speeds
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Braking:
    """The braking of a lap that reduces the speed most."""

    start: float  # [s]
    end: float  # [s]
    fast: float  # [m/s] at its start
    slow: float  # [m/s] at its end


@dataclass(frozen=True, slots=True, kw_only=True)
class Driven:
    """A lap as it was driven, before it is cued."""

    time: Vec  # (n,) [s]
    place: Mat  # (n, 2) [m] position of the car in world
    braking: Braking
    harshest: float  # [s] time of the car's lowest longitudinal acceleration

    def at(self, t: float) -> Vec:
        """Return the position of the car (2,) [m] at a time [s]."""
        return np.array([np.interp(t, self.time, along) for along in self.place.T])


@dataclass(frozen=True, slots=True)
class Drive:
    """The lap driven from standstill, or entered at full speed."""

    speed: int  # [km/h]
    standing: bool

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"driving Hockenheim at {self.speed} km/h, {'standing' if self.standing else 'flying'} start"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 1.0

    def run(self) -> Driven:
        """Drive the lap."""
        lap = drive(
            road("hockenheim").limited(self.speed / 3.6), load_car(), Driver(), standing=self.standing
        )
        forward = lap.acceleration[:, 0]
        return Driven(
            time=lap.time,
            place=lap.position[:, :2],
            braking=hardest_braking(lap.time, lap.velocity[:, 0]),
            harshest=float(lap.time[int(np.argmin(forward))]),
        )


def hardest_braking(t: Vec, speed: Vec) -> Braking:
    """Return the stretch with deceleration above `BRAKES` over which the speed [m/s] falls most."""
    falling = np.concatenate([[False], np.diff(speed) < -BRAKES * np.diff(t), [False]])
    edges = np.flatnonzero(np.diff(falling.astype(np.int64)))
    starts, ends = edges[::2], edges[1::2]
    worst = int(np.argmax(speed[starts] - speed[ends]))
    i, j = int(starts[worst]), int(ends[worst])
    return Braking(start=float(t[i]), end=float(t[j]), fast=float(speed[i]), slow=float(speed[j]))
