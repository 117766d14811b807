"""The rig's process: errands that take a while, listen to a game or move a platform, one at a time.

It is a process of its own beside server and simulation, with orders and a note of its own in shared memory.
So the server never waits for a game or a machine, and whatever ends this process, the session that it had
begun brakes, returns and parks by itself.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from otolith.commander.orders import Inbox, Note, Order
from otolith.core.errors import OtolithError

IDLE: Final = 0.05  # [s] between looks for orders
SAID: Final = 12  # latest sentences that are shown
STOPS: Final = ("stop", "cancel")  # words that end an errand

STOPPED: Final = {
    "learn": "learning was stopped; nothing is kept",
    "check": "the test of this computer was stopped; nothing is kept",
    "axis": "the axis test was stopped; nothing is kept",
}

Errand = Callable[["Talk", Mapping[str, Any]], str]  # returns the sentence of its end


class Ended(Exception):
    """An errand is asked to end."""


class Talk:
    """What an errand says to pages, and what it hears from them."""

    def __init__(self, note: Note, inbox: Inbox, asked: Sequence[int]) -> None:
        self._note, self._inbox, self._asked = note, inbox, asked
        self._said: list[str] = []
        self.shown: dict[str, Any] = {}  # values beside the sentences
        self._last = ("idle", "", "")
        self._errand, self._count = "", int(note.look().get("count", 0))

    def begin(self, errand: str) -> None:
        """Begin an errand."""
        self._errand, self._said, self.shown = errand, [], {}
        self._count += 1
        self._state("begun", "", errand)

    def end(self, phase: str, sentence: str) -> None:
        """Say how the errand ended: done, stopped or failed."""
        self._state(phase, sentence, busy="")

    def tell(self, sentence: str) -> None:
        """Add a sentence to what is shown."""
        self._said = [*self._said[1 - SAID :], sentence[:300]]
        self.show()

    def show(self, **shown: Any) -> None:
        """Show values; those that were shown before stay."""
        self.shown |= shown
        self._state("running", "", busy=self._errand)

    def again(self) -> None:
        """State the same again, because orders came that are void now."""
        self._state(*self._last)

    def _state(self, phase: str, sentence: str, busy: str = "") -> None:
        self._last = (phase, sentence, busy)
        self._note.state(
            {
                "errand": self._errand,
                "busy": busy,
                "phase": phase,
                "sentence": sentence[:500],
                "said": self._said,
                "shown": self.shown,
                "count": self._count,
                "reached": self._inbox.reached,
            }
        )

    def heard(self) -> list[Order]:
        """Return the orders that came since the last call.

        Raises
        ------
        Ended : one of them is to stop, or this process is asked to end.
        """
        orders = list(self._inbox.new())
        if self._asked or any(order.word in STOPS for order in orders):
            self.tell("stop: what goes on is brought to its end")
            raise Ended
        return orders


class Runner:
    """Carries out errands by their names, one at a time.

    Parameters
    ----------
    asked : becomes longer when the process is to end.
    """

    def __init__(self, note: Note, inbox: Inbox, errands: Mapping[str, Errand], asked: Sequence[int]) -> None:
        before = note.look()
        self._inbox, self._errands = inbox, errands
        self._talk, self._reached = Talk(note, inbox, asked), inbox.reached
        if before.get("busy"):
            self._talk.begin(str(before["busy"]))
            self._talk.end("failed", "it ended unexpectedly: its process died and was started anew")
        elif not before:
            self._talk.end("idle", "")

    def look(self) -> None:
        """Carry out the errand that was ordered last, unless a stop came after it."""
        fresh = self._inbox.new()
        orders = [order for order in fresh if order.word in (*self._errands, *STOPS)]
        if orders and orders[-1].word not in STOPS:
            self._carry_out(orders[-1])
        elif self._inbox.reached > self._reached:
            self._talk.again()
        self._reached = self._inbox.reached

    def _carry_out(self, order: Order) -> None:
        self._talk.begin(order.word)
        self._talk.show()
        try:
            self._talk.end("done", self._errands[order.word](self._talk, order.values))
        except Ended:
            self._talk.end("stopped", STOPPED[order.word])
        except OtolithError as error:
            self._talk.end("failed", str(error))


def run_errands(note: Note, inbox: Inbox, errands: Mapping[str, Errand], asked: Sequence[int]) -> None:
    """Carry out errands until the process is asked to end."""
    runner = Runner(note, inbox, errands, asked)
    while not asked:
        runner.look()
        time.sleep(IDLE)
