"""The Commander of a live session: its processes beside the session's own, and the words of its pages."""

import contextlib
import tempfile
import time
from collections.abc import Callable, Iterator
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from otolith.commander.feed import run_feed
from otolith.commander.keeper import GivenUp, Keeper, Setup, run_server
from otolith.commander.orders import Inbox
from otolith.live.messages import Word
from otolith.live.session import Session
from otolith.live.shell.memory import Channel


class Pages:
    """The pages that watch a session, as its supervisor knows them."""

    def __init__(self, keeper: Keeper, inbox: Inbox, said: Any) -> None:
        self._keeper: Keeper | None = keeper
        self._inbox, self._said = inbox, said

    def tell(self, sentence: str) -> None:
        """Show a sentence as an event."""
        self._said.put((time.monotonic_ns(), [sentence]))

    def words(self, tell: Callable[[str], None]) -> tuple[Word, ...]:
        """Return the words that pages have said since the last call; start anew what has died.

        Where that is in vain the session goes on without pages, which is told.
        """
        try:
            if self._keeper is not None:
                self._keeper.look()
        except GivenUp as error:
            self._keeper = None
            tell(f"{error}: the session goes on without a page")
        return tuple(Word(order.word) for order in self._inbox.new())


@contextlib.contextmanager
def watched(setup: Setup, session: Session, names: dict[str, str]) -> Iterator[Pages]:
    """Serve pages that watch a session, whose shared memory has these names."""
    said: Any = get_context("spawn").Queue()
    targets: dict[str, Callable[..., None]] = {"server": run_server, "feed": run_feed}
    more = {"feed": (session, names, said, time.monotonic_ns())}

    def died(sentence: str) -> None:
        said.put((time.monotonic_ns(), [sentence]))

    with Keeper(setup, died, targets, more) as keeper, Channel(setup.name("orders")) as channel:
        yield Pages(keeper, Inbox(channel, 0), said)


@contextlib.contextmanager
def own_folder() -> Iterator[Path]:
    """Yield an empty folder: pages of a live session keep nothing."""
    with tempfile.TemporaryDirectory(prefix="otolith-") as folder:
        yield Path(folder)
