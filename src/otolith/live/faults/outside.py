"""Faults of what a session shares with others: rows 14, 17, 22, 24, 26, 27, 31, 37.

Locks, shared memory and ports are the real ones of this machine, for they are not of the virtual world.
"""

import os
from collections.abc import Callable
from typing import Final

import numpy as np

from otolith.core.errors import OtolithError
from otolith.core.rotation import place_of
from otolith.live.devices.template import Axis, Template
from otolith.live.faults.case import Aftermath, Case
from otolith.live.faults.telemetry import Values
from otolith.live.messages import State, Word
from otolith.live.shell.datagrams import LOCAL, PortInUse, opened
from otolith.live.shell.memory import VERSION_AT, Channel, WrongMemory
from otolith.live.shell.supervise import Occupied, lock_of, only_session
from otolith.live.wire.axes import AxisMap
from otolith.live.world import World

Try = Callable[[], str]  # what was said; empty if nothing was


class _Tried:
    """A case about something beside the world, which is to go on unchanged meanwhile."""

    def __init__(self, attempt: Try, *words: str) -> None:
        self._attempt, self._words, self._said = attempt, words, ""

    def begin(self, _: World) -> None:
        """Try it."""
        self._said = self._attempt()

    def holds(self, after: Aftermath) -> bool:
        """Return whether it was answered in these words, and the session stayed as it was."""
        return after.unchanged and all(word in self._said for word in self._words)


def _said_by(kind: type[OtolithError], action: Callable[[], object]) -> str:
    try:
        action()
    except kind as error:
        return str(error)
    return ""


def _second_session() -> str:
    """Take the lock of a device that is taken."""
    device = (LOCAL, os.getpid())  # a port, or beyond all ports: nothing is opened
    with only_session(device):
        return _said_by(Occupied, lambda: only_session(device).__enter__())


def _stale_lock() -> str:
    """Find the lock of a process that has died."""
    told: list[str] = []
    device = (LOCAL, os.getpid())
    lock_of(device).write_text("999999999")
    with only_session(device, told.append):
        return " ".join(told)


def _other_layout() -> str:
    name = f"otolith-layout-{os.getpid()}"
    with Channel(name, create=True) as channel:
        channel.buffer[VERSION_AT] ^= 0xFF
        return _said_by(WrongMemory, lambda: Channel(name))


def _torn() -> str:
    """Let a message be written over while it is read: the reader keeps what it had."""
    name = f"otolith-torn-{os.getpid()}"
    with Channel(name, create=True) as writer, _Overtaken(name) as reader:
        writer.write(b"first")
        first = reader.read()
        writer.write(b"second")
        reader.overtakes = writer
        torn, reader.overtakes = reader.read(), None
        return f"first {first!r}, torn {torn!r}, then {reader.read()!r}"


class _Overtaken(Channel):
    """A reader during whose copying four more messages come."""

    overtakes: Channel | None = None

    @property
    def published(self) -> int:
        """Return how many messages there are now, and let more come."""
        count = super().published
        if self.overtakes is not None:
            for _ in range(4):
                self.overtakes.write(b"later")
        return count


def _taken_port() -> str:
    with opened(0) as holder:
        return _said_by(PortInUse, lambda: opened(int(holder.getsockname()[1])).close())


def _every_code() -> str:
    """Encode every code of a mirrored 16-bit axis around its middle, and compare with what was meant."""
    axis = Axis(follows="heave", low=0.2, high=-0.2)
    template = Template(name="desk", frame="<Axis1a>", axes=(axis,), bits=16, on_silence="holds")
    wrong = 0
    for code in range(1 << 16):
        value = axis.value(code, 16)
        wrong += template.read(template.packed((axis.code(value, 16),))) != (code,)
    return f"{wrong} wrong"


def _another_token(world: World) -> None:
    """Let the device follow another session from now on."""
    world.device.token = 77


def _loop(world: World) -> None:
    """Let the vehicle drive a loop in 3 s, its forces in world axes: twice through 90 degrees of pitch."""
    axes = AxisMap(source="generic", force=("1", "2", "3"), frame="world")
    world.controller.wanted = axes.wanted
    begin = world.now_ns + world.source.clock_ns

    def change(values: Values) -> Values:
        angle = 2.0 * np.pi * 1e-9 * (values["time"][0] - begin) / 3.0
        place = np.empty(7)
        place_of(np.array([0.0, 0.0, 0.0, 0.0, -min(angle, 2.0 * np.pi), 0.0]), place)
        turned = _rotated(place[3:], np.array(values["specific force"]))
        return {**values, "attitude": tuple(place[3:]), "specific force": tuple(turned)}

    world.source.change = change


def _rotated(attitude: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return a vector turned by a unit quaternion (w x y z): v + 2 q × (q × v + w v)."""
    w, q = attitude[0], attitude[1:]
    turned: np.ndarray = vector + 2.0 * np.cross(q, np.cross(q, vector) + w * vector)
    return turned


def _flood(world: World) -> None:
    """Let a page ask for something 200 times per tick."""

    def again() -> None:
        world.say(*[Word.ENGAGE, Word.ARM] * 100)
        world.at(world.seconds + 0.002, again)

    again()


def _ended(after: Aftermath) -> bool:
    """Return whether the platform returned to neutral, then parked, and said so."""
    order = [state for _, state, _ in after.changes]
    return order == [State.RETURNING, State.PARKING, State.PARKED]


def _engages_late(world: World) -> None:
    world.device.engages = 25.0
    world.say(Word.ARM)


def _case(row: str, fault: str, expected: str, tried: _Tried) -> Case:
    return Case(row=row, fault=fault, expected=expected, begin=tried.begin, holds=tried.holds, seconds=0.5)


OUTSIDE_CASES: Final = (
    _case(
        "14a",
        "a second session on the same device",
        "refused by the number of the first, which goes on",
        _Tried(_second_session, f"is driven by process {os.getpid()} already"),
    ),
    _case(
        "14b",
        "the lock of a process that has died",
        "taken over with a notice",
        _Tried(_stale_lock, "taken over from process 999999999, which has died"),
    ),
    Case(
        row="14c",
        fault="the device follows a session with another token",
        expected="R4, named",
        begin=_another_token,
        holds=lambda after: (
            after.after(State.FAULT) <= 0.05 and "another session" in after.reason(State.FAULT)
        ),
        seconds=0.5,
        device_fails=True,
    ),
    Case(
        row="17",
        fault="SIGTERM, Ctrl-C, a closed terminal, or a supervisor that died",
        expected="R3, then park, then the end",
        begin=lambda world: world.say(Word.PARK),
        holds=_ended,
        seconds=12.0,
    ),
    _case(
        "22b",
        "a message is written over while it is read",
        "the message before is kept",
        _Tried(_torn, "first b'first', torn None, then b'later'"),
    ),
    _case(
        "22c",
        "shared memory of another layout",
        "refused",
        _Tried(_other_layout, "has layout"),
    ),
    Case(
        row="24",
        fault="a loop: the attitude goes through 90 degrees of pitch twice",
        expected="unchanged, no jump",
        begin=_loop,
        holds=lambda after: after.unchanged and max(row.follows for row in after.rows) > 0,
        seconds=3.5,
    ),
    _case(
        "26",
        "every code of an axis is encoded, on both sides of its middle",
        "each comes back as it was",
        _Tried(_every_code, "0 wrong"),
    ),
    Case(
        row="27",
        fault="the device takes 25 s to engage",
        expected="idle after 20 s, with the device's own state; then it is parked",
        begin=_engages_late,
        holds=lambda after: (
            19.9 <= after.after(State.IDLE) <= 20.2 and "it is standby" in after.reason(State.IDLE)
        ),
        seconds=30.0,
        engaged=False,
    ),
    Case(
        row="31",
        fault="a page asks for something 200 times in every tick",
        expected="unchanged: what it says is one word in the memory, and no request runs in the loop",
        begin=_flood,
        holds=lambda after: after.unchanged,
        seconds=1.0,
    ),
    _case(
        "37",
        "another program holds the telemetry's port",
        "refused by the name of its holder",
        _Tried(_taken_port, f"(process {os.getpid()})", "--forward"),
    ),
)
