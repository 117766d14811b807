"""Faults of the device and of the people around it: rows 12, 13, 27, 28, 30, 34 to 36."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np

from otolith.live.core.ladder import Reaction
from otolith.live.devices.moog import FAULTS
from otolith.live.faults.case import Aftermath, Case
from otolith.live.messages import DeviceState, Rung, State, Word
from otolith.live.world import World


def _device(**faults: Any) -> Callable[[World], None]:
    def begin(world: World) -> None:
        for name, value in faults.items():
            setattr(world.device, name, value)

    return begin


def _fails(*names: str) -> Callable[[World], None]:
    return lambda world: world.device.fail(world.now_ns, *names)


def _says(*words: Word) -> Callable[[World], None]:
    return lambda world: world.say(*words)


def _arms(**faults: Any) -> Callable[[World], None]:
    """Return a script that changes the device and arms it."""

    def begin(world: World) -> None:
        _device(**faults)(world)
        world.say(Word.ARM)

    return begin


def _shell(reaction: Reaction) -> Callable[[World], None]:
    return lambda world: setattr(world, "reaction", reaction)


def _released(world: World) -> None:
    """Press the emergency stop, release it a second later, and rearm after another second."""
    world.device.fail(world.now_ns, "emergency stop")
    world.at(world.seconds + 1.0, lambda: setattr(world.device, "faults", ()))
    world.at(world.seconds + 2.0, lambda: world.say(Word.ARM, Word.ENGAGE))
    world.at(world.seconds + 3.0, lambda: world.say(Word.REARM))


def _falls(world: World) -> None:
    world.output.device = world.output.device.__class__.at(world.output.device.park, on_silence="falls")
    world.reaction = Reaction(Rung.FAULT, "anything that is R4")


def _sixth(value: float, axis: int) -> Any:
    vector = np.zeros(6)
    vector[axis] = value
    return vector


def _fault_named(name: str) -> Callable[[Aftermath], bool]:
    def holds(after: Aftermath) -> bool:
        return after.after(State.FAULT) <= 0.05 and name in after.reason(State.FAULT)

    return holds


def _parks(after: Aftermath) -> bool:
    """Return whether the platform was at its park pose before power went, and was reported there."""
    parking = [row for row in after.rows if row.device is DeviceState.PARKING]
    park = after.world.device.park
    near = bool(parking) and bool(np.all(np.abs(parking[0].measured - park) < 2e-3))
    return near and after.world.state is State.PARKED


def _holds_neutral(after: Aftermath) -> bool:
    ready = [row for row in after.rows if row.state is State.READY]
    still = all(not row.motion[1:].any() and row.sent for row in ready)
    return len(ready) > 1000 and still


def _stays_in_fault(after: Aftermath) -> bool:
    """Return whether the release did nothing, and the word led to idle, where nothing moves."""
    return (
        after.after(State.FAULT) <= 0.05 and 2.9 <= after.after(State.IDLE) <= 3.1 and len(after.changes) == 2
    )


MACHINE_CASES: Final = (
    Case(
        row="12a",
        fault="a pose is measured 20 mm beside the set-point",
        expected="R3 at 100 ms",
        begin=_device(offset=_sixth(0.02, 2)),
        holds=lambda after: 0.1 <= after.after(State.RETURNING) <= 0.15,
    ),
    Case(
        row="12b",
        fault="an axis is stuck",
        expected="R3",
        begin=_device(share=np.array([0.0, 1, 1, 1, 1, 1])),
        holds=lambda after: after.after(State.RETURNING) <= 2.0,
    ),
    Case(
        row="12c",
        fault="the measured pose is outside the reach",
        expected="R4 at the next reply",
        begin=_device(offset=_sixth(0.5, 0)),
        holds=lambda after: after.after(State.FAULT) <= 0.03,
        device_fails=True,
    ),
    *(
        Case(
            row=f"13.{bit:04x}",
            fault=f"the device reports: {name}",
            expected="R4, named",
            begin=_fails(name),
            holds=_fault_named(name),
            seconds=0.5,
            device_fails=True,
        )
        for bit, name in FAULTS.items()
    ),
    Case(
        row="13b",
        fault="the device refuses to engage",
        expected="idle after 20 s, with the device's own state",
        begin=_arms(refuses=True),
        holds=lambda after: (
            19.9 <= after.after(State.IDLE) <= 20.2
            and "it is idle" in after.reason(State.IDLE)
            and after.after(State.READY) == np.inf
        ),
        seconds=22.0,
        engaged=False,
    ),
    Case(
        row="13c",
        fault="the device takes 12 s to engage",
        expected="ready, a little later",
        begin=_arms(engages=12.0),
        holds=lambda after: 12.0 <= after.after(State.READY) <= 18.0,
        seconds=18.0,
        engaged=False,
    ),
    Case(
        row="13d",
        fault="replies are lost for 200 ms",
        expected="R3 at 100 ms",
        begin=lambda world: world.silence("feedback", 0.2),
        holds=lambda after: 0.08 <= after.after(State.RETURNING) <= 0.13,
    ),
    Case(
        row="13e",
        fault="the device shows a state that nobody knows",
        expected="R4",
        begin=_device(shown=DeviceState.UNKNOWN),
        holds=lambda after: after.after(State.FAULT) <= 0.05,
        device_fails=True,
    ),
    Case(
        row="28",
        fault="the line to the device breaks (EIO)",
        expected="R4, named",
        begin=_shell(Reaction(Rung.FAULT, "the line to the device: EIO")),
        holds=_fault_named("EIO"),
        device_fails=True,
    ),
    Case(
        row="30",
        fault="the operator says return",
        expected="neutral is held by set-points without speed, in every tick",
        begin=_says(Word.RETURN),
        holds=_holds_neutral,
        seconds=5.0,
    ),
    Case(
        row="34",
        fault="R4 on a device that falls without packets",
        expected="set-points go on, and come to rest",
        begin=_falls,
        holds=lambda after: after.rows[-1].sent and after.travelled < 1e-3,
    ),
    Case(
        row="35",
        fault="the operator says park",
        expected="neutral, the park pose, then the device's own parking; only then parked",
        begin=_says(Word.PARK),
        holds=_parks,
        seconds=12.0,
    ),
    Case(
        row="36",
        fault="the emergency stop is pressed, released, and words are said",
        expected="R4; neither release nor arm moves anything; rearm leads to idle",
        begin=_released,
        holds=_stays_in_fault,
        seconds=5.0,
        device_fails=True,
    ),
)
