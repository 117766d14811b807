"""The Commander of a live session: its processes beside the session's own, and the words of its pages."""

import contextlib
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from otolith.commander.feed import run_feed
from otolith.commander.keeper import GivenUp, Keeper, Setup, memory, run_server
from otolith.commander.orders import Inbox, Note
from otolith.commander.session import CHANGE
from otolith.core.errors import OtolithError
from otolith.live.messages import State, Word
from otolith.live.session import Session
from otolith.live.shell.memory import Channel

EVENTS: Final = 100  # that are kept
PARAMETER: Final = "parameter: "  # begins a sentence about a parameter that was changed
Change = Callable[[Mapping[str, Any]], str]  # asks for other parameters, and says so; refuses with an error


class Pages:
    """The pages that watch a session, as its supervisor knows them.

    Parameters
    ----------
    said : where the sentences are stated that pages show as events.
    change : as `otolith.live.shell.supervise.Live.change`.
    """

    def __init__(self, said: Note, inbox: Inbox, change: Change) -> None:
        self.began_ns = time.monotonic_ns()  # time 0 of the pages
        self.keeper: Keeper | None = None
        self._said, self._inbox, self._change = said, inbox, change
        self._events: list[dict[str, Any]] = []

    def tell(self, sentence: str) -> None:
        """Show a sentence as an event."""
        event = {
            "number": self._events[-1]["number"] + 1 if self._events else 1,
            "time": round(1e-9 * (time.monotonic_ns() - self.began_ns), 3),
            "level": "fault"
            if sentence.startswith(State.FAULT)
            else "parameter"
            if sentence.startswith(PARAMETER)
            else "info",
            "text": sentence.removeprefix(PARAMETER)[:300],
        }
        self._events = [*self._events[1 - EVENTS :], event]
        self._said.state({"events": self._events})

    def words(self, tell: Callable[[str], None]) -> tuple[Word, ...]:
        """Return the words that pages have said since the last call; pass on parameters that they changed.

        What has died is started anew. Where that is in vain the session goes on without pages, which is told.
        """
        try:
            if self.keeper is not None:
                self.keeper.look()
        except GivenUp as error:
            self.keeper = None
            tell(f"{error}: the session goes on without a page")
        orders = self._inbox.new()
        for order in orders:
            if order.word == CHANGE:
                tell(self._altered(order.values))
        return tuple(Word(order.word) for order in orders if order.word != CHANGE)

    def _altered(self, values: Mapping[str, Any]) -> str:
        """Ask for other parameters, and return what became of it."""
        try:
            return PARAMETER + self._change(values)
        except OtolithError as error:
            return str(error)


@contextlib.contextmanager
def watched(setup: Setup, session: Session, names: dict[str, str], change: Change) -> Iterator[Pages]:
    """Serve pages that watch a session, whose shared memory has these names; `change` is as of `Pages`."""
    targets: dict[str, Callable[..., None]] = {"server": run_server, "feed": run_feed}
    with memory(setup), Channel(setup.name("said")) as said, Channel(setup.name("orders")) as orders:
        pages = Pages(Note(said), Inbox(orders, 0), change)
        more = {"feed": (session, names, pages.began_ns)}
        with Keeper(setup, pages.tell, targets, more) as pages.keeper:
            yield pages


@contextlib.contextmanager
def own_folder() -> Iterator[Path]:
    """Yield an empty folder: pages of a live session keep nothing."""
    with tempfile.TemporaryDirectory(prefix="otolith-") as folder:
        yield Path(folder)
