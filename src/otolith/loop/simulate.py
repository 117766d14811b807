"""The closed loop: a cueing algorithm drives a plant along a scenario, and everything is recorded."""

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import specific_force
from otolith.interfaces import Command, Cueing, Plant, PlatformState, Reference
from otolith.loop.run import Run
from otolith.platforms import Platform
from otolith.scenarios import Scenario

# A jump of the reference must fall on the same side for controller, plant and record, whatever the
# rounding of k·dt: decisions see the value just after an instant, records the value just before.
EDGE = 1e-9  # [s]


class _Motion:
    """Plant-rate series of a run, as they are made."""

    def __init__(self, n: int) -> None:
        self.pose, self.twist, self.acceleration = (np.empty((n, 6)) for _ in range(3))
        self._sensed: Vec | None = None  # (n, 3), once the plant senses

    def note(self, k: int, state: PlatformState) -> None:
        """Keep sample k."""
        self.pose[k], self.twist[k], self.acceleration[k] = state.pose, state.twist, state.acceleration
        if state.specific_force is not None:
            if self._sensed is None:
                self._sensed = np.full((len(self.pose), 3), np.nan)
            self._sensed[k] = state.specific_force

    def series(self) -> dict[str, Any]:
        """Fields of `Run` by name; where the plant senses no force, it is the planar models' (eq. 4.1)."""
        felt = self._sensed
        if felt is None:
            felt = specific_force(self.acceleration[:, :3], self.pose[:, 3:])
        return {
            "felt_force": felt,
            "pose": self.pose,
            "twist": self.twist,
            "acceleration": self.acceleration,
        }


class _Decisions:
    """Control-rate series of a run, as they are made."""

    def __init__(self, m: int) -> None:
        self.command, self.status, self.solver = np.empty((m, 6)), [""] * m, [""] * m
        self.changes, self.guess_missed = np.zeros(m, dtype=np.int64), np.zeros(m, dtype=np.bool_)
        self.residual, self.step_time = np.zeros(m), np.zeros(m)

    def note(self, i: int, command: Command, seconds: float) -> None:
        """Keep decision i, which took so many seconds."""
        outcome = command.outcome
        self.command[i], self.step_time[i] = command.acceleration, seconds
        self.status[i], self.solver[i] = outcome.status.value, outcome.solver
        self.changes[i] = outcome.changes
        self.residual[i], self.guess_missed[i] = outcome.residual, outcome.guess_missed

    def series(self) -> dict[str, Any]:
        """Fields of `Run` by name."""
        return {**vars(self), "status": tuple(self.status), "solver": tuple(self.solver)}


def simulate(
    cueing: Cueing,
    plant: Plant,
    scenario: Scenario,
    *,
    platform: Platform,
    dofs: tuple[str, ...],
    names: tuple[str, str] = ("", ""),
    settings: Mapping[str, Any] | None = None,
    plant_period: float = 1e-3,
    preview: int = 0,
    clock: Callable[[], float] = time.thread_time,
    progress: Callable[[float], None] = lambda _: None,
) -> Run:
    """Close the loop from the neutral pose at rest and record it.

    Parameters
    ----------
    dofs : names of what is cued, see `otolith.core.frames.DOFS`.
    names : of the cueing algorithm and of the plant, for the record.
    plant_period : [s]; the controller's own period must be a whole multiple of it.
    preview : how many of the next periods' forces the controller is given; 0: only what is wanted now. They
        are those that the scenario foresees, or where it foresees nothing, those that come.
    clock : [s] measures the time of each decision; never part of the result's dynamics.
    progress : is called with the fraction done, about a hundred times.

    Raises
    ------
    InputError : the controller's period is no multiple of the plant's.
    """
    every = round(cueing.period / plant_period)
    if every < 1 or abs(every * plant_period - cueing.period) > 1e-9:
        raise InputError("period of the controller", f"{cueing.period} s", f"a multiple of {plant_period} s")
    m = round(scenario.duration / cueing.period)
    n = m * every

    command_time = np.arange(m, dtype=np.float64) * cueing.period
    sample_time = np.arange(1, n + 1, dtype=np.float64) * plant_period
    known_time = np.arange(m + preview, dtype=np.float64) * cueing.period
    wanted_force = scenario.specific_force(known_time + EDGE)  # (m + preview, 3)
    wanted_rate = scenario.angular_rate(command_time + EDGE)  # (m, 3)

    decisions, motion = _Decisions(m), _Motion(n)
    state = PlatformState()
    cueing.reset(state)
    plant.reset(state)
    foreseen = scenario.foreseen
    with threadpool_limits(limits=1):  # small matrices: more threads only wait for each other
        for i in range(m):
            coming = wanted_force[i + 1 : i + 1 + preview]
            if preview and foreseen is not None:
                coming = foreseen(float(command_time[i]), cueing.period, preview)
            reference = Reference(
                specific_force=wanted_force[i],
                angular_rate=wanted_rate[i],
                preview=coming if preview else None,
            )
            started = clock()
            command = cueing.step(state, reference)
            decisions.note(i, command, clock() - started)
            for k in range(i * every, (i + 1) * every):
                state = plant.step(command, plant_period)
                motion.note(k, state)
            if i % max(1, m // 100) == 0:
                progress(i / m)
    progress(1.0)

    return Run(
        scenario=scenario.name,
        cueing=names[0],
        plant=names[1],
        platform=platform,
        dofs=dofs,
        soft=tuple(sorted(getattr(cueing, "soft", ()))),
        settings=settings or {},
        period=cueing.period,
        plant_period=plant_period,
        time=sample_time,
        reference_force=scenario.specific_force(sample_time - EDGE),
        reference_rate=scenario.angular_rate(sample_time - EDGE),
        **motion.series(),
        command_time=command_time,
        **decisions.series(),
        interventions=tuple(getattr(plant, "interventions", ())),
    )
