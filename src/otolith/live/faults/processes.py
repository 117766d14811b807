"""Faults of processes, and of what was not tested: rows 10, 11, 25, 33, 38.

With real processes: tests/live/shell.
"""

from collections.abc import Callable
from typing import Final

from otolith.live.compilations import compiled
from otolith.live.faults.case import Aftermath, Case
from otolith.live.messages import DeviceState, State, Word
from otolith.live.world import World


def stopped(*cores: str, seconds: float | None = None) -> Callable[[World], None]:
    """Return a script by which cores stop, for a time [s] or for good."""

    def begin(world: World) -> None:
        for core in cores:
            world.stop(core, seconds)

    return begin


def _one_after_the_other(first: str, second: str) -> Callable[[World], None]:
    def begin(world: World) -> None:
        world.stop(first)
        world.at(world.seconds + 0.005, lambda: world.stop(second))

    return begin


def _again(world: World) -> None:
    """Let the output hang; the operator starts the session anew, and the device has to be reset first."""
    world.stop("output", 0.3)
    world.at(world.seconds + 1.0, world.restart)


def returns(after: Aftermath, soonest: float, latest: float) -> bool:
    """Return whether R3 came within these times [s], and ended at neutral."""
    return soonest <= after.after(State.RETURNING) <= latest and after.world.state is State.READY


def _latched(after: Aftermath) -> bool:
    """Return whether the fault is latched within 20 ms, nothing was sent later, and the device acted."""
    world = after.world
    sent_last = 1e-9 * after.rows[-1].time_ns - after.since if after.rows else 0.0
    ended = sent_last <= after.after(State.FAULT)
    return after.after(State.FAULT) <= 0.02 and ended and world.device.faults == ("watchdog",)


def _starts_idle(after: Aftermath) -> bool:
    """Return whether the new session waits, the device is reset and parks, and nothing was commanded."""
    rows = [row for row in after.rows if 1e-9 * row.time_ns > after.since + 1.5]
    quiet = {row.state for row in rows} == {State.IDLE} and not any(row.moves for row in rows)
    return quiet and after.world.device.state is DeviceState.IDLE


def _forbidden(reason: str) -> Callable[[World], None]:
    """Return a script by which an operator wants to arm what must not be armed."""

    def begin(world: World) -> None:
        world.output.forbids = reason
        world.say(Word.ARM)
        world.at(world.seconds + 0.5, lambda: world.say(Word.ENGAGE, Word.REARM, Word.ARM))

    return begin


def _refuses(after: Aftermath) -> bool:
    """Return whether the platform stayed idle, and was told why."""
    named = after.world.output.forbids in after.reason(State.IDLE)
    return named and after.world.state is State.IDLE and not any(row.moves for row in after.rows)


class _Compilations:
    """A session from arming to the end, in which nothing may wait for the compiler."""

    def __init__(self) -> None:
        self._before = 0

    def begin(self, world: World) -> None:
        """Count what is compiled, arm, engage, and meet faults that are answered by other code."""
        self._before = compiled()
        world.say(Word.ARM)
        world.at(world.seconds + 5.0, lambda: world.say(Word.ENGAGE))
        world.at(world.seconds + 8.0, lambda: world.silence("telemetry", 0.3))
        world.at(world.seconds + 11.0, lambda: world.stop("controller", 0.1))
        world.at(world.seconds + 13.0, lambda: world.say(Word.PARK))

    def holds(self, after: Aftermath) -> bool:
        """Return whether the session went all the way, and nothing was compiled meanwhile."""
        went = {state for _, state, _ in after.changes}
        all_states = {State.ENGAGED, State.HOLDING, State.RETURNING, State.PARKED}
        return all_states <= went and compiled() == self._before


_COMPILATIONS: Final = _Compilations()

PROCESS_CASES: Final = (
    Case(
        row="25",
        fault="the device's settings are new, or have changed since its axes were tested",
        expected="arming is refused with the reason",
        begin=_forbidden("the axes of moog at 127.0.0.1:9910 are not tested"),
        holds=_refuses,
        engaged=False,
    ),
    Case(
        row="33",
        fault="this host was not tested, or woke too late",
        expected="arming is refused with the reason",
        begin=_forbidden("99.9 % of wake-ups were up to 7 ms late"),
        holds=_refuses,
        engaged=False,
    ),
    Case(
        row="38",
        fault="something is compiled while armed",
        expected="nothing is, from arm to parked, through silence and a hung controller",
        begin=_COMPILATIONS.begin,
        holds=_COMPILATIONS.holds,
        seconds=20.0,
        engaged=False,
    ),
    Case(
        row="10",
        fault="the controller dies",
        expected="no sign of life for 2 periods: the output brakes and returns to neutral",
        begin=stopped("controller"),
        holds=lambda after: returns(after, 0.01, 0.032) and after.stops_within(0.3, State.RETURNING),
        seconds=4.0,
    ),
    *(
        Case(
            row=f"11{letter}",
            fault=fault,
            expected="a fault is latched within 20 ms; no more packets: the device's own watchdog acts",
            begin=begin,
            holds=_latched,
            device_fails=True,
        )
        for letter, fault, begin in (
            ("a", "the output dies", stopped("output")),
            ("b", "the output hangs for 0.3 s", stopped("output", seconds=0.3)),
            ("c", "the output dies, 5 ms later the controller", _one_after_the_other("output", "controller")),
        )
    ),
    Case(
        row="11d",
        fault="the controller dies, 5 ms later the output",
        expected="as 11a",
        begin=_one_after_the_other("controller", "output"),
        holds=lambda after: after.after(State.FAULT) <= 0.025 and after.world.device.faults == ("watchdog",),
        device_fails=True,
    ),
    Case(
        row="11e",
        fault="the output hangs, and the session is started anew",
        expected="it waits in idle; the device is reset, and parks",
        begin=_again,
        holds=_starts_idle,
        seconds=8.0,
    ),
)
