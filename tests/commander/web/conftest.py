"""A browser, the stand-in for the server, and pages that must not complain nor ask anybody else."""

import json
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")  # playwright leaves a loop of events running, in which no other can be
def browser() -> Iterator[Browser]:
    """The system's chromium: playwright's own is not downloaded."""
    found = shutil.which("chromium")
    if found is None:
        pytest.skip("there is no chromium here, so the Commander's page is not tried in a browser")
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        yield made
        made.close()


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


class Server:
    """A server in a process of its own."""

    def __init__(self, command: list[str], port: int, log: Path) -> None:
        self.url, self.log = f"http://127.0.0.1:{port}", log
        with log.open("w") as output:
            self.process = subprocess.Popen(command, stdout=output, stderr=output, cwd=ROOT)

    def wait(self, seconds: float = 60.0) -> None:
        """Wait until the server answers; a server that died says why."""
        until = time.monotonic() + seconds
        while time.monotonic() < until and self.process.poll() is None:
            try:
                with urllib.request.urlopen(f"{self.url}/health") as answer:
                    assert json.load(answer)["ok"]
                return
            except OSError:
                time.sleep(0.1)
        self.end()
        raise AssertionError(f"the server did not answer:\n{self.log.read_text()}")

    def fault(self, **body: Any) -> dict[str, Any]:
        """Tell the stand-in what to do; return what it saw."""
        request = urllib.request.Request(
            f"{self.url}/fault", json.dumps(body).encode(), {"Content-Type": "application/json"}
        )
        with urllib.request.urlopen(request) as answer:
            seen: dict[str, Any] = json.load(answer)
        return seen

    def end(self) -> None:
        self.process.terminate()
        self.process.wait()


@pytest.fixture(scope="module")
def fake(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """The stand-in for the server: `Server.fault` makes it fail."""
    port = free_port()
    command = [sys.executable, "-m", "tests.commander.web.fake_server", str(port)]
    server = Server(command, port, tmp_path_factory.mktemp("fake") / "log.txt")
    server.wait()
    yield server
    server.end()


class Watched:
    """A page whose console, errors and requests are watched."""

    def __init__(self, context: BrowserContext, url: str) -> None:
        self.page, self.url = context.new_page(), url
        self.complaints: list[str] = []
        self.hosts: set[str] = set()
        self.page.set_default_timeout(20_000)
        self.page.on("console", lambda message: self._hear(message.type, message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(f"page error: {error}"))
        self.page.on("request", lambda request: self.hosts.add(urlsplit(request.url).netloc))
        self.page.on("websocket", lambda one: self.hosts.add(urlsplit(one.url).netloc))

    def _hear(self, kind: str, text: str) -> None:
        if kind == "error":
            self.complaints.append(f"{kind}: {text}")

    def open(self) -> Page:
        self.page.goto(self.url, wait_until="domcontentloaded")
        self.page.wait_for_selector("#setup .verdict:not(:empty)")
        return self.page

    def check(self) -> None:
        """No complaint, and no request to any other host."""
        assert self.complaints == []
        assert self.hosts == {urlsplit(self.url).netloc}


@pytest.fixture
def watched(browser: Browser, fake: Server) -> Iterator[Watched]:
    """A page at the stand-in, where nothing runs."""
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    page = Watched(context, f"{fake.url}/")
    fake.fault(reset=True)
    yield page
    context.close()
    page.check()
