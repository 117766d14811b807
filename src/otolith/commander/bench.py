"""What the Commander costs, and that it costs a run nothing: real processes and real clients."""

import asyncio
import contextlib
import itertools
import json
import os
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from http.cookiejar import CookieJar
from multiprocessing import active_children
from pathlib import Path
from typing import Any, Final

import numpy as np
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed
from websockets.typing import Origin, Subprotocol

from otolith.commander.frames import PROTOCOL, unpack
from otolith.commander.keeper import Setup, keep
from otolith.commander.orders import AGAIN, Note
from otolith.commander.rows import Rows
from otolith.core.errors import OtolithError
from otolith.live.shell.memory import Channel

STOPS: Final = 100
PREPARED: Final = 5  # runs that are stopped while they are prepared
PATIENCE: Final = 300.0  # [s] for a first run, which compiles
SIGNALS: Final = 16  # of a client that is measured, as a page with four plots has


class NoAnswer(OtolithError):
    """The Commander does not do what the bench waits for."""


@contextlib.contextmanager
def running(setup: Setup) -> Iterator[None]:
    """Keep server and simulation running in the background."""
    over = threading.Event()
    keeper = threading.Thread(
        target=keep, args=(setup, lambda _: None), kwargs={"on": lambda: not over.is_set()}
    )
    keeper.start()
    try:
        yield
    finally:
        over.set()
        keeper.join()


@dataclass
class Bench:
    """Measures a Commander that runs."""

    setup: Setup
    values: dict[str, Any]  # of the run that is watched
    cookies: CookieJar = field(default_factory=CookieJar)
    csrf: str = ""

    @property
    def address(self) -> str:
        """Return the server's address."""
        return f"http://127.0.0.1:{self.setup.port}"

    def ask(self, path: str, values: Any = None) -> Any:
        """Ask the server, as a page does."""
        body = self._open(path, values)
        return json.loads(body) if body else None

    def _open(self, path: str, values: Any = None) -> bytes:
        content = None if values is None else json.dumps(values).encode()
        headers = {"X-Otolith": self.csrf, "Content-Type": "application/json"}
        request = urllib.request.Request(self.address + path, content, headers)  # noqa: S310 (our own address)
        opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(self.cookies))
        with opener.open(request, timeout=PATIENCE) as answer:
            body: bytes = answer.read()
        return body

    def begin(self) -> None:
        """Wait for the server, and become the page in control."""
        _until(self._answers, "the server does not answer")
        with Channel(self.setup.name("state")) as channel:
            _until(Note(channel).look, "the simulation does not start")
        self.csrf = self.ask("/api/start")["csrf"]

    def _answers(self) -> bool:
        token = self.setup.secrets.token
        try:
            if token is not None:
                self._open(f"/?token={token}")
            return bool(self.ask("/health")["ok"])
        except OSError:
            return False

    def process(self, name: str) -> int:
        """Return the number of a process of the Commander."""
        return next(one.pid or 0 for one in active_children() if one.name == f"otolith {name}")

    def run(self) -> None:
        """Start the run, and wait until it goes."""
        with Channel(self.setup.name("state")) as channel:
            state = Note(channel)
            self.ask("/api/run", self.values)
            _until(lambda: state.look()["running"], "the run does not begin", lambda: _failure(state))

    def stop(self) -> None:
        """Stop the run, and wait until its results are written."""
        with Channel(self.setup.name("state")) as channel:
            state = Note(channel)
            self.ask("/api/word", {"word": "stop"})
            _until(lambda: not state.look()["busy"], "the run does not stop")

    def connected(self) -> connect:
        """Return a connection to the stream."""
        cookie = "; ".join(f"{one.name}={one.value}" for one in self.cookies)
        return connect(
            self.address.replace("http", "ws") + "/stream",
            subprotocols=[Subprotocol(PROTOCOL)],
            origin=Origin(self.address),
            additional_headers={"Cookie": cookie},
            max_size=None,
        )


def cost(bench: Bench, clients: int, seconds: float, *, raw: bool = False) -> dict[str, float]:
    """Return the CPU of the server [% of one core] and what each client gets [kB/s, frames/s, age in s]."""
    bench.run()
    server = bench.process("server")
    watched = [_Watch(bench, raw=raw) for _ in range(clients)]

    async def all_of_them() -> float:
        tasks = [asyncio.create_task(one.watch(seconds + 1.0)) for one in watched]
        await asyncio.sleep(0.5)  # what a client gets first, the past, is not the stream
        before, began = _cpu(server), time.monotonic()
        for one in watched:
            one.bytes = one.frames = 0
        await asyncio.sleep(seconds)
        used = (_cpu(server) - before) / (time.monotonic() - began)
        for one in watched:
            one.measured = one.bytes, one.frames
        await asyncio.gather(*tasks)
        return used

    used = asyncio.run(all_of_them())
    bench.stop()
    return {
        "cpu_percent": 100.0 * used,
        "kB_per_s": float(np.mean([one.measured[0] for one in watched])) / 1e3 / seconds,
        "frames_per_s": float(np.mean([one.measured[1] for one in watched])) / seconds,
        "age_p99_s": float(np.percentile([age for one in watched for age in one.ages], 99)),
    }


class _Watch:
    """A page that draws what it gets."""

    def __init__(self, bench: Bench, *, raw: bool) -> None:
        self._bench, self._raw = bench, raw
        self.bytes = self.frames = 0
        self.ages: list[float] = []
        self.measured = 0, 0

    async def watch(self, seconds: float) -> None:
        """Watch for a time; a page that looks at raw samples asks for them before they end."""
        async with self._bench.connected() as line:
            end = time.monotonic() + seconds
            names = await self._names(line)
            asked = -np.inf
            while time.monotonic() < end:
                if time.monotonic() - asked > 5.0:
                    want = {"want": "raw" if self._raw else "envelope"}
                    await line.send(json.dumps(want if asked > 0.0 else want | {"columns": names}))
                    asked = time.monotonic()
                message = await line.recv()
                if isinstance(message, bytes):
                    frame = unpack(message)
                    self.bytes, self.frames = self.bytes + len(message), self.frames + 1
                    self.ages.append(frame.age)
                    await line.send(json.dumps({"ack": frame.sequence}))

    async def _names(self, line: ClientConnection) -> list[str]:
        while True:
            message = await line.recv()
            if isinstance(message, str) and (read := json.loads(message))["kind"] == "schema":
                return [column["name"] for column in read["columns"]][1:SIGNALS]


def stops(bench: Bench, count: int = STOPS) -> dict[str, float]:
    """Return how long it takes from a STOP that is sent to the word in shared memory [ms], by either way."""
    taken: dict[str, list[float]] = {"post": [], "websocket": []}

    async def all_of_them() -> None:
        async with bench.connected() as line:
            with Channel(bench.setup.name("orders")) as orders:
                for k in range(count):
                    way = ("post", "websocket")[k % 2]
                    await asyncio.sleep(2.0 * AGAIN)  # sooner, it would be the same stop
                    before, began = orders.published, time.perf_counter()
                    if way == "post":
                        saying = asyncio.create_task(
                            asyncio.to_thread(bench.ask, "/api/word", {"word": "stop"})
                        )
                    else:
                        saying = asyncio.create_task(line.send(json.dumps({"word": "stop"})))
                    while orders.published == before and time.perf_counter() - began < 1.0:
                        await asyncio.sleep(0.0002)
                    taken[way].append(1e3 * (time.perf_counter() - began))
                    await saying

    asyncio.run(all_of_them())
    return {
        f"{way}_{name}_ms": float(np.percentile(times, share))
        for way, times in taken.items()
        for name, share in (("p50", 50), ("p99", 99))
    }


def stops_of_preparing(bench: Bench, count: int) -> dict[str, float]:
    """Return how long it takes from a STOP by request until a run that is prepared has ended [ms]."""
    taken = []
    with Channel(bench.setup.name("state")) as channel:
        state = Note(channel)
        for _ in range(count):
            bench.ask("/api/run", bench.values)
            _until(lambda: state.look()["state"] == "preparing", "nothing is prepared", every=0.001)
            began = time.perf_counter()
            bench.ask("/api/word", {"word": "stop"})
            _until(lambda: state.look()["state"] != "preparing", "it goes on", every=0.001)
            taken.append(1e3 * (time.perf_counter() - began))
            _until(lambda: not state.look()["busy"], "the run does not stop")
            _until(lambda: state.look()["state"] in ("idle", "done", "stopped"), "no simulation comes back")
    return {"median_ms": float(np.median(taken)), "most_ms": max(taken), "count": count}


def disturbance(bench: Bench, seconds: float, rounds: int) -> dict[str, Any]:
    """Return times of decisions [µs] without a client and with five, one flooding and one asleep, in turns.

    Each figure is that of the run's own record. `lost` is the number of rows that are missing in the ring,
    and `late` how often the run was more than 50 ms behind real time.
    """
    found: dict[str, list[dict[str, float]]] = {"alone": [], "watched": []}
    for _, (name, times) in itertools.product(range(rounds), found.items()):
        bench.run()
        with Rows(bench.setup.name("rows")) as rows, Channel(bench.setup.name("state")) as channel:
            asyncio.run(_crowd(bench, seconds) if name == "watched" else asyncio.sleep(seconds))
            state = Note(channel)
            bench.stop()
            ended, written = state.look(), rows.written
        summary = bench.ask("/api/result")["summary"]
        lost = round(1e3 * ended["time"]) - written
        times.append({**summary["step_time_us"], "lost": lost, "late": ended["lamps"]["missed"]})
    return {
        name: {key: float(np.median([one[key] for one in times])) for key in ("mean", "median", "p99", "max")}
        | {key: int(sum(one[key] for one in times)) for key in ("lost", "late")}
        for name, times in found.items()
    }


async def _crowd(bench: Bench, seconds: float) -> None:
    """Be three pages that draw, one that sleeps, and one that floods and comes back."""
    awake = [_Watch(bench, raw=False).watch(seconds) for _ in range(3)]
    await asyncio.gather(*awake, _sleep(bench, seconds), _flood(bench, seconds))


async def _sleep(bench: Bench, seconds: float) -> None:
    async with bench.connected():
        await asyncio.sleep(seconds)


async def _flood(bench: Bench, seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        with contextlib.suppress(ConnectionClosed):
            async with bench.connected() as line:
                for k in itertools.count():
                    if time.monotonic() > end:
                        break
                    await line.send(json.dumps({"ack": 0} if k % 2 else {"word": "resume"}))


def memory(process: int) -> float:
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f"/proc/{process}/statm").read_text(encoding="utf-8").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def _cpu(process: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(") ")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _failure(state: Note) -> str:
    found = state.look()
    return str(found["text"]) if found["state"] == "failed" else ""


def _until(
    what: Callable[[], Any], otherwise: str, failure: Callable[[], str] = lambda: "", every: float = 0.05
) -> None:
    end = time.monotonic() + PATIENCE
    while not what():
        if time.monotonic() > end or failure():
            raise NoAnswer(failure() or f"{otherwise} within {PATIENCE:g} s")
        time.sleep(every)


def table(measured: dict[str, Any]) -> Sequence[tuple[str, str, str]]:
    """Return lines of what was measured: what, figure, goal."""
    one, five, raw = (measured[name] for name in ("one", "five", "raw"))
    stop, step = measured["stop"], measured["step"]
    return [
        ("server CPU, one client, of one core", f"{one['cpu_percent']:.1f} %", "4 %"),
        ("server CPU, five clients", f"{five['cpu_percent']:.1f} %", "10 %"),
        ("envelope, per client", f"{one['kB_per_s']:.1f} kB/s", "20 kB/s"),
        ("raw, per client", f"{raw['kB_per_s']:.1f} kB/s", "80 kB/s"),
        (
            "frames, one client / each of five",
            f"{one['frames_per_s']:.1f} / {five['frames_per_s']:.1f} per s",
            "30",
        ),
        ("age of the newest sample, p99", f"{1e3 * five['age_p99_s']:.0f} ms", ""),
        *(
            (
                f"STOP to shared memory, {way}, p50 / p99",
                f"{stop[f'{way}_p50_ms']:.1f} / {stop[f'{way}_p99_ms']:.1f} ms",
                "p99 50 ms",
            )
            for way in ("post", "websocket")
        ),
        (
            "STOP of a run that is prepared, median / most",
            f"{measured['preparing']['median_ms']:.0f} / {measured['preparing']['most_ms']:.0f} ms",
            "",
        ),
        ("decision, no client", _decision(step["alone"]), ""),
        ("decision, five clients: one floods, one sleeps", _decision(step["watched"]), "equal"),
        (
            "server memory, start / end",
            f"{measured['rss_mb'][0]:.0f} / {measured['rss_mb'][1]:.0f} MB",
            "flat",
        ),
    ]


def _decision(of: dict[str, Any]) -> str:
    times = f"median {of['median']:.1f}, p99 {of['p99']:.1f} µs"
    return f"{times}; {of['lost']} rows lost, {of['late']} times late"


def measure(setup: Setup, values: dict[str, Any], *, seconds: float, rounds: int) -> dict[str, Any]:
    """Measure everything; see `table`."""
    bench = Bench(setup, values)
    with running(setup):
        bench.begin()
        bench.run()  # compiles
        bench.stop()
        before = memory(bench.process("server"))
        measured: dict[str, Any] = {
            "one": cost(bench, 1, seconds),
            "five": cost(bench, 5, seconds),
            "raw": cost(bench, 1, min(seconds, 8.0), raw=True),
            "stop": stops(bench),
            "preparing": stops_of_preparing(bench, PREPARED),
            "step": disturbance(bench, seconds, rounds),
        }
        return measured | {"rss_mb": [before, memory(bench.process("server"))], "load": os.getloadavg()[0]}
