"""Orders from the server to the worker, and what the worker says of itself, in shared memory.

Both are messages of JSON in a `Channel`, which keeps only the latest. So a message of orders repeats the last
few, each with its number, and the worker carries out those above the number that it has reached. A server
that comes back after its death goes on counting where the dead one stopped.
"""

import json
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from otolith.live.shell.memory import Channel

KEPT: Final = 16  # orders in a message
AGAIN: Final = 0.05  # [s] within which the same word is the same order


@dataclass(frozen=True, slots=True)
class Order:
    """One order: a word, such as "stop", and its values."""

    number: int
    word: str
    values: Mapping[str, Any]


class Orders:
    """The server's end of the orders."""

    def __init__(self, channel: Channel, now: Callable[[], float] = time.monotonic) -> None:
        self._channel, self._now = channel, now
        message = channel.read()
        self._given: list[dict[str, Any]] = [] if message is None else json.loads(message)
        self._at = -math.inf  # [s] when the last order was given

    @property
    def number(self) -> int:
        """Return the number of the last order; 0 before the first."""
        return int(self._given[-1]["number"]) if self._given else 0

    @property
    def last(self) -> dict[str, Any] | None:
        """Return the last order; None before the first."""
        return self._given[-1] if self._given else None

    def give(self, word: str, values: Mapping[str, Any]) -> int:
        """Give an order and return its number.

        A word without values that was the last order less than `AGAIN` ago is not repeated. So a flood of
        them does not displace other orders.
        """
        last = self._given[-1] if self._given else {"word": None, "values": None}
        same = last["word"] == word and not values and not last["values"]
        if not (same and self._now() - self._at < AGAIN):
            order = {"number": self.number + 1, "word": word, "values": dict(values)}
            self._given, self._at = [*self._given[1 - KEPT :], order], self._now()
            self._channel.write(json.dumps(self._given).encode())
        return self.number


class Inbox:
    """The worker's end of the orders.

    Parameters
    ----------
    reached : number of the last order that was carried out, by this worker or one before it.
    """

    def __init__(self, channel: Channel, reached: int) -> None:
        self._channel, self.reached = channel, reached

    def new(self) -> Sequence[Order]:
        """Return the orders that came since the last call, in their sequence."""
        message = self._channel.read()
        if message is None:
            return ()
        orders = [Order(**order) for order in json.loads(message)]
        fresh = [order for order in orders if order.number > self.reached]
        self.reached = max([self.reached, *(order.number for order in fresh)])
        return fresh


class Note:
    """A value that one process states and others look at: the latest counts."""

    def __init__(self, channel: Channel) -> None:
        self._channel, self._value = channel, {}  # type: ignore[var-annotated]

    def state(self, value: Mapping[str, Any]) -> None:
        """State a new value; NaN is refused, since JSON has none."""
        self._channel.write(json.dumps(value, allow_nan=False).encode())

    def look(self) -> dict[str, Any]:
        """Return the latest value; empty before the first."""
        message = self._channel.read()
        if message is not None:
            self._value = json.loads(message)
        return self._value
