"""Faults of decisions, of processes, and of the memory between them: rows 8, 9, 18, 22, 29, 32."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.interfaces import Command, Cueing, Outcome, PlatformState, Reference, Status
from otolith.live.faults.case import Aftermath, Case
from otolith.live.faults.processes import returns, stopped
from otolith.live.messages import Plan, State, Word
from otolith.live.world import MS, World

Spoil = Callable[[Command], Command]


class Failing:
    """An algorithm whose next answers are spoiled."""

    def __init__(self, cueing: Cueing, spoil: Spoil, count: int) -> None:
        self._cueing, self._spoil, self.left = cueing, spoil, count

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self._cueing.period

    def reset(self, state: PlatformState) -> None:
        """Start from `state`."""
        self._cueing.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide, and spoil the answer."""
        command = self._cueing.step(state, reference)
        if self.left <= 0:
            return command
        self.left -= 1
        return self._spoil(command)


def _infeasible(command: Command) -> Command:
    return replace(command, outcome=Outcome(status=Status.FALLBACK, solver="infeasible"))


def _untrusted(command: Command) -> Command:
    return replace(command, outcome=replace(command.outcome, residual=2e-3))


def _not_finite(command: Command) -> Command:
    return replace(command, acceleration=np.full(6, np.nan))


def _too_strong(command: Command) -> Command:
    return replace(command, acceleration=np.full(6, 50.0))


def _raises(_: Command) -> Command:
    raise ZeroDivisionError("from within the algorithm")


def _spoiled(spoil: Spoil, count: int) -> Callable[[World], None]:
    def begin(world: World) -> None:
        world.controller.cueing = Failing(world.controller.cueing, spoil, count)

    return begin


def _slow(count: int, cost_ns: int = 15 * MS) -> Callable[[World], None]:
    def begin(world: World) -> None:
        world.costs_ns = [cost_ns] * count

    return begin


def _memory(change: Callable[[Plan], Plan], seconds: float) -> Callable[[World], None]:
    def begin(world: World) -> None:
        world.on_plan = change
        world.at(world.seconds + seconds, lambda: setattr(world, "on_plan", None))

    return begin


def _stale(world: World) -> None:
    """Return, engage again, and let the memory give plans of the engagement before, full of motion."""
    world.say(Word.RETURN)

    def again() -> None:
        world.on_plan = lambda plan: replace(
            plan, generation=plan.generation - 1, stages=np.tile([2.0, 0, 0, 0, 0, 0], (50, 1))
        )
        world.say(Word.ENGAGE)

    world.at(world.seconds + 4.0, again)


def _goes_on(after: Aftermath) -> bool:
    """Return whether the session is unchanged and a plan was followed in every tick but the first few."""
    followed = [row.follows >= 0 for row in after.rows]
    return after.unchanged and sum(followed) >= 0.95 * len(followed)


def _at_rest_in_engaged(after: Aftermath) -> bool:
    rows = [
        row for row in after.rows if row.state is State.ENGAGED and 1e-9 * row.time_ns > after.since + 3.9
    ]
    return bool(rows) and max(float(np.abs(row.motion[0]).max()) for row in rows) < 1e-6


_SPOILS: Final = {
    "no solution": _infeasible,
    "a residual of 2e-3": _untrusted,
    "a solution of NaN": _not_finite,
    "a command of 50 m/s²": _too_strong,
    "an exception": _raises,
}

DECISION_CASES: Final = (
    *(
        Case(
            row=f"8{letter}",
            fault=f"{words}, once",
            expected="a fallback in the same tick, unchanged",
            begin=_spoiled(spoil, 1),
            holds=_goes_on,
            seconds=1.0,
        )
        for letter, (words, spoil) in zip("abcde", _SPOILS.items(), strict=True)
    ),
    Case(
        row="8f",
        fault="no solution, without end",
        expected="R3 after 10 in a row",
        begin=_spoiled(_infeasible, 10**6),
        holds=lambda after: returns(after, 0.08, 0.13),
        seconds=4.0,
    ),
    Case(
        row="8g",
        fault="exceptions without end",
        expected="R3 after 10 in a row",
        begin=_spoiled(_raises, 10**6),
        holds=lambda after: returns(after, 0.08, 0.13),
        seconds=4.0,
    ),
    Case(
        row="9a",
        fault="one step takes 1.5 periods",
        expected="the plan before goes on, unchanged",
        begin=_slow(1),
        holds=_goes_on,
        seconds=1.0,
    ),
    Case(
        row="9b",
        fault="3 steps in a row take 1.5 periods",
        expected="fallbacks, unchanged",
        begin=_slow(3),
        holds=_goes_on,
        seconds=1.0,
    ),
    Case(
        row="9c",
        fault="one step takes 3.5 periods",
        expected="it counts as hung: R3 after 2 periods",
        begin=_slow(1, 35 * MS),
        holds=lambda after: returns(after, 0.02, 0.045),
        seconds=4.0,
    ),
    Case(
        row="9d",
        fault="every step takes 1.5 periods",
        expected="R3 after 10 in a row",
        begin=_slow(10**4),
        holds=lambda after: returns(after, 0.13, 0.2),
        seconds=4.0,
    ),
    Case(
        row="18a",
        fault="the machine is suspended for 30 s",
        expected="not engaged: R4, for the device has parked itself meanwhile",
        begin=stopped("output", "controller", "supervisor", seconds=30.0),
        holds=lambda after: after.world.state is State.FAULT,
        seconds=32.0,
        device_fails=True,
    ),
    Case(
        row="18b",
        fault="the controller alone is suspended for 5 s",
        expected="R3 after 2 periods without a sign of life; not engaged again by itself",
        begin=stopped("controller", seconds=5.0),
        holds=lambda after: returns(after, 0.01, 0.032),
        seconds=8.0,
    ),
    Case(
        row="22a",
        fault="the counter in the memory goes back for 15 ms",
        expected="the last good plan goes on",
        begin=_memory(lambda plan: replace(plan, sequence=3), 0.015),
        holds=_goes_on,
        seconds=1.0,
    ),
    Case(
        row="29",
        fault="engaged again while the memory holds plans of the time before",
        expected="the old plans are not followed; the platform stays at rest",
        begin=_stale,
        holds=_at_rest_in_engaged,
        seconds=6.0,
    ),
    Case(
        row="32",
        fault="every tick of the output is 7 ms late, for 1 s",
        expected="ticks are skipped, the motion goes on",
        begin=lambda world: world.delay("output", 0.007, 1.0),
        holds=lambda after: after.unchanged,
        seconds=2.0,
    ),
)
