"""How long a STOP takes in a live session: from a page to the first set-point of the way back."""

import asyncio
import contextlib
import json
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Final

import numpy as np

from otolith.commander.bench import Bench, NoAnswer
from otolith.commander.feed import parameters_of
from otolith.commander.keeper import Setup
from otolith.commander.watched import watched
from otolith.live.messages import State, Word
from otolith.live.packed import unpack_report
from otolith.live.session import Session
from otolith.live.shell.memory import Channel
from otolith.live.shell.supervise import Live, only_session

LOOK: Final = 0.02  # [s] between two looks of the supervisor, as in `otolith live run`
MOVES: Final = 0.3  # [s] of cueing before a STOP
PATIENCE: Final = 60.0  # [s]
WAYS: Final = ("post", "websocket")


def live_stops(session: Session, setup: Callable[..., Setup], count: int) -> dict[str, Any]:
    """Return times from STOP to the order in shared memory, and to the way back of set-points [ms].

    Parameters
    ----------
    setup : makes the setup of the pages; it is given what else a live session's has.
    count : of STOPs, half of them by request and half by websocket.
    """
    made = setup(parameters=parameters_of(session))
    bench = Bench(made, {})
    with _supervised(session, made) as live, Channel(live.names["reports"]) as reports:
        bench.begin()
        seen = _Seen(reports)
        seen.say(bench, "arm", State.READY)
        taken = asyncio.run(_all_stops(bench, seen, count))
    return {"count": count} | {
        f"{way}_{what}_{name}_ms": float(np.percentile(times, share))
        for (way, what), times in taken.items()
        for name, share in (("p50", 50), ("p99", 99))
    }


@contextlib.contextmanager
def _supervised(session: Session, setup: Setup) -> Iterator[Live]:
    """Run a session with pages, supervised as by `otolith live run`."""
    over = threading.Event()
    with only_session(session.device) as lock, contextlib.ExitStack() as stack:
        live = Live(session, lambda _: None, lock=lock)
        pages = stack.enter_context(watched(setup, session, live.names, live.change))

        def supervise() -> None:
            while not over.wait(LOOK):
                live.look()
                if words := pages.words(lambda _: None):
                    live.say(*words)

        supervisor = threading.Thread(target=supervise)
        try:
            live.start()
            supervisor.start()
            yield live
        finally:
            over.set()
            supervisor.join() if supervisor.ident else None
            live.end()


class _Seen:
    """What the output reports, as it comes."""

    def __init__(self, reports: Channel) -> None:
        self._reports = reports

    def when(self, state: State) -> int:
        """Wait for a state, and return the time of its first report [ns]; one may be missed before it."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            message = self._reports.read()
            if message is not None and (report := unpack_report(message)).state is state:
                return report.time_ns
            time.sleep(0.0002)
        raise NoAnswer(f"the session is not {state} within {PATIENCE:g} s")

    def say(self, bench: Bench, word: str, state: State) -> None:
        """Say a word by request, and wait for what it brings about."""
        bench.ask("/api/word", {"word": word})
        self.when(state)


async def _all_stops(bench: Bench, seen: _Seen, count: int) -> dict[tuple[str, str], list[float]]:
    taken: dict[tuple[str, str], list[float]] = {
        (way, what): [] for way in WAYS for what in ("order", "return")
    }
    async with bench.connected() as line:
        with Channel(bench.setup.name("orders")) as orders:
            for k in range(count):
                way = WAYS[k % 2]
                await asyncio.to_thread(seen.say, bench, "engage", State.ENGAGED)
                await asyncio.sleep(MOVES)
                back = asyncio.create_task(asyncio.to_thread(seen.when, State.RETURNING))
                before, began = orders.published, time.monotonic_ns()
                if way == "post":
                    saying = asyncio.create_task(asyncio.to_thread(bench.ask, "/api/word", {"word": "stop"}))
                else:
                    saying = asyncio.create_task(line.send(json.dumps({"word": "stop"})))
                while orders.published == before and not back.done():
                    await asyncio.sleep(0.0002)
                taken[way, "order"].append(1e-6 * (time.monotonic_ns() - began))
                taken[way, "return"].append(1e-6 * (await back - began))
                await saying
                await asyncio.to_thread(seen.when, State.READY)
                await asyncio.to_thread(bench.ask, "/api/word", {"word": Word.REARM.value})
                await asyncio.sleep(3.0 * LOOK)
    return taken


def live_table(measured: dict[str, Any]) -> Sequence[tuple[str, str, str]]:
    """Return lines of what was measured: what, figure, goal."""
    words = {"order": "to shared memory", "return": "to the first set-point of the way back"}
    return [
        (
            f"live: STOP {text}, {way}, p50 / p99",
            f"{measured[f'{way}_{what}_p50_ms']:.1f} / {measured[f'{way}_{what}_p99_ms']:.1f} ms",
            "p99 50 ms" if what == "order" else "",
        )
        for what, text in words.items()
        for way in WAYS
    ]
