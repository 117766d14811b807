"""A live session as the page sees it: the same rows, state and events as of a simulation.

A process of normal priority reads what controller and output publish in shared memory, 500 times a second,
and writes the Commander's rows. It writes nothing that they read, and nobody waits for it. Words do not pass
through it: the supervisor reads them itself (`otolith.commander.watched`).
"""

import contextlib
import time
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from otolith.commander.columns import COUNT, described, hexapod_of
from otolith.commander.keeper import Setup, begin_child
from otolith.commander.lamps import Lamps
from otolith.commander.orders import Note
from otolith.commander.rows import Rows
from otolith.core.arrays import Mat, Singles, Vec
from otolith.core.frames import specific_force
from otolith.live.messages import Plan, Report, State, Vitals, Word
from otolith.live.packed import unpack_plan, unpack_report, unpack_vitals
from otolith.live.session import Session
from otolith.live.shell.memory import Channel
from otolith.live.shell.recorder import STREAMS, ring_of
from otolith.platforms import Platform

LOOK: Final = 0.002  # [s]
WRITE: Final = 0.01  # [s] between two pieces of rows
TOLD: Final = 0.1  # [s] between two notes of the state
HOLE: Final = 0.05  # [s] without a report that is a gap
SILENT: Final = 0.5  # [s] without a report after which nothing runs
ENDED: Final = 0.1  # [s] after which a decision's force is no more what is asked for
STARTING: Final = "starting; what is not compiled yet takes up to a minute"
# The words that a state accepts, beside stop.
WORDS: Final[Mapping[State, tuple[Word, ...]]] = {
    State.IDLE: (Word.ARM,),
    State.PARKED: (Word.ARM,),
    State.ENGAGING: (Word.PARK,),
    State.READY: (Word.ENGAGE, Word.PARK),
    State.ENGAGED: (Word.RETURN, Word.PARK),
    State.HOLDING: (Word.RETURN, Word.PARK),
    State.RETURNING: (Word.PARK,),
    State.FAULT: (Word.REARM,),
}


class Feed:
    """Makes rows and the state of what is published; it knows no memory and no clock.

    Parameters
    ----------
    began_ns : [ns] time 0 of the page.
    generation : of its rows; a feed that follows a dead one has another.
    offered : names of the parameters that may change while the session runs.
    forbids : why the platform must not be armed; empty if it may be.
    """

    def __init__(
        self,
        platform: Platform,
        began_ns: int,
        generation: int = 1,
        *,
        lamps: Lamps | None = None,
        offered: Sequence[str] = (),
        forbids: str = "",
    ) -> None:
        self._generation, self._offered, self._forbids = generation, offered, forbids
        self._lamps = Lamps() if lamps is None else lamps
        self._legs = None if platform.hexapod is None else platform.six_legs()
        self._began = began_ns
        self._rows: list[Vec] = []
        self._vitals: Vitals | None = None
        self._plan: Plan | None = None
        self._report: Report | None = None
        self._shown: State | None = None

    def seconds(self, time_ns: int) -> float:
        """Return a time as the page has it [s]."""
        return 1e-9 * (time_ns - self._began)

    def vitals(self, vitals: Vitals) -> None:
        """Take what the controller shows: what the last decision should let feel, and its counts."""
        self._vitals = vitals
        self._lamps.vitals(vitals)

    def plan(self, plan: Plan) -> None:
        """Take a plan."""
        self._plan = plan
        self._lamps.plan(plan)

    def report(self, report: Report) -> None:
        """Take a report: a row, after a gap where others are missing before it."""
        before, self._report = self._report, report
        now = self.seconds(report.time_ns)
        if before is not None and report.time_ns - before.time_ns > 1e9 * HOLE:
            self._rows.append(np.array([now, *[np.nan] * (COUNT - 1)]))
        vitals = self._vitals
        fresh = vitals is not None and report.time_ns - vitals.time_ns < 1e9 * ENDED
        asked = vitals.asked if vitals is not None and fresh else np.full(3, np.nan)
        self._rows.append(self._row(now, report.motion, asked))

    def _row(self, now: float, motion: Mat, asked: Vec) -> Vec:
        pose, twist, acceleration = motion
        felt = specific_force(acceleration[:3], pose[3:])
        legs = np.full(6, np.nan) if self._legs is None else self._legs.drives.size * self._legs.lengths(pose)
        residual = np.nan if self._plan is None else self._plan.residual
        return np.concatenate(
            [
                [now],
                np.column_stack([asked, felt]).ravel(),
                pose[:3],
                np.degrees(pose[3:]),
                np.degrees(twist[[4, 3]]),
                legs,
                [np.nan, np.nan, residual, np.nan, np.nan, np.nan],
            ]
        )

    def changed(self) -> bool:
        """Return whether the session's state is another than at the last call."""
        before, self._shown = self._shown, None if self._report is None else self._report.state
        return before is not self._shown

    def rows(self) -> Singles:
        """Return the rows since the last call."""
        rows, self._rows = self._rows, []
        return np.array(rows, dtype=np.float32)

    def state(self, now_ns: int, events: Sequence[Mapping[str, Any]] = ()) -> dict[str, Any]:
        """Return the state as the page is told it, with what the supervisor has said."""
        report, plan = self._report, self._plan
        state = State.IDLE if report is None else report.state
        silent = report is None or now_ns - report.time_ns > 1e9 * SILENT
        return {
            "state": str(state),
            "text": STARTING if report is None else (plan.reason if plan is not None else "") or str(state),
            "time": round(self.seconds(now_ns), 3),
            "running": not silent,
            "busy": True,
            "generation": self._generation,
            "speed": 1.0,
            "words": [
                str(word) for word in (Word.STOP, *(WORDS.get(state, ()) if report is not None else ()))
            ],
            "forbids": self._forbids,
            "lamps": self._lamps.shown(now_ns),
            "parameters": {name: getattr(self._vitals.parameters, name) for name in self._offered}
            if self._vitals is not None
            else {},
            "events": [{**event, "generation": self._generation} for event in events],
        }


def run_feed(setup: Setup, session: Session, names: Mapping[str, str], began_ns: int) -> None:
    """Be the feed, until a signal ends this process."""
    begin_child()
    rows, said = Rows(setup.name("rows")), Note(Channel(setup.name("said")))
    state, about = Note(Channel(setup.name("state"))), Note(Channel(setup.name("card")))
    generation = int(state.look().get("generation", 0)) + 1
    about.state(card(session, generation))
    rows.begin(generation)
    with contextlib.ExitStack() as stack:
        rings = [stack.enter_context(ring_of(names, stream)) for stream in STREAMS]
        lamps = Lamps([ring for ring in rings if ring is not None])
        feed = Feed(
            session.platform,
            began_ns,
            generation,
            lamps=lamps,
            offered=session.offered,
            forbids=session.forbids,
        )
        looking = _Looking(feed, names)
        wrote = told = 0.0
        while True:
            looking.look()
            now = time.monotonic()
            if now - wrote > WRITE:
                wrote = now
                made = feed.rows()
                rows.write(made) if len(made) else None
            if now - told > TOLD or feed.changed():
                told = now
                state.state(feed.state(time.monotonic_ns(), said.look().get("events", ())))
            time.sleep(LOOK)


class _Looking:
    """Passes on to a feed what the session's processes publish."""

    def __init__(self, feed: Feed, names: Mapping[str, str]) -> None:
        self._feed = feed
        self._vitals, self._plans, self._reports = (
            Channel(names[name]) for name in ("vitals", "plans", "reports")
        )

    def look(self) -> None:
        """Pass on what is new."""
        if (message := self._vitals.read()) is not None:
            self._feed.vitals(unpack_vitals(message))
        if (message := self._plans.read()) is not None:
            self._feed.plan(unpack_plan(message))
        if (message := self._reports.read()) is not None:
            self._feed.report(unpack_report(message))


def parameters_of(session: Session) -> dict[str, float]:
    """Return what pages may change while a session runs, and its values at the start."""
    return {name: getattr(session.parameters, name) for name in session.offered}


def card(session: Session, generation: int) -> dict[str, Any]:
    """Return what is known of a live session as a whole."""
    stated = session.settings
    return {
        "generation": generation,
        "columns": described(session.platform),
        "values": stated.model_dump(include={"platform", "cueing", "dofs", "tuning"}),
        "command": "otolith live run",
        "duration": None,
        "hexapod": hexapod_of(session.platform),
        "map": None,
        "summary": None,
    }
