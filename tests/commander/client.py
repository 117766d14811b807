"""A browser for tests: requests with cookies, and the stream with or without acknowledging."""

import json
import time
from contextlib import ExitStack
from http.client import HTTPConnection
from typing import Any

import numpy as np
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from otolith.commander.frames import PROTOCOL, Frame, unpack

PATIENCE = 60.0  # [s] for a simulation that loads its kernels on a busy machine


class Answer:
    """Status and content of an answer."""

    def __init__(self, status: int, headers: dict[str, str], body: bytes) -> None:
        self.status, self.headers, self.body = status, headers, body

    @property
    def json(self) -> Any:
        return json.loads(self.body)


class Page:
    """One browser."""

    def __init__(self, port: int, token: str | None = None) -> None:
        self.port, self.csrf, self.cookies = port, "", dict[str, str]()
        first = "/health" if token is None else f"/?token={token}"
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:  # the server may still be starting
            try:
                self.ask(first)
                self.start = self.ask("/api/start").json
                break
            except (ConnectionError, TimeoutError):
                time.sleep(0.1)
        self.csrf = self.start["csrf"]

    @property
    def cookie(self) -> str:
        return "; ".join(f"{name}={value}" for name, value in self.cookies.items())

    def ask(
        self,
        path: str,
        values: Any = None,
        *,
        method: str | None = None,
        body: bytes | None = None,
        **headers: str,
    ) -> Answer:
        """Ask for a path; with values, or a body, it is a POST."""
        content = json.dumps(values).encode() if values is not None else body
        sent = {"X-Otolith": self.csrf} if self.csrf else {}
        sent |= {"Cookie": self.cookie} if self.cookies else {}
        if values is not None:
            sent["Content-Type"] = "application/json"
        sent |= {name.replace("_", "-"): value for name, value in headers.items()}
        line = HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        try:
            line.request(method or ("GET" if content is None else "POST"), path, content, sent)
            answer = line.getresponse()
            for cookie in answer.headers.get_all("set-cookie") or ():
                name, _, value = cookie.partition(";")[0].partition("=")
                self.cookies[name] = value
            return Answer(answer.status, dict(answer.headers), answer.read())
        finally:
            line.close()

    def say(self, word: str) -> int:
        """Say a word; return the status."""
        return self.ask("/api/word", {"word": word}).status

    def state(self) -> dict[str, Any]:
        """Return the state, from a stream of its own."""
        with self.stream() as stream:
            return stream.until("state")

    def quiet(self) -> None:
        """Stop what runs, and wait until nothing does."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if not self.state()["busy"]:
                return
            self.say("stop")
            time.sleep(0.05)
        raise TimeoutError("the simulation does not stop")

    def stream(self, **headers: str) -> "Stream":
        """Open the stream."""
        return Stream(self.port, {"Cookie": self.cookie} | headers)

    def run(self, **values: Any) -> int:
        """Start a run; return its generation."""
        answer = self.ask("/api/run", values)
        assert answer.status == 202, answer.body
        return answer.json["generation"]


class Stream:
    """A websocket."""

    def __init__(self, port: int, headers: dict[str, str]) -> None:
        origin = headers.pop("Origin", f"http://127.0.0.1:{port}")
        self._stack = ExitStack()
        self.socket: ClientConnection = self._stack.enter_context(
            connect(
                f"ws://127.0.0.1:{port}/stream",
                subprotocols=[Subprotocol(PROTOCOL)],
                origin=Origin(origin) if origin else None,
                additional_headers=headers,
                max_size=None,
            )
        )
        self.texts: list[dict[str, Any]] = []
        self.frames: list[Frame] = []

    def __enter__(self) -> "Stream":
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def send(self, message: Any) -> None:
        self.socket.send(json.dumps(message))

    def next(self, *, acknowledge: bool = True, timeout: float = PATIENCE) -> dict[str, Any] | Frame:
        """Return the next message."""
        message = self.socket.recv(timeout)
        if isinstance(message, str):
            self.texts.append(json.loads(message))
            if self.texts[-1]["kind"] == "schema":
                self.frames.clear()  # those of an earlier run
            return self.texts[-1]
        self.frames.append(unpack(message))
        if acknowledge:
            self.send({"ack": self.frames[-1].sequence})
        return self.frames[-1]

    def until(self, kind: str, **values: Any) -> dict[str, Any]:
        """Return the next text of a kind that has these values, acknowledging frames meanwhile."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            found = self.next()
            if isinstance(found, dict) and found["kind"] == kind and values.items() <= found.items():
                return found
        raise TimeoutError(f"no {kind} with {values}")

    def frame(self, *, acknowledge: bool = True, timeout: float = PATIENCE) -> Frame:
        """Return the next frame."""
        while True:
            found = self.next(acknowledge=acknowledge, timeout=timeout)
            if isinstance(found, Frame):
                return found

    def rows(self) -> np.ndarray:
        """Return all rows that came."""
        return np.vstack([frame.rows for frame in self.frames])
