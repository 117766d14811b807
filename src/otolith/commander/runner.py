"""The worker: it simulates what it is ordered to, in step with real time, and says what it does.

It is a process of its own, and it outlives the server. Rows go to the ring in shared memory, 1 kHz. Between
two periods it looks for orders, so a stop or a changed parameter takes effect at the next decision. A
compiler cannot be interrupted: a stop while a run is prepared ends this process, and its keeper starts
another.
"""

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from otolith.commander.columns import described, rows_of
from otolith.commander.job import Job, Maker
from otolith.commander.orders import Inbox, Note, Order
from otolith.commander.pace import Pace
from otolith.commander.rows import Rows
from otolith.commander.session import RESULTS
from otolith.core.errors import OtolithError

IDLE: Final = 0.02  # [s] between looks for orders while nothing runs
TOLD: Final = 0.1  # [s] between two notes of the state while it runs
STRETCH: Final = 0.25  # [s] of a run that is computed between two looks for orders, at most
EVENTS: Final = 100  # that are kept


class Worker:
    """Carries out orders; the loop that calls it is `run_worker`.

    Parameters
    ----------
    make : makes a job of a form's values.
    leave : ends this process at once, from any thread.
    """

    def __init__(
        self,
        rows: Rows,
        notes: tuple[Note, Note],
        inbox: Inbox,
        *,
        make: Maker,
        folder: Path,
        leave: Callable[[], None] = lambda: os._exit(0),
    ) -> None:
        state, card = notes
        self._rows, self._state, self._card, self._inbox = rows, state, card, inbox
        self._make, self._folder, self._leave = make, folder, leave
        self._waiting: list[Order] = []  # orders that came while a run was prepared
        before = state.look()
        self._generation, self._number = int(before.get("generation", 0)), 0
        self._events: list[dict[str, Any]] = list(before.get("events", []))
        self._number = self._events[-1]["number"] if self._events else 0
        self._job: Job | None = None
        self._pace, self._values = Pace(1.0), dict[str, Any]()
        self._changes: list[dict[str, Any]] = []
        self._time, self._fallbacks = 0.0, 0
        if before.get("busy"):
            self.tell("fault", "the simulation ended unexpectedly; its rows until then are shown")
            self.say("failed", "the simulation ended unexpectedly")
        else:
            self.say("idle", "ready for a run")

    def tell(self, level: str, text: str) -> None:
        """Note an event; the next note of the state carries it."""
        self._number += 1
        event = {
            "number": self._number,
            "time": round(self._time, 3),
            "level": level,
            "text": text[:300],
            "generation": self._generation,
        }
        self._events = [*self._events[1 - EVENTS :], event]

    def say(self, state: str, text: str) -> None:
        """Note the state, and all that belongs to it."""
        self._said = state, text
        self._state.state(
            {
                "state": state,
                "text": text,
                "time": round(self._time, 3),
                "running": state == "running",
                "busy": state in ("preparing", "running", "paused", "writing"),
                "generation": self._generation,
                "speed": self._pace.speed,
                "lamps": {
                    "telemetry_age_s": None,
                    "missed": self._pace.missed,
                    "gate_refused": self._fallbacks,
                    "log": None,  # a simulation keeps none
                    "clock": round(self._pace.behind, 3),
                },
                "reached": self._inbox.reached,
                "events": self._events,
            }
        )
        self._said_at = time.monotonic()

    def look(self) -> float:
        """Carry out new orders and advance the run; return how long to sleep [s]."""
        waiting, self._waiting = self._waiting, []
        orders = [*waiting, *self._inbox.new()]
        for order in orders:
            self._carry_out(order)
        if self._job is None or self._said[0] != "running":
            if orders:
                self.say(*self._said)
            return IDLE
        return self._advance(self._job)

    def _carry_out(self, order: Order) -> None:
        if order.word == "run":
            self._begin(order.values)
        elif self._job is None and order.word == "stop":
            pass  # pages say it twice, by websocket and by POST, so that it arrives
        elif self._job is None:
            self.tell("warn", f"{order.word}: nothing runs")
        elif order.word == "change":
            self._change(order.values)
        elif order.word == "stop":
            self._changes.append({"at": self._time, "stopped": True})
            self.tell("warn", "stopped by hand")
            self._end("stopped", "stopped by hand")
        elif order.word == "pause" and self._said[0] == "running":
            self.tell("info", "paused")
            self.say("paused", "paused")
        elif order.word == "resume" and self._said[0] == "paused":
            self._pace.begin(self._time)
            self.tell("info", "resumed")
            self.say("running", "running")

    def _begin(self, values: Mapping[str, Any]) -> None:
        """Prepare a run; what is not compiled yet takes a while."""
        if self._job is not None:
            self.tell("warn", "run: one is going on")
            return
        self._generation += 1
        self._time, self._fallbacks, self._changes = 0.0, 0, []
        self._pace, self._values = Pace(float(values["speed"])), dict(values)
        self.say("preparing", "preparing; what is not compiled yet takes up to a minute")
        try:
            name = f"{time.strftime('%Y%m%d-%H%M%S')}-{self._generation}"
            with self._stoppable():
                job = self._make(values, lambda text: self.tell("info", text), name)
        except OtolithError as error:
            self.tell("fault", str(error))
            self.say("failed", str(error))
            return
        self._rows.begin(self._generation)
        self._job = job
        self._show(job, {"summary": None})
        self.tell("info", "running")
        self._pace.begin(0.0)
        self.say("running", "running")

    @contextlib.contextmanager
    def _stoppable(self) -> Iterator[None]:
        """Look for a stop beside what this thread does; there is nothing yet that a stop could lose."""
        over = threading.Event()

        def watch() -> None:
            while not over.wait(IDLE):
                for order in self._inbox.new():
                    self._waiting.append(order)
                    if order.word == "stop":
                        self._inbox.reached = order.number  # what came after it is for the next process
                        self.tell("warn", "stopped by hand while it was prepared")
                        self.say("stopped", "stopped by hand while it was prepared")
                        self._leave()

        watching = threading.Thread(target=watch, daemon=True)
        watching.start()
        try:
            yield
        finally:
            over.set()
            watching.join()

    def _show(self, job: Job, results: Mapping[str, Any]) -> None:
        """State what is known of the run as a whole."""
        self._card.state(
            {
                "generation": self._generation,
                "columns": described(job.loops[0].platform),
                "values": self._values,
                "command": job.command,
                "duration": job.loops[0].scenario.duration,
                "hexapod": job.hexapod,
                "map": job.map,
                "folder": job.folder.name,
                **results,
            }
        )

    def _change(self, values: Mapping[str, float]) -> None:
        job = self._job
        assert job is not None  # noqa: S101 (the caller has looked)
        for name, value in values.items():
            before = self._values[name]
            if name == "speed":
                self._pace.speed = value
                self._pace.begin(self._time)
            else:
                try:
                    job.change(name, value)
                except OtolithError as error:
                    self.tell("warn", str(error))
                    continue
                self._changes.append({"at": self._time, name: value})
            self._values[name] = value
            self.tell("parameter", f"{name}: {before:g} → {value:g}")
        self.say(*self._said)

    def _advance(self, job: Job) -> float:
        """Run to where real time is, at most a stretch; return how long to sleep [s]."""
        first = job.loops[0]
        until = min(self._pace.due(), self._time + STRETCH, first.decisions * first.period)
        last = [int(until / loop.period + 1e-6) for loop in job.loops]
        begun = [loop.done for loop in job.loops]
        if last[0] > begun[0]:
            for loop, decisions in zip(job.loops, last, strict=True):
                loop.advance(decisions)
            self._write(job, begun)
        ended = first.done >= first.decisions
        if ended:
            self._end("done", "done")
        elif time.monotonic() - self._said_at > TOLD:
            self.say("running", "running")
        return 0.0 if ended else self._pace.wait(self._time + first.period)

    def _write(self, job: Job, begun: list[int]) -> None:
        stretches = [loop.run(first) for loop, first in zip(job.loops, begun, strict=True)]
        self._fallbacks += sum(status != "decided" for status in stretches[0].status)
        self._rows.write(rows_of(job.loops[0], stretches[0], stretches[1] if stretches[1:] else None))
        self._time = job.loops[0].done * job.loops[0].period
        self._pace.reached(self._time)

    def _end(self, state: str, text: str) -> None:
        """Write the results."""
        job, self._job = self._job, None
        assert job is not None  # noqa: S101 (only a run ends)
        self.say("writing", "writing the results")
        try:
            results = job.finish(self._changes) if job.loops[0].done else {"summary": None}
        except OtolithError as error:
            self.tell("fault", str(error))
            self.say("failed", str(error))
            return
        self._show(job, results)
        written = results["summary"] is not None
        self.tell("info", f"{text}; results are written" if written else f"{text} before the first decision")
        self.say(state, text)


def run_worker(
    rows: Rows, notes: tuple[Note, Note], inbox: Inbox, *, make: Maker, folder: Path, on: Callable[[], bool]
) -> None:
    """Look for orders and advance the run while `on` returns True."""
    (folder / RESULTS).mkdir(parents=True, exist_ok=True)
    worker = Worker(rows, notes, inbox, make=make, folder=folder)
    while on():
        time.sleep(worker.look())
