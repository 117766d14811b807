"""The keeper: it owns the shared memory, starts server and worker, and starts a dead one anew.

It does nothing else, so nothing can go wrong in it. Server and worker know each other only by the memory that
the keeper has made: either may die, by a fault or by hand, while the other goes on.
"""

import contextlib
import gc
import math
import multiprocessing
import os
import signal
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, Final, Self

from otolith.commander.columns import COUNT
from otolith.commander.orders import Inbox, Note, Orders
from otolith.commander.rows import Rows
from otolith.commander.security import Secrets
from otolith.commander.session import (
    CHANNELS,
    LIVE,
    MAPS,
    OFFLINE,
    PLATFORMS,
    PRESETS,
    RESULTS,
    UPLOADS,
    Desk,
    Session,
)
from otolith.core.errors import OtolithError
from otolith.live.shell.memory import Channel
from otolith.live.shell.rights import die_with_parent

AGAIN: Final = 0.5  # [s] before a process that died is started anew
GRACE: Final = 3.0  # [s] for a process to end …
HOME: Final = 90.0  # … and for that of the rig, which brings a platform home
RIG: Final = "rig"
GIVEN_UP: Final = 5  # deaths in a row, each within `SOON`, after which the keeper ends
SOON: Final = 5.0  # [s]
NAMES: Final = ("state", "card", "orders", "said", "rig", "errands")  # channels in shared memory


class GivenUp(OtolithError):
    """A process of the Commander dies again and again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """All that the processes are told; it is handed to them when they start.

    Parameters
    ----------
    make, desk : functions of the command line, which call what `otolith run` calls; None for a live session.
    parameters : what may be changed while a live session runs, and its values at the start.
    """

    prefix: str  # of the names of shared memory
    folder: Path
    listening: socket.socket
    host: str
    secrets: Secrets
    make: Callable[..., Any] | None = None
    desk: Callable[[], Desk] | None = None
    parameters: Mapping[str, float] = field(default_factory=dict)

    def name(self, what: str) -> str:
        """Return the name of a segment of shared memory."""
        return f"{self.prefix}-{what}"

    @property
    def port(self) -> int:
        """Return the port of the server."""
        return int(self.listening.getsockname()[1])

    @property
    def address(self) -> str:
        """Return the address of the page, with the token if there is one."""
        token = f"?token={self.secrets.token}" if self.secrets.token is not None else ""
        return f"http://{self.host}:{self.port}/{token}"

    @property
    def hosts(self) -> frozenset[str]:
        """Return the hosts that may be asked for."""
        return frozenset(f"{name}:{self.port}" for name in ("127.0.0.1", "localhost", "[::1]", self.host))


class Keeper:
    """Keeps processes running, within shared memory that `memory` has made; to be used in a `with` block.

    Parameters
    ----------
    targets : what each process runs, by its name; it is given the setup, and `more`.
    """

    def __init__(
        self,
        setup: Setup,
        tell: Callable[[str], None],
        targets: Mapping[str, Callable[..., None]],
        more: Mapping[str, tuple[Any, ...]] | None = None,
    ) -> None:
        self._setup, self._stack = setup, contextlib.ExitStack()
        self._tell, self._targets, self._more = tell, targets, more or {}
        self._kept: list[_Kept] = []

    def __enter__(self) -> Self:
        for folder in (UPLOADS, PRESETS, RESULTS, PLATFORMS, MAPS, CHANNELS):
            (self._setup.folder / folder).mkdir(parents=True, exist_ok=True)
        for name, target in self._targets.items():
            one = _Kept(name, target, (self._setup, *self._more.get(name, ())), self._tell)
            self._stack.callback(one.end)
            self._kept.append(one)
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def look(self, timeout: float = 0.0) -> None:
        """Start anew what has died, after `AGAIN`; wait at most `timeout` [s] for a death.

        Raises
        ------
        GivenUp : a process dies again and again.
        """
        if timeout:
            wait([one.sentinel for one in self._kept if one.alive], timeout)
        for one in self._kept:
            one.look()


def keep(setup: Setup, tell: Callable[[str], None], *, on: Callable[[], bool] = lambda: True) -> None:
    """Keep server and simulation running until `on` returns False, or a signal ends the program.

    Raises
    ------
    GivenUp : one of them dies again and again.
    """
    targets: dict[str, Callable[..., None]] = {
        "server": run_server,
        "simulation": run_simulation,
        RIG: run_rig,
    }
    with memory(setup), Keeper(setup, tell, targets) as keeper:
        while on():
            keeper.look(0.25)


class _Kept:
    """A process that is started anew when it dies."""

    def __init__(
        self, name: str, target: Callable[..., None], arguments: tuple[Any, ...], tell: Callable[[str], None]
    ) -> None:
        self._name, self._target, self._arguments, self._tell = name, target, arguments, tell
        self._deaths, self._died_at = 0, -math.inf
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._process = context.Process(
            target=self._target, args=self._arguments, name=f"otolith {self._name}"
        )
        self._process.start()
        self._began = time.monotonic()

    @property
    def alive(self) -> bool:
        """Return whether the process runs."""
        return self._process.is_alive()

    @property
    def sentinel(self) -> int:
        """Return what becomes ready when the process dies."""
        return self._process.sentinel

    def look(self) -> None:
        """Start the process anew some time after it has died; see `Keeper.look`.

        One that ended by itself, without an error, is started at once: it was told to.
        """
        if self._process.is_alive():
            return
        if self._process.exitcode == 0:
            self._start()
            return
        now = time.monotonic()
        if self._died_at < self._began:
            self._died_at = now
            self._deaths = self._deaths + 1 if now - self._began < SOON else 1
            if self._deaths >= GIVEN_UP:
                raise GivenUp(f"the {self._name} died {GIVEN_UP} times within {SOON:g} s of its start")
            self._tell(f"the {self._name} died (exit code {self._process.exitcode}); it is started anew")
        elif now - self._died_at > AGAIN:
            self._start()

    def end(self) -> None:
        """End the process."""
        self._process.terminate()
        self._process.join(HOME if self._name == RIG else GRACE)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()


@contextlib.contextmanager
def memory(setup: Setup) -> Iterator[None]:
    """Make the shared memory, and remove it in the end."""
    with Rows(setup.name("rows"), COUNT), contextlib.ExitStack() as stack:
        for what in NAMES:
            stack.enter_context(Channel(setup.name(what), create=True))
        yield


def begin_child() -> None:
    """Let the keeper decide about Ctrl-C, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    die_with_parent(signal.SIGTERM, os.getppid() if parent is None or parent.pid is None else parent.pid)


def run_simulation(setup: Setup) -> None:
    """Be the worker, until a signal ends this process."""
    from otolith.commander.runner import run_worker
    from otolith.core.threads import one_thread

    assert setup.make is not None  # noqa: S101 (a live session has no simulation)
    begin_child()
    state, card = Note(Channel(setup.name("state"))), Note(Channel(setup.name("card")))
    inbox = Inbox(Channel(setup.name("orders")), int(state.look().get("reached", 0)))
    with one_thread():  # small matrices: more threads only wait for each other
        run_worker(
            Rows(setup.name("rows")),
            (state, card),
            inbox,
            make=setup.make,
            folder=setup.folder,
            on=lambda: True,
        )


def run_rig(setup: Setup) -> None:
    """Carry out errands of the rig, until a signal ends this process."""
    from otolith.commander.errands import run_errands
    from otolith.commander.rig_errands import errands
    from otolith.live.shell.processes import asked_to_end

    asked = asked_to_end()
    begin_child()
    note = Note(Channel(setup.name("rig")))
    inbox = Inbox(Channel(setup.name("errands")), int(note.look().get("reached", 0)))
    run_errands(note, inbox, errands(setup.folder), asked)


def run_server(setup: Setup) -> None:
    """Be the server, until a signal ends this process."""
    import uvicorn

    from otolith.commander.app import create_app
    from otolith.commander.security import MESSAGE

    begin_child()
    offline = setup.desk is not None
    session = Session(
        rows=Rows(setup.name("rows")),
        state=Note(Channel(setup.name("state"))),
        card=Note(Channel(setup.name("card"))),
        orders=Orders(Channel(setup.name("orders"))),
        desk=None if setup.desk is None else setup.desk(),
        folder=setup.folder,
        secrets=setup.secrets,
        hosts=setup.hosts,
        words=OFFLINE if offline else LIVE,
        rig=Note(Channel(setup.name("rig"))) if offline else None,
        errands=Orders(Channel(setup.name("errands"))) if offline else None,
        parameters=setup.parameters,
    )
    config = uvicorn.Config(
        create_app(session),
        ws="websockets-sansio",
        ws_max_size=MESSAGE,
        ws_per_message_deflate=False,
        ws_ping_interval=20.0,
        ws_ping_timeout=20.0,
        limit_concurrency=64,
        timeout_graceful_shutdown=1,
        log_level="warning",
        access_log=False,
        server_header=False,
        lifespan="off",
    )
    config.load()
    gc.collect()
    gc.freeze()  # a search through all that is loaded, 100,000 objects, would hold up a STOP for 60 ms
    uvicorn.Server(config).run(sockets=[setup.listening])
