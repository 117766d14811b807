"""The errand that learns the axes of a game while it is driven."""

import threading
import time
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

from otolith.commander.errands import Talk
from otolith.commander.rig import channels_of
from otolith.commander.session import MAPS
from otolith.core.disk import write_text
from otolith.core.errors import InputError
from otolith.live.messages import Telemetry
from otolith.live.shell.datagrams import opened, receive
from otolith.live.wire.formats import OtherPacket, WireError
from otolith.live.wire.learned import NOTHING, Learned, learn, shown
from otolith.live.wire.minute import NotLearned, minute_of
from otolith.live.wire.source import Source
from otolith.live.wire.sources import source_named

EVERY: Final = 0.5  # [s] between two judgements of what came so far
LOOK: Final = 0.05  # [s] between looks for orders
LONGEST: Final = 600.0  # [s] after which listening ends
MOST: Final = 200_000  # packets that are kept
SLICE: Final = 0.2  # [s] of receiving between two looks at whether to go on


class Ear:
    """Receives packets in a thread of its own, so that their times are those of their arrival."""

    def __init__(self, source: Source, listen: str) -> None:
        found = urlsplit(f"//{listen}")
        self._source, self._over = source, threading.Event()
        self.samples: list[tuple[float, Telemetry]] = []
        self.packets, self.refused, self.why = 0, 0, ""
        self._line = opened(found.port or 0, host=found.hostname or "")
        self.port = int(self._line.getsockname()[1])
        self._thread = threading.Thread(target=self._listen, daemon=True)

    def __enter__(self) -> "Ear":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        self._line.close()

    def _listen(self) -> None:
        while not self._over.is_set() and self.packets < MOST:
            receive(self._line, self._take, seconds=SLICE)

    def _take(self, packet: bytes, now_ns: int) -> None:
        self.packets += 1
        try:
            self.samples.append((1e-9 * now_ns, self._source.parse(packet)))
        except OtherPacket:
            return
        except WireError as error:
            self.refused, self.why = self.refused + 1, str(error)


def learn_axes(folder: Path, talk: Talk, values: Mapping[str, Any]) -> str:
    """Listen until somebody saves what was learned; return where it is.

    Parameters
    ----------
    folder : the Commander's. values : `source` and `listen` as a session states them, but a file of the
        game's by its plain name.

    Raises
    ------
    Ended : it was cancelled. InputError, PortInUse : the source or its port is refused, or nothing was saved
        within `LONGEST`.
    """
    source = source_named(values["source"], partial(channels_of, folder))
    begin, judged = time.monotonic(), 0.0
    learned: Learned | None = None
    with Ear(source, values["listen"]) as ear:
        talk.show(parts=[one._asdict() for one in NOTHING], port=ear.port, packets=0, learned=[])
        while time.monotonic() - begin < LONGEST and ear.packets < MOST:
            for order in talk.heard():
                if order.word == "save" and learned is not None:
                    return _saved(folder, str(order.values["name"]), learned, talk)
            if time.monotonic() - judged > EVERY:
                learned = _judged(ear, source.name, talk)
                judged = time.monotonic()
            time.sleep(LOOK)
    raise InputError("time of listening", f"{time.monotonic() - begin:.0f} s", f"at most {LONGEST:.0f} s")


def _judged(ear: Ear, name: str, talk: Talk) -> Learned | None:
    """Show what each part of the experiment has shown so far; return what was learned, if it was."""
    parts, learned, missing = NOTHING, None, "nothing has arrived yet: does the game send to this port?"
    samples = ear.samples[:]
    if ear.packets and not samples:
        missing = f"packets arrive, but none of {name}: {ear.why}"
    elif samples:
        try:
            minute = minute_of(name, samples)
            parts = shown(minute)
            learned = learn(minute)
            missing = ""
        except NotLearned as error:
            missing = str(error)
    found = [] if learned is None else [*learned.sentences(), *learned.notes]
    talk.show(
        parts=[one._asdict() for one in parts],
        packets=ear.packets,
        refused=ear.refused,
        missing=missing,
        learned=found,
    )
    return learned


def _saved(folder: Path, name: str, learned: Learned, talk: Talk) -> str:
    place = folder / MAPS / name
    write_text(place, learned.axes.to_toml())
    talk.show(map=name)
    return f"axis map {name} is saved"
