"""A real Commander: keeper, server and simulation as processes, on a free port."""

import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from otolith.cli.commander import listening, setup_for
from otolith.commander.feed import parameters_of
from otolith.commander.keeper import Setup, keep
from otolith.commander.security import Secrets, new_token
from otolith.commander.watched import watched
from otolith.live.shell.supervise import Live, only_session
from tests.commander.client import Page
from tests.live.shell.rig import Rig

LOCAL = "127.0.0.1"


class Commander:
    """A Commander that runs in the background of tests."""

    def __init__(self, folder: Path, token: str | None = None) -> None:
        self._socket = listening(LOCAL, 0)
        self.setup = setup_for(self._socket, LOCAL, folder, Secrets(token=token))
        self.said: list[str] = []
        self._on = True
        self._thread = threading.Thread(
            target=keep, args=(self.setup, self.said.append), kwargs={"on": self.on}
        )
        self._thread.start()

    def on(self) -> bool:
        return self._on

    @property
    def port(self) -> int:
        return self.setup.port

    def page(self) -> Page:
        """Return another browser."""
        return Page(self.port)

    def processes(self) -> list[Any]:
        """Return the processes that are alive."""
        return [one for one in multiprocessing.active_children() if one.name.startswith("otolith")]

    def end(self) -> None:
        self._on = False
        self._thread.join()
        self._socket.close()


@pytest.fixture(scope="package")
def commander(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Commander]:
    made = Commander(tmp_path_factory.mktemp("commander"))
    try:
        yield made
    finally:
        made.end()


@pytest.fixture
def page(commander: Commander) -> Iterator[Page]:
    """A browser in control, with nothing running before and after."""
    made = commander.page()
    made.say("control")
    made.quiet()
    yield made
    made.quiet()


def until(what, seconds: float = 60.0, every: float = 0.05):
    """Wait until a function returns something true, and return it."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = what()
        if found:
            return found
        time.sleep(every)
    raise TimeoutError(f"waited {seconds} s in vain")


@pytest.fixture
def live_session(tmp_path: Path) -> Iterator[tuple[Live, Rig, Page, list[str]]]:
    """A session that is idle, its page, and a supervisor that passes words on."""
    told: list[str] = []
    over = threading.Event()
    with Rig() as rig, only_session(("127.0.0.1", rig.device)) as lock, listening("127.0.0.1", 0) as line:
        also: list[Callable[[str], None]] = [told.append]
        live = Live(rig.session(), lambda text: _tell(also, text), lock=lock, log=tmp_path / "logs")
        secrets = Secrets(token=new_token())
        setup = Setup(
            prefix=f"otolith-test-{os.getpid()}",
            folder=tmp_path,
            listening=line,
            host="127.0.0.1",
            secrets=secrets,
            parameters=parameters_of(rig.session()),
        )
        with watched(setup, rig.session(), live.names, live.change) as pages:

            def supervise() -> None:
                while not over.wait(0.01):
                    live.look()
                    if words := pages.words(lambda text: _tell(also, text)):
                        live.say(*words)

            supervisor = threading.Thread(target=supervise)
            also.append(pages.tell)
            try:
                live.start()
                pages.tell("started")
                supervisor.start()
                yield live, rig, Page(setup.port, secrets.token), told
            finally:
                over.set()
                supervisor.join() if supervisor.ident else None
                live.end()


def _tell(listeners: list[Callable[[str], None]], text: str) -> None:
    for listener in listeners:
        listener(text)
