"""A real Commander: keeper, server and simulation as processes, on a free port."""

import multiprocessing
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from otolith.cli.commander import listening, setup_for
from otolith.commander.keeper import keep
from otolith.commander.security import Secrets
from tests.commander.client import Page

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
