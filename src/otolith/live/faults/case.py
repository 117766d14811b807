"""One row of the fault matrix: a fault as a script, what must follow, and what did."""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from otolith.live.audit import Violation, audit
from otolith.live.messages import State
from otolith.live.world import Row, World
from otolith.platforms import Platform

ENGAGED_S = 6.0  # [s] at which faults begin: the reference is faded in


@dataclass(frozen=True, slots=True)
class Aftermath:
    """What came after a fault."""

    world: World
    since: float  # [s] when the fault began

    @property
    def rows(self) -> list[Row]:
        """Return the trace from the fault on."""
        return [row for row in self.world.trace if 1e-9 * row.time_ns >= self.since - 1e-9]

    @property
    def changes(self) -> list[tuple[float, State, str]]:
        """Return the changes of state after the fault: time since it [s], state, reason."""
        events = self.world.output.session.events
        return [
            (1e-9 * event.time_ns - self.since, event.after, event.reason)
            for event in events
            if 1e-9 * event.time_ns >= self.since - 1e-9
        ]

    def after(self, state: State) -> float:
        """Return the time [s] from the fault to a state; infinite if it was not reached."""
        return next((seconds for seconds, found, _ in self.changes if found is state), np.inf)

    def reason(self, state: State) -> str:
        """Return why a state was entered; empty if it was not."""
        return next((reason for _, found, reason in self.changes if found is state), "")

    def stops_within(self, seconds: float, state: State) -> bool:
        """Return whether the set-points come to rest within a time [s] from the beginning of a state."""
        begin = self.since + self.after(state)
        speeds = [
            float(np.abs(row.motion[1]).max())
            for row in self.rows
            if begin <= 1e-9 * row.time_ns <= begin + seconds
        ]
        return bool(speeds) and min(speeds) <= 1e-3

    @property
    def unchanged(self) -> bool:
        """Return whether the session stayed as it was."""
        return not self.changes

    @property
    def travelled(self) -> float:
        """Return the largest speed [m/s, rad/s] of a set-point in the last half second."""
        end = self.world.seconds - 0.5
        return max(float(np.abs(row.motion[1]).max()) for row in self.rows if 1e-9 * row.time_ns >= end)

    def __str__(self) -> str:
        """Return the changes of state, and the reason of the first."""
        if self.unchanged:
            return f"{self.world.state} throughout"
        states = ", ".join(f"{state} after {seconds:.3f} s" for seconds, state, _ in self.changes)
        return f"{states} ({self.changes[0][2]})"


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A row of the matrix, or a part of one."""

    row: str  # number in the matrix, and a letter for each of several faults
    fault: str
    expected: str
    begin: Callable[[World], None]  # is called at the time of the fault
    holds: Callable[[Aftermath], bool]  # whether what is expected was seen
    seconds: float = 3.0  # from the fault to the judgement
    engaged: bool = True  # whether the fault meets a cued platform; otherwise one that is idle
    device_fails: bool = False  # the device is expected to end in a fault of its own


@dataclass(frozen=True, slots=True)
class Result:
    """What became of one case."""

    case: Case
    seen: str
    right: bool
    seconds: float  # of computing
    violations: tuple[Violation, ...]


def run_case(case: Case, prepared: World, platform: Platform) -> Result:
    """Run one case from a copy of a prepared world, and judge it."""
    started = clock.perf_counter()
    world = prepared.again()
    aftermath = Aftermath(world, world.seconds)
    case.begin(world)
    world.run(world.seconds + case.seconds)
    violations = tuple(audit(aftermath.rows, platform))
    right = case.holds(aftermath) and not violations
    if not case.device_fails:
        right = right and not world.device.faults
    seen = str(aftermath) if not violations else f"{aftermath}; {violations[0]}"
    if world.device.faults and not case.device_fails:
        seen += f"; the device failed: {', '.join(world.device.faults)}"
    return Result(case, seen, right, clock.perf_counter() - started, violations)
