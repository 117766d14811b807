"""The closed loop: a cueing algorithm drives a plant along a scenario, and everything is recorded.

Where both offer a method of their role (`otolith.compiled`), the loop runs in one compiled call
(`otolith.loop.closed`); otherwise period by period in Python. The numbers are the same.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from threadpoolctl import threadpool_limits

from otolith.compiled import (
    CHANGES,
    MISSED,
    NOTHING,
    RESIDUAL,
    SOLVER,
    SOLVERS,
    STATUS,
    STATUSES,
    CompiledCueing,
    offered,
)
from otolith.core.errors import InputError
from otolith.core.frames import specific_force
from otolith.core.methods import Bound, hold
from otolith.interfaces import Command, Cueing, Plant, PlatformState, Reference
from otolith.loop.closed import CLOCK, Loop, close, follow_once
from otolith.loop.run import Run
from otolith.platforms import Platform
from otolith.scenarios import Scenario

# A jump of the reference must fall on the same side for controller, plant and record, whatever the
# rounding of k·dt: decisions see the value just after an instant, records the value just before.
EDGE = 1e-9  # [s]


class _Wanted:
    """What is wanted at every decision, as far as it is known then."""

    def __init__(self, scenario: Scenario, m: int, period: float, preview: int) -> None:
        known = np.arange(m + preview, dtype=np.float64) * period
        self.force = scenario.specific_force(known + EDGE)  # (m + preview, 3)
        self.rate = scenario.angular_rate(known[:m] + EDGE)  # (m, 3)
        self.preview, self._period = preview, period
        self._foreseen = scenario.foreseen if preview else None

    @property
    def comes_true(self) -> bool:
        """Return whether the preview is the true future and not a forecast of the scenario."""
        return self._foreseen is None

    def at(self, i: int) -> Reference:
        """Return the reference of decision i."""
        coming = self.force[i + 1 : i + 1 + self.preview]
        if self._foreseen is not None:
            coming = self._foreseen(i * self._period, self._period, self.preview)
        return Reference(
            specific_force=self.force[i],
            angular_rate=self.rate[i],
            preview=coming if self.preview else None,
        )


class _Record:
    """Series of a run with m decisions and n plant samples, filled while it runs."""

    def __init__(self, m: int, n: int) -> None:
        self.command, self.result, self.step_time = np.empty((m, 6)), np.zeros((m, 5)), np.zeros(m)
        self.solver: list[str] = []  # of a loop in Python, whose algorithm may name any
        self.motion, self.force = np.empty((n, 3, 6)), np.full((n, 3), np.nan)

    def note(self, k: int, state: PlatformState) -> None:
        """Record plant sample k."""
        self.motion[k, 0], self.motion[k, 1], self.motion[k, 2] = state.pose, state.twist, state.acceleration
        if state.specific_force is not None:
            self.force[k] = state.specific_force

    def series(self) -> dict[str, Any]:
        """Return fields of `Run` by name; if the plant senses no force, it is that of the planar models."""
        pose, twist, acceleration = (np.ascontiguousarray(self.motion[:, row]) for row in range(3))
        sensed = bool(np.isfinite(self.force).any())
        status, solver = (self.result[:, part].astype(np.int64).tolist() for part in (STATUS, SOLVER))
        return {
            "felt_force": self.force if sensed else specific_force(acceleration[:, :3], pose[:, 3:]),
            "pose": pose,
            "twist": twist,
            "acceleration": acceleration,
            "command": self.command,
            "step_time": self.step_time,
            "status": tuple(STATUSES[code].value for code in status),
            "solver": tuple(self.solver or (str(SOLVERS[code]) for code in solver)),
            "changes": self.result[:, CHANGES].astype(np.int64),
            "residual": self.result[:, RESIDUAL].copy(),
            "guess_missed": self.result[:, MISSED] == 1.0,
        }


@dataclass(frozen=True)
class _Task:
    """A loop to run: the algorithm, the plant, what is wanted, and the record."""

    cueing: Cueing
    plant: Plant
    wanted: _Wanted
    record: _Record
    dt: float  # [s] of the plant
    clock: Callable[[], float]
    progress: Callable[[float], None]

    @property
    def decisions(self) -> int:
        """Return the number of periods, m."""
        return len(self.record.command)

    @property
    def every(self) -> int:
        """Return the number of plant steps per period."""
        return round(self.cueing.period / self.dt)

    def step(self, i: int, state: PlatformState) -> Command:
        """Let the algorithm decide, and record the decision."""
        reference, started = self.wanted.at(i), self.clock()
        command = self.cueing.step(state, reference)
        self.record.step_time[i] = self.clock() - started
        self.record.command[i] = command.acceleration
        outcome = command.outcome
        self.record.solver.append(outcome.solver)
        status = STATUSES.index(outcome.status)
        self.record.result[i] = status, 0.0, outcome.changes, outcome.residual, outcome.guess_missed
        return command

    def move(self, i: int, command: Command, method: Bound | None) -> PlatformState:
        """Let the plant follow a command for a period, in one compiled call if it offers one."""
        record, first, after = self.record, i * self.every, (i + 1) * self.every
        if method is not None:
            moved, force = record.motion[first:after], record.force[first:after]
            follow_once(method.method, command.acceleration, moved, force)
            return PlatformState.of_motion(moved[-1], force[-1] if np.isfinite(force[-1]).any() else None)
        for k in range(first, after):
            state = self.plant.step(command, self.dt)
            record.note(k, state)
        return state

    def run(self) -> None:
        """Run the loop in Python."""
        state, m = PlatformState(), self.decisions
        method = offered(self.plant, self.dt)
        for i in range(m):
            state = self.move(i, self.step(i, state), method)
            if i % max(1, m // 100) == 0:
                self.progress(i / m)

    def run_compiled(self, decide: Bound, follow: Bound) -> None:
        """Run the loop in compiled calls of a hundredth each, interrupted by requests of the algorithm."""
        record, m, i = self.record, self.decisions, 0
        loop, _ = hold(
            Loop(
                decide=decide.method,
                follow=follow.method,
                every=self.every,
                known=self.wanted.preview,
                now=np.hstack([self.wanted.force[:m], self.wanted.rate]),
                forces=self.wanted.force,
                state=np.zeros((3, 6)),
                command=record.command,
                result=record.result,
                seconds=record.step_time,
                motion=record.motion,
                force=record.force,
                clock=CLOCK[0],
                clock_of=CLOCK[1],
                read=np.zeros(2, dtype=np.int64),
            )
        )
        while i < m:
            self.progress(i / m)
            last = min(m, i + max(1, m // 100))
            request = NOTHING
            while i < last:
                i, request = close(loop, i, last, int(request != NOTHING))
                if request != NOTHING:
                    self._answer(i, request)

    def _answer(self, i: int, request: int) -> None:
        """Let the algorithm meet, in Python, the request of its kernel at decision i."""
        started = self.clock()
        cast(CompiledCueing, self.cueing).answer(request, self.wanted.at(i))
        self.record.step_time[i] += self.clock() - started


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
    names : names of the cueing algorithm and of the plant, for the record.
    plant_period : [s]; the controller's period must be a whole multiple of it.
    preview : number of coming periods whose forces the controller receives; 0: only what is wanted now. The
        forces are those that the scenario foresees, or the true ones if it foresees none.
    clock : [s] measures the time of each decision; it has no influence on the motion.
    progress : is called with the fraction done, about a hundred times.

    Raises
    ------
    InputError : the controller's period is not a multiple of the plant's.
    """
    every = round(cueing.period / plant_period)
    if every < 1 or abs(every * plant_period - cueing.period) > 1e-9:
        raise InputError("period of the controller", f"{cueing.period} s", f"a multiple of {plant_period} s")
    m = round(scenario.duration / cueing.period)
    n = m * every

    wanted, record = _Wanted(scenario, m, cueing.period, preview), _Record(m, n)
    cueing.reset(PlatformState())
    plant.reset(PlatformState())
    task = _Task(cueing, plant, wanted, record, plant_period, clock, progress)
    with threadpool_limits(limits=1):  # small matrices: more threads only wait for each other
        decide = offered(cueing) if clock is time.thread_time and wanted.comes_true else None
        follow = offered(plant, plant_period)
        if decide is not None and follow is not None:
            task.run_compiled(decide, follow)
        else:
            task.run()
    progress(1.0)

    sample_time = np.arange(1, n + 1, dtype=np.float64) * plant_period
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
        command_time=np.arange(m, dtype=np.float64) * cueing.period,
        **record.series(),
        interventions=tuple(getattr(plant, "interventions", ())),
    )
