"""A STOP by request while the server's threads are all busy, with the application itself and no server."""

import asyncio
import gc
import json
import os
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import anyio.to_thread
import pytest
import uvicorn

from otolith.cli.commander import listening, setup_for
from otolith.commander import keeper
from otolith.commander.app import create_app
from otolith.commander.orders import Inbox, Note, Orders
from otolith.commander.security import Secrets
from otolith.commander.session import LIVE, Session
from otolith.live.shell.memory import Channel

PATIENCE = 60.0  # [s]
HOST = "127.0.0.1:8765"


async def status_of(app: Any, body: bytes, csrf: str) -> int:
    """POST a word, and return the status of the answer."""
    headers = {"host": HOST, "x-otolith": csrf, "content-type": "application/json"}
    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": "POST",
        "scheme": "http",
        "path": "/api/word",
        "raw_path": b"/api/word",
        "query_string": b"",
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
    }
    sent: list[Any] = []

    async def receive() -> Any:
        return {"type": "http.request", "body": body, "more_body": False}

    async def send(message: Any) -> None:
        sent.append(message)

    await app(scope, receive, send)
    return int(sent[0]["status"])


def test_a_stop_needs_none_of_the_threads_that_others_keep_busy(tmp_path: Path) -> None:
    """Slow requests, such as checks of a form, may occupy every thread of the server."""
    with Channel(f"otolith-test-{os.getpid()}-orders", create=True) as orders:
        nothing: Any = None
        session = Session(
            rows=nothing,
            state=Note(nothing),
            card=Note(nothing),
            orders=Orders(orders),
            desk=None,
            folder=tmp_path,
            secrets=Secrets(),
            hosts=frozenset({HOST}),
            words=LIVE,
        )
        app = create_app(session)
        over = threading.Event()

        async def stopped() -> int:
            anyio.to_thread.current_default_thread_limiter().total_tokens = 1
            slow = asyncio.create_task(anyio.to_thread.run_sync(over.wait, PATIENCE))
            await asyncio.sleep(0.0)  # it has the only thread now
            body = json.dumps({"word": "stop"}).encode()
            try:
                return await asyncio.wait_for(status_of(app, body, session.secrets.csrf), 0.5 * PATIENCE)
            finally:
                over.set()
                await slow

        assert asyncio.run(stopped()) == 204
        assert [order.word for order in Inbox(orders, 0).new()] == ["stop"]


def test_what_is_loaded_when_serving_begins_is_never_searched_for_garbage_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A search through it takes 60 ms, for which nothing is answered."""
    frozen: list[int] = []
    monkeypatch.setattr(keeper, "begin_child", lambda: None)
    monkeypatch.setattr(uvicorn.Server, "run", lambda *_, **__: frozen.append(gc.get_freeze_count()))
    with listening("127.0.0.1", 0) as line:
        setup = replace(setup_for(line, "127.0.0.1", tmp_path, Secrets()), desk=None)
        with keeper.memory(setup):
            keeper.run_server(setup)
    loaded = len(gc.get_objects())
    gc.unfreeze()
    assert frozen[0] > 10 * loaded
