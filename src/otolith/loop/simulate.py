"""The closed loop: a cueing algorithm drives a plant along a scenario, and everything is recorded.

Where both offer a method of their role (`otolith.compiled`), the loop runs in one compiled call
(`otolith.loop.closed`); otherwise period by period in Python. The numbers are the same.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Final, cast

import numpy as np

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
from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.core.frames import specific_force
from otolith.core.methods import Bound, hold
from otolith.core.threads import one_thread
from otolith.interfaces import Command, Cueing, Plant, PlatformState, Reference
from otolith.loop.closed import CLOCK, Loop, close, follow_once
from otolith.loop.keep import InMemory, Keeper, joined
from otolith.loop.run import Run, periods_of_part, steps_of_period
from otolith.platforms import Platform
from otolith.scenarios import Scenario

# A jump of the reference must fall on the same side for controller, plant and record, whatever the
# rounding of k·dt: decisions see the value just after an instant, records the value just before.
EDGE = 1e-9  # [s]


class _Wanted:
    """What is wanted at the m decisions from `first` on, those of a part, as far as it is known then."""

    def __init__(self, scenario: Scenario, first: int, m: int, period: float, preview: int) -> None:
        known = np.arange(first, first + m + preview, dtype=np.float64) * period
        self.force = scenario.specific_force(known + EDGE)  # (m + preview, 3)
        rate = scenario.angular_rate(known[:m] + EDGE)  # (m, 3)
        self.now = np.hstack([self.force[:m], rate])  # (m, 6)
        self.gain = np.ones(m)  # factor on the scenario
        self.preview, self._first, self._period = preview, first, period
        self._foreseen = scenario.foreseen if preview else None
        self._plain: tuple[Mat, Mat] | None = None  # both without the factor, once there is one

    def rescale(self, first: int, factor: float) -> None:
        """Want the scenario times `factor` from decision `first` on, in place: kernels hold these arrays."""
        if first < len(self.gain):
            self._plain = self._plain or (self.force.copy(), self.now.copy())
            for scaled, plain in zip((self.force, self.now), self._plain, strict=True):
                np.multiply(plain[first:], factor, out=scaled[first:])
            self.gain[first:] = factor

    def at(self, i: int) -> Reference:
        """Return the reference of decision i of the part."""
        coming = self.force[i + 1 : i + 1 + self.preview]
        if self._foreseen is not None:
            now = (self._first + i) * self._period
            coming = self.gain[i] * self._foreseen(now, self._period, self.preview)
        return Reference(
            specific_force=self.now[i, :3],
            angular_rate=self.now[i, 3:],
            preview=coming if self.preview else None,
        )


_STATUS_WORDS: Final = tuple(one.value for one in STATUSES)
_SOLVER_WORDS: Final = tuple(map(str, SOLVERS))


class _Record:
    """Series of a part with m decisions and n plant samples, filled while it runs.

    Parameters
    ----------
    carriers : 2 if the platform is carried by a base that moves, else 1.
    """

    def __init__(self, m: int, n: int, carriers: int = 1) -> None:
        self.command, self.result = np.zeros((m, 6 * carriers)), np.zeros((m, 5))
        self.step_time = np.zeros(m)
        self.solver: list[str] = []  # of a loop in Python, whose algorithm may name any
        self.motion, self.force = np.empty((n, 3 * carriers, 6)), np.full((n, 3), np.nan)

    def note(self, k: int, state: PlatformState) -> None:
        """Record plant sample k."""
        state.write(self.motion[k])
        if state.specific_force is not None:
            self.force[k] = state.specific_force

    def series(self, first: int, last: int, every: int) -> dict[str, Any]:
        """Return fields of `Run` by name, of decisions `first` up to `last` of `every` plant steps each.

        If the plant senses no force, it is that of the planar models.
        """
        result, samples = self.result[first:last], slice(first * every, last * every)
        pose, twist, acceleration = (np.ascontiguousarray(self.motion[samples, row]) for row in range(3))
        command, base = self.command[first:last], self.motion[samples, 3:]
        carried = base.shape[1] > 0
        force = self.force[samples].copy()
        sensed = bool(np.isfinite(force).any())
        status, solver = (result[:, part].astype(np.int64).tolist() for part in (STATUS, SOLVER))
        return {
            "felt_force": force if sensed else specific_force(acceleration[:, :3], pose[:, 3:]),
            "pose": pose,
            "twist": twist,
            "acceleration": acceleration,
            "command": command[:, :6].copy(),
            "base": base.reshape(len(base), -1) if carried else None,
            "base_command": command[:, 6:].copy() if carried else None,
            "step_time": self.step_time[first:last].copy(),
            "status": tuple(map(_STATUS_WORDS.__getitem__, status)),
            "solver": tuple(self.solver[first:last] or map(_SOLVER_WORDS.__getitem__, solver)),
            "changes": result[:, CHANGES].astype(np.int64),
            "residual": result[:, RESIDUAL].copy(),
            "guess_missed": result[:, MISSED] == 1.0,
        }


class ClosedLoop:
    """A closed loop that is run piece by piece: `advance` it, look at what it recorded, change it, go on.

    However it is cut into pieces, the numbers are the same. By itself it is cut into parts of a minute or so:
    of each, what is wanted is asked and what happens is recorded; then the part goes to the keeper.

    Parameters
    ----------
    dofs : names of what is cued, see `otolith.core.frames.DOFS`.
    names : names of the cueing algorithm and of the plant, for the record.
    plant_period : [s]; the controller's period must be a whole multiple of it.
    preview : number of coming periods whose forces the controller receives; 0: only what is wanted now. The
        forces are those that the scenario foresees, or the true ones if it foresees none.
    clock : [s] measures the time of each decision; it has no influence on the motion.
    keep : keeps the record; by default, it stays in memory.

    Raises
    ------
    InputError : the controller's period is not a multiple of the plant's, or the algorithm moves a base that
        the plant does not have.
    """

    def __init__(
        self,
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
        keep: Keeper | None = None,
    ) -> None:
        self.cueing, self.plant, self.scenario, self.platform = cueing, plant, scenario, platform
        self.every = steps_of_period(cueing.period, plant_period)
        self.done = 0  # decisions that were made
        self.dofs, self.names, self.settings, self._dt = dofs, names, settings or {}, plant_period
        self._clock, self._state, self._request = clock, PlatformState(), NOTHING
        self.decisions = round(scenario.duration / cueing.period)
        self._memory = InMemory()
        self._keep = self._memory if keep is None else keep
        self.carriers = _carriers(cueing, plant)
        self._motion, self._gain, self._preview = np.zeros((3 * self.carriers, 6)), 1.0, preview
        cueing.reset(PlatformState())
        plant.reset(PlatformState())
        true = scenario.foreseen is None or not preview  # the preview is no forecast, but what comes
        self._decide = offered(cueing) if clock is time.thread_time and true else None
        self._follow = offered(plant, plant_period)
        self._begin()

    def _begin(self) -> None:
        """Begin the next part."""
        self._first = self.done
        m = min(periods_of_part(self.period, self._dt), self.decisions - self._first)
        self._wanted = _Wanted(self.scenario, self._first, m, self.period, self._preview)
        if self._gain != 1.0:
            self._wanted.rescale(0, self._gain)
        self._record = _Record(m, m * self.every, self.carriers)
        decide, follow = self._decide, self._follow
        self._compiled = None if decide is None or follow is None else self._hold(decide, follow)

    def _hold(self, decide: Bound, follow: Bound) -> Any:
        """Return the part as its kernel takes it."""
        record = self._record
        held, _ = hold(
            Loop(
                decide=decide.method,
                follow=follow.method,
                every=self.every,
                known=self._wanted.preview,
                now=self._wanted.now,
                forces=self._wanted.force,
                state=self._motion,
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
        return held

    @property
    def period(self) -> float:
        """Return the time between two decisions [s]."""
        return self.cueing.period

    def rescale(self, factor: float) -> None:
        """Want the scenario times a factor, from the next decision on."""
        self._gain = factor
        self._wanted.rescale(self.done - self._first, factor)

    def advance(self, last: int) -> None:
        """Run up to decision `last`, without it, or to the end of the scenario."""
        last = min(last, self.decisions)
        while self.done < last:
            end = self._first + len(self._record.command)
            if self.done == end:
                self._keep.add(self._part(self._first))
                self._begin()
            elif self._compiled is None:
                self._advance_in_python(min(last, end))
            else:
                self._advance_compiled(min(last, end))

    def _advance_compiled(self, last: int) -> None:
        while self.done < last:
            here, end = self.done - self._first, last - self._first
            here, self._request = close(self._compiled, here, end, int(self._request != NOTHING))
            self.done = self._first + here
            if self._request != NOTHING:
                self._answer(self._request)

    def _advance_in_python(self, last: int) -> None:
        while self.done < last:
            self._state = self._move(self._step(self._state))
            self.done += 1

    def _step(self, state: PlatformState) -> Command:
        """Let the algorithm decide, and record the decision."""
        i, record = self.done - self._first, self._record
        reference, started = self._wanted.at(i), self._clock()
        command = self.cueing.step(state, reference)
        record.step_time[i] = self._clock() - started
        record.command[i] = command.accelerations(self.carriers)
        outcome = command.outcome
        record.solver.append(outcome.solver)
        status = STATUSES.index(outcome.status)
        record.result[i] = status, 0.0, outcome.changes, outcome.residual, outcome.guess_missed
        return command

    def _move(self, command: Command) -> PlatformState:
        """Let the plant follow a command for a period, in one compiled call if it offers one."""
        i, record = self.done - self._first, self._record
        first, after = i * self.every, (i + 1) * self.every
        if self._follow is not None:
            moved, force = record.motion[first:after], record.force[first:after]
            follow_once(self._follow.method, command.accelerations(self.carriers), moved, force)
            return PlatformState.of_motion(moved[-1], force[-1] if np.isfinite(force[-1]).any() else None)
        for k in range(first, after):
            state = self.plant.step(command, self._dt)
            record.note(k, state)
        return state

    def _answer(self, request: int) -> None:
        """Let the algorithm meet, in Python, the request of its kernel at the decision that waits."""
        i, started = self.done - self._first, self._clock()
        cast(CompiledCueing, self.cueing).answer(request, self._wanted.at(i))
        self._record.step_time[i] += self._clock() - started

    def complete(self, progress: Callable[[float], None] = lambda _: None) -> Run:
        """Run to the end of the scenario and return the record; `progress` is as of `simulate`."""
        m = self.decisions
        with one_thread():  # small matrices: more threads only wait for each other
            while self.done < m:
                progress(self.done / m)
                self.advance(self.done + max(1, m // 100))
        self._keep.add(self._part(self._first))
        self._first = self.done  # nothing is left of the part
        progress(1.0)
        return self._keep.whole()

    def run(self, first: int = 0, *, settings: Mapping[str, Any] | None = None) -> Run:
        """Return the record from decision `first` to the last that was made, of a loop kept in memory.

        Parameters
        ----------
        settings : for the record, in place of those given.
        """
        found, begin = [], 0
        for part in self._memory.parts:
            if first < begin + part.decisions:
                found.append(part.part(max(0, first - begin), part.decisions))
            begin += part.decisions
        if self.done > self._first or not found:
            found.append(self._part(max(first, self._first)))
        run = joined(found)
        return run if settings is None else replace(run, settings=settings)

    def _part(self, first: int) -> Run:
        """Return the record of the current part from decision `first` to the last that was made."""
        begin, end = first - self._first, self.done - self._first
        n = self.done * self.every
        sample_time = np.arange(first * self.every + 1, n + 1, dtype=np.float64) * self._dt
        scenario, gain = self.scenario, np.repeat(self._wanted.gain[begin:end], self.every)[:, None]
        return Run(
            scenario=scenario.name,
            cueing=self.names[0],
            plant=self.names[1],
            platform=self.platform,
            dofs=self.dofs,
            soft=tuple(sorted(getattr(self.cueing, "soft", ()))),
            settings=self.settings,
            period=self.period,
            plant_period=self._dt,
            time=sample_time,
            reference_force=scenario.specific_force(sample_time - EDGE) * gain,
            reference_rate=scenario.angular_rate(sample_time - EDGE) * gain,
            command_time=np.arange(first, self.done, dtype=np.float64) * self.period,
            **self._record.series(begin, end, self.every),
            interventions=tuple(getattr(self.plant, "interventions", ())),
        )


def _carriers(cueing: Cueing, plant: Plant) -> int:
    """Return 2 if the plant is carried by a base that moves, else 1.

    Raises
    ------
    InputError : the algorithm moves a base that the plant does not have.
    """
    moved, there = (getattr(one, "carriers", 1) for one in (cueing, plant))
    if moved > there:
        raise InputError("the plant", "without a base", "on one, since the algorithm moves it")
    return int(there)


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
    keep: Keeper | None = None,
) -> Run:
    """Close the loop from the neutral pose at rest and record it.

    Parameters and errors are those of `ClosedLoop`; `progress` is called with the fraction done, about a
    hundred times.
    """
    loop = ClosedLoop(
        cueing,
        plant,
        scenario,
        platform=platform,
        dofs=dofs,
        names=names,
        settings=settings,
        plant_period=plant_period,
        preview=preview,
        clock=clock,
        keep=keep,
    )
    return loop.complete(progress)
