"""A page that watches and operates a live session of real processes, and dies beside it."""

import multiprocessing
import os
import signal

import numpy as np

from otolith.live.log import Kind, Opened, meaning
from otolith.live.messages import State
from otolith.live.shell.supervise import Live
from tests.commander.client import Page, Stream
from tests.commander.conftest import until
from tests.live.shell.rig import Rig

Watched = tuple[Live, Rig, Page, list[str]]


def child(name: str) -> int:
    return next(one.pid or 0 for one in multiprocessing.active_children() if one.name == f"otolith {name}")


def test_a_page_arms_engages_and_stops_and_its_processes_may_die(live_session: Watched) -> None:
    live, rig, page, _ = live_session
    assert page.start["mode"] == "live"
    assert page.ask("/api/run", {}).status == 409
    with page.stream() as stream:
        assert stream.until("event", text="started")
        assert "arm" in stream.until("state", state="idle")["words"]
        assert page.say("arm") == 204
        stream.until("state", state="ready")
        stream.send({"word": "engage"})
        stream.until("state", state="engaged")
        rig.moves()
        for _ in range(20):
            stream.frame()
        names = [
            column["name"]
            for column in next(one for one in stream.texts if one["kind"] == "schema")["columns"]
        ]
        rows = stream.rows()
        assert np.isfinite(rows[-1, names.index("wanted_x")])
        assert np.nanmax(np.abs(rows[:, names.index("felt_x")])) > 0.0  # NaN before it was engaged
        assert stream.frames[-1].age < 1.0
        _changes(page, stream)
        os.kill(child("feed"), signal.SIGKILL)
        os.kill(child("server"), signal.SIGKILL)
    assert live.alive("output")
    again = Page(page.port, _token(page))
    with again.stream() as stream:
        stream.until("state", state="engaged")  # nothing has happened to the session
        assert live.fault == ""
        assert again.say("stop") == 204
        stream.until("event", text="returning: stop")
        stream.until("state", state="ready")
    assert live.log is not None
    log = Opened(live.log.path.read_bytes(), "s.otl")
    assert [meaning(one, "s.otl").scale for one in log.records if one.kind == Kind.CHANGE] == [0.5]


def _changes(page: Page, stream: Stream) -> None:
    """The one in control changes what may change, and nothing else; who looks on does not."""
    offered = {"scale": 1.0, "high_pass": 1.0, "low_pass": 1.0}  # classical reads no liveliness
    assert list(page.start["schema"]["properties"]) == list(offered)
    assert page.start["values"] == offered
    for values in (
        {"scale": 1.01},
        {"high_pass": 3.0},
        {"liveliness": 0.1},
        {"speed": 2.0},
        {"scale": "a"},
        {},
    ):
        answer = page.ask("/api/parameters", values)
        assert (answer.status, answer.json["sentence"].count("\n")) == (422, 0)
    body = b'{"scale": NaN}'
    answer = page.ask("/api/parameters", body=body, Content_Type="application/json")
    assert "a finite number" in answer.json["sentence"]
    other = Page(page.port, _token(page))
    assert other.ask("/api/parameters", {"scale": 0.5}).status == 403
    assert page.ask("/api/parameters", {"scale": 0.5}, X_Otolith="wrong").status == 403
    answer = page.ask("/api/parameters", {"scale": 0.5})
    assert (answer.status, answer.json["applied"]) == (200, {"scale": 0.5})
    said = stream.until("event", level="parameter")
    assert said["text"] == "scale: 1 → 0.5, within 2.5 s"
    stream.until("state", parameters=offered | {"scale": 0.5})


def _token(page: Page) -> str:
    return page.cookies["otolith-token"]


def test_another_page_only_looks_on_but_stops(live_session: Watched) -> None:
    live, _, page, _ = live_session
    other = Page(page.port, _token(page))
    with page.stream() as stream, other.stream() as looking:
        assert page.say("arm") == 204
        looking.until("state", state="ready")
        assert other.say("engage") == 403
        assert page.say("engage") == 204
        lamps = looking.until("state", state="engaged")["lamps"]
        assert lamps["log"] == ""
        assert 0 <= lamps["missed_lately"] <= lamps["missed"]
        assert 0.0 <= lamps["clock"] < 1.0
        assert lamps["telemetry_age_s"] < 1.0
        os.kill(child("recorder"), signal.SIGKILL)
        told = until(lambda: looking.until("state")["lamps"]["log"])
        assert "its recorder has said nothing" in told
        assert other.say("stop") == 204
        stream.until("event", text="returning: stop")
    assert live.report is not None
    assert live.report.state in (State.RETURNING, State.READY)
