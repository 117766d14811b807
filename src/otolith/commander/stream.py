"""The websocket: rows of signals as binary frames, and state and events as text.

Every client reads the shared ring with a cursor of its own. It acknowledges each frame that it has drawn or
dropped, and at most `WINDOW` are on their way. Without this, a page that sleeps would find frames that are
ten seconds old in the buffers of its system when it wakes (measured). Whoever was held up for longer than
`PATIENCE` is taken to the present, and its plots show a gap.
"""

import asyncio
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from otolith.commander.frames import ENVELOPE, PROTOCOL, RAW, WINDOW, Frame, envelope, gap
from otolith.commander.security import CLIENTS, Rate, Refused
from otolith.commander.session import Session
from otolith.core.arrays import Bools, Ints, Singles

FRAMES: Final = 30.0  # per second
BUCKET: Final = 10  # samples; two rows each, so 200 rows per second of a signal at 1 kHz …
FINE: Final = 5  # … or 400, where few columns are sent
FEW: Final = 12  # columns that are sent in fine buckets: they are 19 kB/s
MOST: Final = 600  # buckets in a frame; where more wait, they are wider
PAST: Final = 2_400  # buckets in the frame that shows what is kept of the past
CHOICES: Final = 8  # of columns per second that a client may make: each is answered with the past
RAW_ROWS: Final = 1_024  # in a raw frame
RAW_FOR: Final = 10.0  # [s] after which raw frames end by themselves
PATIENCE: Final = 1.0  # [s] that a client may be held up without a gap
STATES: Final = 0.2  # [s] between two messages of state, unless something changes
MESSAGES: Final = 200  # per second that a client may send
POLICY_VIOLATION: Final = 1008


class Violation(Exception):
    """A client sent what no page sends."""


class Client:
    """What one client has, wants and has acknowledged; it knows no socket."""

    def __init__(self, session: Session, name: str) -> None:
        self._session, self.name = session, name
        self.generation = -1  # of the schema that it has
        self._cursor, self._sequence, self._acknowledged = 0, 0, 0
        self._chosen: Ints | None = None  # columns that it wants; None: all
        self._raw_until, self._held, self._gap = -math.inf, math.inf, False
        self._told: dict[str, Any] = {}
        self._rig: dict[str, Any] = {}
        self._told_at, self._event, self._done = -math.inf, 0, -1
        self._moved = -1  # generation of `_moving`
        self._rate, self._choices = Rate(MESSAGES), Rate(CHOICES)
        self._moving: Bools = np.zeros(session.rows.columns, dtype=np.bool_)  # columns that were ever not 0

    def waits(self, now: float) -> bool:
        """Return whether as many frames are on their way as may be.

        Where that is over after longer than `PATIENCE`, the next frame is of the present, after a gap.
        """
        if self._sequence - self._acknowledged >= WINDOW:
            self._held = min(self._held, now)
            return True
        if now - self._held > PATIENCE:
            written = self._session.rows.written
            bucket = self._bucket
            self._cursor, self._gap = max(self._cursor, written - written % bucket - bucket), True
        self._held = math.inf
        return False

    @property
    def _bucket(self) -> int:
        return FINE if self._chosen is not None and len(self._chosen) <= FEW else BUCKET

    def hear(self, message: Mapping[str, Any], now: float) -> str | None:
        """Take a message of the client; return a word for the worker if it is one.

        Raises
        ------
        Violation : it is none that a page sends, or one too many.
        """
        if not self._rate.allows(""):
            raise Violation(f"more than {MESSAGES} messages within a second")
        if "ack" in message:
            self._acknowledge(message["ack"])
        elif "want" in message:
            self._want(message, now)
        elif isinstance(message.get("word"), str):
            return str(message["word"])
        else:
            raise Violation("a message must have one of ack, want, word")
        return None

    def _acknowledge(self, sequence: Any) -> None:
        if not isinstance(sequence, int) or not 0 <= sequence <= self._sequence:
            raise Violation(f"ack must be the number of a frame, at most {self._sequence}")
        self._acknowledged = max(self._acknowledged, sequence)

    def _want(self, message: Mapping[str, Any], now: float) -> None:
        if message["want"] not in ("envelope", "raw"):
            raise Violation("want must be envelope or raw")
        self._raw_until = now + RAW_FOR if message["want"] == "raw" else -math.inf
        if "columns" in message:
            if not self._choices.allows(""):
                raise Violation(f"more than {CHOICES} choices of columns within a second")
            self._chosen = _indices(message["columns"], self._session.card.look().get("columns", []))
            self.generation = -1  # the schema is sent again, with these columns

    def texts(self, now: float) -> list[str]:
        """Return what is to be said now: schema, events, state, the end of a run."""
        card, state = self._session.card.look(), self._session.state.look()
        said: list[dict[str, Any]] = []
        if card and card["generation"] != self.generation:
            said.append(self._schema(card))
        said += self._events(state)
        rig = {} if self._session.rig is None else self._session.rig.look()
        if rig is not self._rig and rig:
            self._rig = rig
            said.append({"kind": "rig", **rig})
        shown = self._shown(state)
        lasting = {name: value for name, value in shown.items() if name not in ("time", "lamps")}
        if state and (lasting != self._told or now - self._told_at >= STATES):
            self._told, self._told_at = lasting, now
            said.append(shown)
        if card.get("summary") is not None and self._done != card["generation"]:
            self._done = card["generation"]
            said.append({"kind": "done", "generation": self._done, "summary": card["summary"]})
        return [json.dumps(one) for one in said]

    def _schema(self, card: Mapping[str, Any]) -> dict[str, Any]:
        new = card["generation"] != self._done and self.generation not in (-1, card["generation"])
        if card["generation"] != self._moved:
            self._moved, self._moving[:] = card["generation"], False
        self.generation, self._cursor, self._gap = card["generation"], 0, False
        if new:
            self._done = -1
        offered = columns = card["columns"]
        if self._chosen is not None:
            columns = [offered[k] for k in self._chosen]
        return {
            "kind": "schema",
            "generation": self.generation,
            "t0": 0.0,
            "columns": columns,
            "offered": offered,
            "rate": 2e3 / self._bucket,
            "values": card["values"],
            "command": card["command"],
        }

    def _events(self, state: Mapping[str, Any]) -> list[dict[str, Any]]:
        fresh = [event for event in state.get("events", []) if event["number"] > self._event]
        self._event = max([self._event, *(event["number"] for event in fresh)])
        return [{"kind": "event", **event} for event in fresh]

    def _shown(self, state: Mapping[str, Any]) -> dict[str, Any]:
        shown = {name: value for name, value in state.items() if name not in ("events", "reached")}
        held = self._session.in_control()
        columns = self._session.card.look().get("columns", [])
        moving = [one["name"] for one, moves in zip(columns, self._moving, strict=False) if moves]
        control = {"control": held == self.name != "", "controlled": held != ""}
        return {"kind": "state", **shown, **control, "moving": moving}

    def frame(self, now: float) -> bytes | None:
        """Return the next frame, or None if there is nothing new."""
        rows = self._session.rows
        if rows.generation != self.generation:
            return None
        raw = now < self._raw_until
        waiting = rows.written - self._cursor
        bucket, most = self._bucket, MOST if self._cursor else PAST
        wide = 1 if raw else bucket * max(1, math.ceil(waiting / (bucket * most)))
        ended = not self._session.state.look().get("running", False)
        count = min(waiting, RAW_ROWS) if raw else waiting if ended else waiting - waiting % wide
        if count <= 0:
            return None
        first, found = rows.read(self._cursor, count)
        self._gap = self._gap or first > self._cursor
        self._moving[1:] |= ((found != 0.0) & ~np.isnan(found)).any(axis=0)[1:]
        self._cursor = first + len(found)
        return self._packed(found, raw, wide) if len(found) else None

    def _packed(self, found: Singles, raw: bool, wide: int) -> bytes:
        rows = self._session.rows
        if self._chosen is not None:
            found = found[:, self._chosen]
        made = found if raw else envelope(found, wide)
        if self._gap:
            made, self._gap = np.vstack([gap(float(made[0, 0]), made.shape[1], 1 if raw else 2), made]), False
        self._sequence += 1
        kind = RAW if raw else ENVELOPE
        return Frame(
            kind=kind, sequence=self._sequence, t0=float(made[0, 0]), age=rows.age, decimation=wide, rows=made
        ).pack()


def _indices(names: Any, columns: Sequence[Mapping[str, Any]]) -> Ints:
    """Return the indices of columns, time before all others."""
    known = [column["name"] for column in columns]
    if not isinstance(names, list) or not all(name in known for name in names):
        raise Violation("columns must be a list of names of the schema")
    return np.array([0, *(known.index(name) for name in dict.fromkeys(names) if name != "time")])


class Stream:
    """All websockets of a server."""

    def __init__(self, session: Session) -> None:
        self._session, self._open = session, 0

    async def serve(self, websocket: WebSocket) -> None:
        """Serve one client until it goes, or is one too many."""
        if self._open >= CLIENTS:
            await _refuse(websocket, f"there are {CLIENTS} clients already, and no more are served")
            return
        if PROTOCOL not in websocket.scope["subprotocols"]:
            await _refuse(websocket, f"the subprotocol must be {PROTOCOL}")
            return
        name = websocket.scope["otolith"]["client"]
        self._open += 1
        self._session.came(name)
        try:
            await websocket.accept(subprotocol=PROTOCOL)
            loop = asyncio.get_running_loop()
            client = Client(self._session, name)
            await self._converse(websocket, client, loop)
        finally:
            self._open -= 1
            self._session.went(name)

    async def _converse(self, websocket: WebSocket, client: Client, loop: asyncio.AbstractEventLoop) -> None:
        listening = asyncio.create_task(self._listen(websocket, client, loop))
        try:
            due = loop.time()
            while not listening.done():
                await self._tell(websocket, client, loop.time())
                due = max(due + 1.0 / FRAMES, loop.time())
                await asyncio.wait([listening], timeout=due - loop.time())
            listening.result()
        except Violation as violation:
            await websocket.close(POLICY_VIOLATION, str(violation)[:120])
        except WebSocketDisconnect:
            pass
        except RuntimeError:  # starlette's word for a socket that closed meanwhile, and perhaps for more
            if WebSocketState.DISCONNECTED not in (websocket.client_state, websocket.application_state):
                raise
        finally:
            listening.cancel()

    async def _tell(self, websocket: WebSocket, client: Client, now: float) -> None:
        if client.waits(now):
            return
        for text in client.texts(now):
            await websocket.send_text(text)
        packed = client.frame(now)
        if packed is not None:
            await websocket.send_bytes(packed)

    async def _listen(self, websocket: WebSocket, client: Client, loop: asyncio.AbstractEventLoop) -> None:
        while True:
            word = client.hear(_read(await websocket.receive()), loop.time())
            if word is not None:
                try:
                    self._session.speak(client.name, word)
                except Refused as refused:
                    answer = {"kind": "refused", "word": word[:40], "sentence": refused.sentence}
                    await websocket.send_text(json.dumps(answer))


def _read(message: Mapping[str, Any]) -> dict[str, Any]:
    """Return a message of a client as JSON's object."""
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1000))
    try:
        read = json.loads(message.get("text") or "")
    except (ValueError, RecursionError):
        read = None
    if not isinstance(read, dict):
        raise Violation("a message must be an object of JSON, as text")
    return read


async def _refuse(websocket: WebSocket, sentence: str) -> None:
    await websocket.send(
        {
            "type": "websocket.http.response.start",
            "status": 503,
            "headers": [(b"content-type", b"application/json")],
        }
    )
    await websocket.send(
        {"type": "websocket.http.response.body", "body": json.dumps({"sentence": sentence}).encode()}
    )
