"""What the server knows: the shared memory, who is in control, and the Commander's own folder."""

import re
import secrets
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Protocol

from starlette.requests import Request

from otolith.commander.orders import Note, Orders
from otolith.commander.rows import Rows
from otolith.commander.schema import FILE, changed
from otolith.commander.security import Rate, Refused, Secrets
from otolith.live.settings import changes_from

# Folders within the Commander's own.
UPLOADS, PRESETS, RESULTS, PLATFORMS, MAPS, CHANNELS = (
    "drives",
    "presets",
    "results",
    "platforms",
    "maps",
    "channels",
)
STOP: Final = "stop"
CHANGE: Final = "change"  # the order for other parameters
LEFT: Final = 5.0  # [s] without a websocket after which a client has left
OFFLINE: Final = ("stop", "pause", "resume")  # words
MEASURING: Final = ("check", "axis")  # errands of the rig that a run would disturb
LIVE: Final = ("arm", "engage", "return", "stop", "park", "rearm")


class Desk(Protocol):
    """What needs the rest of the program; the command line provides it, imported on first use."""

    def check(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return checks and the command line of a form's values; errors are those of the form."""

    def understood(self, path: Path) -> str:
        """Say what is understood of a recorded drive."""

    def samples(self, run: Path) -> str:
        """Return the samples of a stored run as text, comma-separated."""


@dataclass
class Session:
    """One server's view of a run.

    Parameters
    ----------
    folder : the Commander's own; nothing outside of it is read or written for a page.
    """

    rows: Rows
    state: Note
    card: Note
    orders: Orders
    desk: Desk | None  # None where no run can be started: a live session is watched
    folder: Path
    secrets: Secrets
    hosts: frozenset[str]
    words: tuple[str, ...] = OFFLINE
    parameters: Mapping[str, float] = field(default_factory=dict)  # of a live session, at its start
    rig: Note | None = None  # what the rig's process says, and its orders; None beside a live session
    errands: Orders | None = None
    rate: Rate = field(default_factory=Rate)
    controlling: str = ""  # the client in control; empty: nobody
    now: Callable[[], float] = time.monotonic
    _open: dict[str, int] = field(default_factory=dict)  # websockets of each client
    _left_at: float = 0.0  # [s] when the last websocket of the client in control closed …
    _spoke_at: float = 0.0  # … and when it spoke last

    @property
    def mode(self) -> str:
        """Return what the page is told that this is: offline or live."""
        return "live" if self.desk is None else "offline"

    def came(self, client: str) -> None:
        """Note a websocket of a client that opened."""
        self._open[client] = self._open.get(client, 0) + 1

    def went(self, client: str) -> None:
        """Note a websocket that closed."""
        self._open[client] -= 1
        if not self._open[client]:
            del self._open[client]
            if client == self.controlling:
                self._left_at = self.now()

    def in_control(self) -> str:
        """Return the client in control; it loses control when it has been away for `LEFT` seconds."""
        away = self.controlling not in self._open
        if away and self.now() - max(self._left_at, self._spoke_at) > LEFT:
            self.controlling = ""
        return self.controlling

    def desk_of_runs(self) -> Desk:
        """Return what runs need.

        Raises
        ------
        Refused : a live session is watched, which is set by its file and not by a form.
        """
        if self.desk is None:
            raise Refused(
                409, "a live session is watched here: it is set by its file, and runs are not started"
            )
        return self.desk

    def running(self) -> bool:
        """Return whether a run goes on, or is ordered and has not begun."""
        state = self.state.look()
        return bool(state.get("busy", True)) or int(state["reached"]) < self.orders.number

    def errand(self) -> str:
        """Return the errand of the rig that goes on, or is ordered and has not begun; empty if none is."""
        if self.rig is None or self.errands is None:
            return ""
        told, last = self.rig.look(), self.errands.last
        if last is not None and int(told.get("reached", 0)) < last["number"]:
            return str(last["word"])
        return str(told.get("busy", ""))

    def control(self, client: str) -> None:
        """Let a client have control if nobody has.

        Raises
        ------
        Refused : somebody else is in control.
        """
        if not client:
            raise Refused(403, "this client has no name: ask for /api/start first, and keep its cookie")
        if self.in_control() not in ("", client):
            raise Refused(403, "somebody else is in control; take control first")
        self.controlling, self._spoke_at = client, self.now()

    def speak(self, client: str, word: str) -> None:
        """Pass on a word of a client.

        Raises
        ------
        Refused : it is no word here, one too many within a second, or the client is not in control. A stop is
            never refused.
        """
        if word == STOP:
            self.give(STOP)
            if self.errands is not None:
                self.errands.give(STOP, {})
            return
        if not self.rate.allows(client):
            raise Refused(429, "too many words within a second")
        if word == "control":
            self.controlling = ""
            self.control(client)
            return
        if word not in self.words:
            raise Refused(422, f"there is no word {word[:40]!r} here, must be one of {', '.join(self.words)}")
        self.control(client)
        self.give(word)

    def changed(self, values: Mapping[str, Any]) -> dict[str, float]:
        """Return parameters that are to be changed while it runs, checked.

        Raises
        ------
        InputError : one is out of its bounds, or none of those that may change.
        """
        return changed(values) if self.desk is not None else changes_from(values, self.parameters)

    def give(self, word: str, values: Mapping[str, Any] | None = None) -> int:
        """Write an order for the worker; return its number."""
        return self.orders.give(word, values or {})

    def place(self, folder: str, name: str, ending: str = "") -> Path:
        """Return where a file of the Commander's folder is or will be.

        Raises
        ------
        Refused : the name is none of a file.
        """
        if re.fullmatch(FILE, name) is None:
            raise Refused(
                422, "the name must be of letters, digits, dots, dashes and underscores, at most 64"
            )
        return self.folder / folder / f"{name}{ending}"

    def uploads(self) -> list[str]:
        """Return the names of the drives in the Commander's folder."""
        return self.names(UPLOADS)

    def names(self, folder: str, ending: str = "") -> list[str]:
        """Return the names of the files in one of the Commander's folders."""
        found = (path for path in (self.folder / folder).iterdir() if path.is_file())
        return sorted(path.name for path in found if path.suffix == ending or not ending)


def count(request: Request, session: Session) -> None:
    """Refuse a client that asks too often."""
    if not session.rate.allows(request.scope["otolith"]["client"]):
        raise Refused(429, "too many requests within a second")


def new_client() -> str:
    """Return a name for a browser."""
    return secrets.token_urlsafe(16)
