"""Faults of the source and of its link: rows 1 to 7, 23 and 24."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from otolith.live.core.health import Count
from otolith.live.faults.case import Aftermath, Case
from otolith.live.messages import Flag, State
from otolith.live.world import SECOND, World

Values = dict[str, tuple[Any, ...]]
NAN = float("nan")


def _change(begin: Callable[[World], Callable[[Values], Values]], seconds: float) -> Callable[[World], None]:
    """Return a script that changes what the source sends, for a time [s]."""

    def script(world: World) -> None:
        world.source.change = begin(world)
        world.at(world.seconds + seconds, lambda: setattr(world.source, "change", None))

    return script


def _instead(seconds: float, **numbers: tuple[Any, ...]) -> Callable[[World], None]:
    """Return a script by which the source sends other numbers, for a time [s]."""
    named = {name.replace("_", " "): value for name, value in numbers.items()}
    return _change(lambda _: lambda values: {**values, **named}, seconds)


def _first(count: int, **numbers: tuple[Any, ...]) -> Callable[[World], None]:
    """Return a script by which the next packets have other numbers."""

    def begin(world: World) -> Callable[[Values], Values]:
        first = world.source.sequence

        def change(values: Values) -> Values:
            named = {name.replace("_", " "): value for name, value in numbers.items()}
            return {**values, **named} if values["sequence"][0] <= first + count else values

        return change

    return _change(begin, 1.0)


def _frozen() -> Callable[[World], Callable[[Values], Values]]:
    """Return a source whose numbers stay, while sequence and time go on."""

    def begin(_: World) -> Callable[[Values], Values]:
        kept: list[Values] = []

        def change(values: Values) -> Values:
            kept.append(values)
            return {**kept[0], "sequence": values["sequence"], "time": values["time"]}

        return change

    return begin


def _stands(world: World) -> Callable[[Values], Values]:
    """Return a source that brakes from 20 m/s with 8 m/s² and then stands."""
    begin = world.now_ns + world.source.clock_ns

    def change(values: Values) -> Values:
        speed = max(0.0, 20.0 - 8e-9 * (values["time"][0] - begin))
        force = (-8.0 if speed > 0.0 else 0.0, 0.0, 0.0)
        return {**values, "specific force": force, "velocity": (speed, 0.0, 0.0)}

    return change


def _link(**faults: float) -> Callable[[World], None]:
    def begin(world: World) -> None:
        for name, value in faults.items():
            setattr(world.links["telemetry"], name, value)

    return begin


def _corrupted(seconds: float) -> Callable[[World], None]:
    def begin(world: World) -> None:
        link = world.links["telemetry"]
        link.corruption = 1.0
        world.at(world.seconds + seconds, lambda: setattr(link, "corruption", 0.0))

    return begin


def _silent(seconds: float) -> Callable[[World], None]:
    return lambda world: world.silence("telemetry", seconds)


def _restart(sequence: int, clock_s: float) -> Callable[[World], None]:
    def begin(world: World) -> None:
        world.source.sequence += sequence
        world.source.clock_ns += round(clock_s * SECOND)

    return begin


def _flags(flags: Flag, seconds: float) -> Callable[[World], None]:
    def begin(world: World) -> None:
        world.source.flags = flags
        world.at(world.seconds + seconds, lambda: setattr(world.source, "flags", Flag.RUNNING))

    return begin


def _menu(world: World) -> None:
    world.controller.health.pauses_silently = True
    world.silence("telemetry", 2.0)


def _counted(after: Aftermath, *counts: Count) -> bool:
    return all(after.world.controller.health.counts[count] > 0 for count in counts)


def _blended_back(after: Aftermath, soonest: float) -> bool:
    """Return whether the platform was held at once and cued again, but not before a time [s]."""
    again = after.after(State.ENGAGED)
    return after.after(State.HOLDING) <= 0.15 and soonest <= again <= soonest + 0.3


def _warned(after: Aftermath) -> bool:
    world = after.world
    return bool(world.controller.health.look(world.now_ns).warning)


TELEMETRY_CASES: Final = (
    Case(
        row="1a",
        fault="3 of 10 packets corrupted or cut, for 2 s",
        expected="unchanged, counted",
        begin=_link(corruption=0.3),
        holds=lambda after: after.unchanged and _counted(after, Count.UNREADABLE),
        seconds=2.0,
    ),
    Case(
        row="1b",
        fault="a packet with NaN",
        expected="unchanged, counted",
        begin=_first(1, specific_force=(NAN, 0.0, 0.0)),
        holds=lambda after: after.unchanged and _counted(after, Count.UNREADABLE),
        seconds=1.0,
    ),
    Case(
        row="1c",
        fault="every packet corrupted for 150 ms",
        expected="as silence: R2 from 100 ms",
        begin=_corrupted(0.15),
        holds=lambda after: 0.08 <= after.after(State.HOLDING) <= 0.13,
        seconds=0.5,
    ),
    Case(
        row="2a",
        fault="silence of 20 ms",
        expected="engaged",
        begin=_silent(0.02),
        holds=lambda after: after.unchanged,
        seconds=0.5,
    ),
    Case(
        row="2b",
        fault="silence of 60 ms",
        expected="engaged",
        begin=_silent(0.06),
        holds=lambda after: after.unchanged,
        seconds=0.5,
    ),
    Case(
        row="2c",
        fault="silence of 150 ms",
        expected="R2 from 100 ms; cued again after 1 s of good telemetry",
        begin=_silent(0.15),
        holds=lambda after: (
            0.08 <= after.after(State.HOLDING) <= 0.13 and 1.1 <= after.after(State.ENGAGED) <= 1.3
        ),
    ),
    Case(
        row="2d",
        fault="silence of 1.2 s",
        expected="R2 from 100 ms, R3 at 1.0 s, at rest within 0.3 s more, then neutral",
        begin=_silent(1.2),
        holds=lambda after: (
            after.after(State.HOLDING) <= 0.13
            and 0.98 <= after.after(State.RETURNING) <= 1.05
            and after.stops_within(0.3, State.RETURNING)
            and after.world.state is State.READY
        ),
        seconds=6.0,
    ),
    Case(
        row="3a",
        fault="payload frozen for 0.7 s at 20 m/s",
        expected="R2 at 0.5 s",
        begin=_change(_frozen(), 0.7),
        holds=lambda after: 0.45 <= after.after(State.HOLDING) <= 0.56,
        seconds=1.0,
    ),
    Case(
        row="3b",
        fault="payload the same for 2 s, because the vehicle has stopped",
        expected="unchanged",
        begin=_change(_stands, 5.0),
        holds=lambda after: after.unchanged,
        seconds=4.5,
    ),
    Case(
        row="4",
        fault="20 % of packets twice, 20 % late",
        expected="unchanged, warned after 1 s",
        begin=_link(duplication=0.2, reordering=0.2),
        holds=lambda after: after.unchanged and _counted(after, Count.OLD, Count.TWICE) and _warned(after),
        seconds=2.0,
    ),
    Case(
        row="5a",
        fault="the sender restarts: new sequence and clock",
        expected="R2 at once, cued again after 1 s of good telemetry",
        begin=_restart(-300, -20.0),
        holds=lambda after: _blended_back(after, 1.0),
    ),
    Case(
        row="5b",
        fault="the sender's clock goes back by 3 s",
        expected="as a restart",
        begin=_restart(0, -3.0),
        holds=lambda after: _blended_back(after, 1.0),
    ),
    Case(
        row="5c",
        fault="the sender's clock goes on by 3 s",
        expected="as a restart",
        begin=_restart(0, 3.0),
        holds=lambda after: _blended_back(after, 1.0),
    ),
    Case(
        row="6a",
        fault="one spike of 45 m/s² across",
        expected="dropped, unchanged",
        begin=_first(1, specific_force=(0.0, 45.0, 0.0)),
        holds=lambda after: after.unchanged and _counted(after, Count.SPIKE),
        seconds=1.0,
    ),
    Case(
        row="6b",
        fault="four spikes of 1000 m/s², sound by checksum",
        expected="R2, cued again after 1 s or more",
        begin=_first(4, specific_force=(1000.0, 0.0, 0.0)),
        holds=lambda after: _blended_back(after, 1.0),
    ),
    Case(
        row="6c",
        fault="a crash: 20 m/s² for 200 ms",
        expected="clipped, unchanged",
        begin=_instead(0.2, specific_force=(-20.0, 0.0, 0.0)),
        holds=lambda after: after.unchanged,
        seconds=1.0,
    ),
    Case(
        row="7a",
        fault="the pause flag for 2 s",
        expected="R2 and held at neutral, cued again on return",
        begin=_flags(Flag.PAUSED | Flag.RUNNING, 2.0),
        holds=lambda after: after.after(State.HOLDING) <= 0.05 and 2.9 <= after.after(State.ENGAGED) <= 3.2,
        seconds=4.0,
    ),
    Case(
        row="7b",
        fault="a replay, flagged",
        expected="R2, never cued",
        begin=_flags(Flag.REPLAY | Flag.RUNNING, 60.0),
        holds=lambda after: after.after(State.HOLDING) <= 0.05 and after.world.state is State.HOLDING,
        seconds=4.0,
    ),
    Case(
        row="7c",
        fault="the menu of a source that falls silent in it, 2 s",
        expected="R2 and held, cued again on return, no R3",
        begin=_menu,
        holds=lambda after: (
            after.after(State.RETURNING) == np.inf and 2.9 <= after.after(State.ENGAGED) <= 3.3
        ),
        seconds=4.0,
    ),
    Case(
        row="23",
        fault="force without a change of speed: 15 m/s² at a speed that stays",
        expected="R2 within 1 s",
        begin=_instead(2.0, specific_force=(15.0, 0.0, 0.0)),
        holds=lambda after: after.after(State.HOLDING) <= 1.0,
        seconds=1.5,
    ),
)
