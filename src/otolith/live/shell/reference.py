"""A loop that does nothing, in a process of its own: what a machine can do at best, beside what we do."""

import multiprocessing
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Self

from otolith.live.core.times import Times
from otolith.live.shell.clock import Ticks
from otolith.live.shell.processes import OUTPUT, TICK_NS, asked_to_end, begin_child
from otolith.live.shell.rights import take_rights


@dataclass(frozen=True, slots=True)
class Bare:
    """How late the bare loop woke, and the ticks that it missed."""

    late: Times
    skipped: int


class BareLoop:
    """Runs from the beginning of a `with` block to its end; `found` is then what it noted.

    It wakes by `clock_nanosleep` at absolute times, as the output does, with the same rights.
    """

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._heard, said = context.Pipe(duplex=False)
        self._process = context.Process(target=_run, args=(said,), daemon=True)
        self.found = Bare(Times(), 0)

    def __enter__(self) -> Self:
        self._process.start()
        self._heard.recv()  # it has begun
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self.found = self._heard.recv()
        self._process.join()


def _run(said: Connection) -> None:
    begin_child()
    asked = asked_to_end()
    take_rights(OUTPUT)
    ticks = Ticks(TICK_NS)
    said.send(None)
    for _ in ticks:
        if asked:
            said.send(Bare(ticks.late, ticks.skipped))
            return
