"""A server that answers as the Commander's does, with signals in closed form and faults on demand.

The page's own duties (gaps, staleness, reconnecting, acknowledging) are tested against it, because a real run
does not fail when a test wants it to.
"""

import asyncio
import json
import math
import re
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np
import uvicorn
from fastapi import FastAPI, Request, Response, WebSocket, WebSocketDisconnect
from fastapi.responses import JSONResponse

import otolith
from otolith.commander.app import page_file
from otolith.commander.columns import described
from otolith.commander.frames import ENVELOPE, PROTOCOL, Frame
from otolith.commander.schema import Form, live_schema, schema
from otolith.platforms import load

WEB: Final = Path(otolith.__file__).parent / "commander" / "web"
PERIOD: Final = 1.0 / 30.0  # [s] between frames
BUCKET: Final = 0.005  # [s] of the envelope


PLATFORM: Final = load("davsi")
COLUMNS: Final = described(PLATFORM)
HEXAPOD: Final = PLATFORM.six_legs()
VALUES: Final = Form().model_dump()
MOVES: Final = r"(wanted|felt|pose)_x|(pose|tilt_rate)_pitch|leg_.|step_us|changes|residual"
MOVING: Final = [column["name"] for column in COLUMNS if re.fullmatch(MOVES, column["name"])]
PARAMETERS: Final = {"scale": 1.0, "liveliness": 0.5}  # of a live session


def signals(time: np.ndarray) -> np.ndarray:
    """Return all columns (n, columns) at times [s]; 4 s to 5 s is a gap."""
    rows = np.full((len(time), len(COLUMNS)), np.nan)
    at = {column["name"]: k for k, column in enumerate(COLUMNS)}
    pose = np.zeros((len(time), 6))
    pose[:, 0], pose[:, 4] = 0.2 * np.sin(time), 0.1 * np.sin(0.7 * time)
    rows[:, 0] = time
    rows[:, at["wanted_x"]], rows[:, at["felt_x"]] = np.sin(time), 0.9 * np.sin(time - 0.2)
    for k, name in enumerate(("x", "y", "z", "roll", "pitch", "yaw")):
        rows[:, at[f"pose_{name}"]] = pose[:, k] if k < 3 else np.degrees(pose[:, k])
    rows[:, at["tilt_rate_pitch"]] = np.degrees(0.07 * np.cos(0.7 * time))
    rows[:, at["leg_1"] : at["leg_6"] + 1] = [HEXAPOD.lengths(one) for one in pose]
    rows[:, at["step_us"]], rows[:, at["changes"]] = 40.0 + 30.0 * np.sin(5.0 * time) ** 2, 2.0
    rows[:, at["residual"]] = 1e-9
    rows[(time >= 4.0) & (time < 5.0), 1:] = np.nan
    return rows


class Fake:
    """What the server knows, and the faults that a test asks for."""

    def __init__(self) -> None:
        self.generation, self.time, self.running, self.state = 0, 0.0, False, "idle"
        self.mode = "offline"
        self.silent = False  # frames stop, the line stays open
        self.deaf = False  # requests are answered with 503, and words of the line are lost
        self.words: list[str] = []
        self.acknowledged = 0
        self.sockets: set[WebSocket] = set()
        self.chosen: dict[WebSocket, list[int]] = {}  # columns that a page asked for, until it has the schema
        self.asked: list[list[str]] = []  # for
        self.changes: list[dict[str, Any]] = []
        self.lamps: dict[str, Any] = {}  # that differ
        self.parameters: dict[str, float] = {}  # of a live session

    def schema(self, chosen: Sequence[int] = range(len(COLUMNS))) -> dict[str, Any]:
        values = {"values": {"dofs": "surge-pitch"}} if self.mode == "live" else {}
        columns = [COLUMNS[k] for k in chosen]
        said = {"kind": "schema", "generation": self.generation, "t0": 0.0, "rate": 400}
        return said | values | {"columns": columns, "offered": COLUMNS}

    def status(self) -> dict[str, Any]:
        lamps = {"telemetry_age_s": None, "missed": 0, "gate_refused": 0, "log": None, "clock": 0.0}
        live = {"parameters": self.parameters, "busy": True} if self.mode == "live" else {}
        return live | {
            "kind": "state",
            "state": self.state,
            "text": "",
            "time": self.time,
            "running": self.running,
            "lamps": lamps | self.lamps,
            "control": True,
            "moving": MOVING if self.time else [],
            "generation": self.generation,
            "forbids": "the axes are not tested",
            "words": ["return", "stop"] if self.running else ["arm", "stop"],
        }

    async def tell(self, message: dict[str, Any]) -> None:
        for socket in list(self.sockets):
            with suppress(RuntimeError, WebSocketDisconnect):
                await socket.send_text(json.dumps(message))

    async def event(self, level: str, text: str) -> None:
        await self.tell(
            {
                "kind": "event",
                "time": self.time,
                "level": level,
                "text": text,
                "generation": self.generation,
            }
        )

    async def set(self, state: str, *, running: bool) -> None:
        self.state, self.running = state, running
        await self.tell(self.status())

    async def clock(self) -> None:
        """Let time pass while something runs."""
        while True:
            await asyncio.sleep(PERIOD)
            if self.running and self.state == "running":
                self.time += PERIOD


fake = Fake()
app = FastAPI()


@app.middleware("http")
async def headers(request: Request, call_next: Any) -> Response:
    if (
        request.method != "GET"
        and request.headers.get("x-otolith") != "token"
        and request.url.path != "/fault"
    ):
        return JSONResponse({"sentence": "the request lacks its key"}, 403)
    if fake.deaf and request.url.path == "/api/word":
        return JSONResponse({"sentence": "the server is ill"}, 503)
    response = await call_next(request)
    response.headers["Content-Security-Policy"] = "default-src 'self'; frame-ancestors 'none'"
    return response


@app.get("/")
async def index(request: Request) -> Response:
    return page_file("index.html", request)


@app.get("/web/{name}")
async def file(name: str, request: Request) -> Response:
    return page_file(name, request)


@app.get("/health")
async def health() -> dict[str, Any]:
    return {"ok": True, "version": "0"}


@app.get("/api/start")
async def start() -> dict[str, Any]:
    def names(*pairs: tuple[str, str]) -> list[dict[str, str]]:
        return [{"name": name, "text": text} for name, text in pairs]

    return {
        "csrf": "token",
        "version": "0",
        "mode": fake.mode,
        "values": VALUES if fake.mode == "offline" else PARAMETERS,
        "schema": schema() if fake.mode == "offline" else live_schema(PARAMETERS),
        "presets": [{"name": "calm", "values": VALUES | {"liveliness": 0.2}}],
        "choices": {
            "scenarios": names(
                ("step-sine-1", "step 1 m/s², then sine from 10 s on, 20 s"),
                ("stop", "braking from 86 km/h"),
                ("sine:…", "a sine; amplitude=1.0,frequency=0.1,duration=10.0,start=1.0"),
            ),
            "platforms": names(
                ("davsi", "Delft Advanced Vehicle Simulator, a hexapod"), ("thesis", "limits of the thesis")
            ),
            "cueing": names(("predictive", "implicit MPC that foresees"), ("classical", "washout")),
            "plants": names(("ideal", "follows exactly")),
            "logs": ["drive.csv"],
        },
    }


@app.post("/api/check")
async def check(values: dict[str, Any]) -> dict[str, Any]:
    good = values["scenario"] != "nothing"
    sentence = "" if good else "no scenario is called nothing; there are step-sine-1, stop"
    return {
        "checks": [
            {"name": "scenario", "ok": good, "sentence": sentence},
            {"name": "platform", "ok": True, "sentence": "reach ±0.50 m"},
        ],
        "command": f"otolith run {values['scenario']} --cueing {values['cueing']}",
    }


@app.post("/api/run", status_code=202)
async def run() -> dict[str, Any]:
    fake.generation, fake.time = fake.generation + 1, 0.0
    await fake.tell(fake.schema())
    await fake.set("running", running=True)
    await fake.event("info", "the run begins")
    return {"generation": fake.generation}


@app.post("/api/word", status_code=204)
async def word(body: dict[str, str]) -> None:
    fake.words.append(body["word"])
    if body["word"] == "stop" and fake.running:
        await fake.set("stopped", running=False)
        await fake.event("warn", "stopped by this page")
    if body["word"] in {"pause", "resume"}:
        await fake.set("paused" if body["word"] == "pause" else "running", running=True)


@app.post("/api/parameters")
async def parameters(values: dict[str, Any]) -> Any:
    if not 0 <= values.get("liveliness", 0.0) <= 1:
        return JSONResponse(
            {"field": "liveliness", "sentence": "liveliness is 7; must be between 0 and 1"}, 422
        )
    fake.changes.append(values)
    fake.parameters = fake.parameters | values
    await fake.event("parameter", ", ".join(f"{name} {value}" for name, value in values.items()))
    return {"at": fake.time, "applied": values}


@app.get("/api/presets")
async def presets() -> list[dict[str, Any]]:
    return [{"name": "calm", "values": VALUES | {"liveliness": 0.2}}]


@app.get("/api/result")
async def result() -> Any:
    return JSONResponse({"sentence": "no run has ended"}, 404)


@app.get("/api/runs")
async def runs() -> dict[str, Any]:
    """Three runs, of which the first two came about together."""
    made = [("b", 2000.0, "classical", 0.5), ("b", 2000.0, "optimal", 0.7), ("a", 1000.0, "predictive", 0.3)]
    return {
        "runs": [
            {
                "folder": folder,
                "time": time,
                "files": ["report.html"],
                "scenario": "step-1",
                "platform": "davsi",
                "cueing": cueing,
                "summary": {"rmse": rmse, "violations": 0},
            }
            for folder, time, cueing, rmse in made
        ],
        "refused": ["c: its summary.json is none of a run (ValueError)"],
        "left_out": 0,
    }


@app.get("/api/hexapod")
async def hexapod() -> dict[str, Any]:
    return {
        "base": HEXAPOD.anchors.tolist(),
        "platform": HEXAPOD.joints.tolist(),
        "stroke": list(HEXAPOD.stroke),
        "neutral": HEXAPOD.lengths(np.zeros(6)).tolist(),
    }


@app.get("/api/map")
async def lap() -> None:
    return None


@app.post("/fault")
async def fault(body: dict[str, Any]) -> dict[str, Any]:
    """Do what a test asks for, and return what was seen."""
    if body.get("reset"):
        fake.silent, fake.deaf, fake.mode = False, False, body.get("mode", "offline")
        fake.words, fake.changes, fake.acknowledged, fake.lamps, fake.asked = [], [], 0, {}, []
        fake.parameters = dict(PARAMETERS)
        await fake.set("idle", running=False)
    fake.silent, fake.deaf = body.get("silent", fake.silent), body.get("deaf", fake.deaf)
    fake.lamps = body.get("lamps", fake.lamps)
    fake.parameters = body.get("parameters", fake.parameters)
    if "time" in body:
        fake.time = body["time"]
    if body.get("begin"):
        await run()
    if body.get("close"):
        for socket in list(fake.sockets):
            await socket.close()
    if "event" in body:
        await fake.event("info", body["event"])
    return {
        "words": fake.words,
        "acknowledged": fake.acknowledged,
        "time": fake.time,
        "clients": len(fake.sockets),
        "changes": fake.changes,
        "asked": fake.asked,
    }


def frame(sequence: int, first: float, last: float, chosen: Sequence[int]) -> bytes:
    """Return the envelope of chosen signals between two times as the message of a frame."""
    count = max(0, math.floor((last - first) / BUCKET))
    time = first + BUCKET * np.arange(count)
    rows = np.repeat(signals(time)[:, list(chosen)], 2, axis=0)
    return Frame(kind=ENVELOPE, sequence=sequence, t0=first, age=0.01, decimation=5, rows=rows).pack()


async def listen(socket: WebSocket) -> None:
    while True:
        message = json.loads(await socket.receive_text())
        if "ack" in message:
            fake.acknowledged += 1
        if "columns" in message:
            names = [column["name"] for column in COLUMNS]
            fake.asked.append(message["columns"])
            fake.chosen[socket] = [names.index(name) for name in message["columns"]]
        if "word" in message and not fake.deaf:
            await word(message)


async def send(socket: WebSocket) -> None:
    sequence, sent, generation = 0, 0.0, fake.generation
    chosen: Sequence[int] = range(len(COLUMNS))
    while True:
        await asyncio.sleep(PERIOD)
        if socket in fake.chosen:
            chosen, sent = fake.chosen.pop(socket), 0.0
            await socket.send_text(json.dumps(fake.schema(chosen)))
        if generation != fake.generation:
            sent, generation, chosen = 0.0, fake.generation, range(len(COLUMNS))
        if fake.running and not fake.silent and fake.time > sent:
            sequence += 1
            await socket.send_bytes(frame(sequence, sent, fake.time, chosen))
            sent += BUCKET * math.floor((fake.time - sent) / BUCKET)
        if sequence % 10 == 0:
            await socket.send_text(json.dumps(fake.status()))


@app.websocket("/stream")
async def stream(socket: WebSocket) -> None:
    await socket.accept(subprotocol=PROTOCOL)
    await socket.send_text(json.dumps(fake.schema()))
    await socket.send_text(json.dumps(fake.status()))
    fake.sockets.add(socket)
    tasks = [asyncio.create_task(one(socket)) for one in (listen, send)]
    await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    fake.sockets.discard(socket)
    for task in tasks:
        task.cancel()
        with suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
            await task


async def serve(port: int) -> None:
    """Serve until the process is ended."""
    server = uvicorn.Server(
        uvicorn.Config(app, host="127.0.0.1", port=port, log_level="warning", ws="websockets-sansio")
    )
    clock = asyncio.create_task(fake.clock())
    await server.serve()
    clock.cancel()


if __name__ == "__main__":
    asyncio.run(serve(int(sys.argv[1])))
