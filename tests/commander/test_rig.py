"""A rig that is set up in the page, against the real server."""

import contextlib
import os
import signal
import threading
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith.cli.live_run import Choices
from otolith.commander import trials
from otolith.commander.errands import Ended
from otolith.commander.learning import Ear, learn_axes
from otolith.commander.machine import form, text_of
from otolith.commander.rig import VARIED, Rig, field_of, keep_rig, lacking, session_of_rig
from otolith.core.errors import InputError
from otolith.live.core.times import Times
from otolith.live.permits import SelfTest, keep_axis_test, why_late
from otolith.live.shell.datagrams import opened, receive
from otolith.live.shell.processes import OUTPUT
from otolith.live.shell.rights import real_time_is_granted
from otolith.live.shell.virtual import free_port
from otolith.live.wire.axes import axes_from_toml
from otolith.live.wire.forza import Forza
from otolith.live.wire.sources import SOURCES
from otolith.live.wire.wrc import wrc
from otolith.platforms import parse_platform
from tests.commander.client import Page
from tests.commander.conftest import Commander, until
from tests.commander.test_server import LONG, QUICK, child, finished
from tests.live.shell.rig import PATIENCE
from tests.live.shell.rig import Rig as Machine
from tests.live.wire.golden import CUSTOM_XML, WRC_JSON
from tests.live.wire.minute import DRIVE, forza_packet, wrc_packet

SMALL = {"surge_position_m_low": 0.1, "surge_position_m_high": 0.2, "surge_velocity_mps": 0.5}


def machine(**values: float | str | None) -> dict[str, object]:
    return {"kind": "axes", "values": form("axes")["values"] | values}


def test_a_platform_of_ones_own_is_made_listed_changed_run_and_deleted(
    page: Page, commander: Commander
) -> None:
    shown = page.ask("/api/platforms").json
    assert set(shown["kinds"]) == {"axes", "legs", "cranks"}
    saved = page.ask("/api/platforms/small.toml", machine(**SMALL, description="a sled"), method="PUT")
    assert saved.status == 200, saved.body
    assert "surge: -0.100 to 0.200 m (the file)" in saved.json["sentences"]
    file = commander.setup.folder / "platforms" / "small.toml"
    platform = parse_platform(file.read_text(), "small.toml")
    assert platform.surge is not None
    assert platform.surge.velocity_mps == 0.5
    start = page.ask("/api/start").json
    assert {"name": "small.toml", "text": "a sled"} in start["choices"]["platforms"]
    assert "small.toml" in start["schema"]["properties"]["platform"]["enum"]
    values = page.ask("/api/platforms/small.toml").json
    assert (values["kind"], values["values"]["surge_position_m_high"]) == ("axes", 0.2)

    chosen = QUICK | {"platform": "small.toml", "scenario": "step:amplitude=0.3,duration=61", "speed": 0.0}
    checked = page.ask("/api/check", chosen).json
    assert f"--platform {file}" in checked["command"] or "platforms/small.toml" in checked["command"]
    done = finished(page, page.run(**chosen))
    assert done["summary"]["platform"] == "my-rig"

    assert page.ask("/api/platforms/small.toml", method="DELETE").status == 204
    assert page.ask("/api/platforms/small.toml", method="DELETE").status == 404
    assert page.ask("/api/platforms/small.toml").status == 404
    assert page.ask("/api/check", chosen).status == 422


def test_a_wrong_number_is_said_beside_its_field_and_nothing_is_written(
    page: Page, commander: Commander
) -> None:
    wrong = machine(surge_velocity_mps=400.0)
    answer = page.ask("/api/platforms/fast.toml/check", wrong).json
    assert answer["field"] == "surge_velocity_mps"
    assert answer["sentence"] == (
        "surge.velocity_mps in fast.toml is 400.0, must be between 0.005 and 20 m/s (is it in mm/s?)"
    )
    saved = page.ask("/api/platforms/fast.toml", wrong, method="PUT")
    assert (saved.status, saved.json) == (422, answer)
    assert page.ask("/api/platforms/fast.toml/check", machine()).json == {"field": "", "sentence": ""}
    assert not (commander.setup.folder / "platforms" / "fast.toml").exists()


@pytest.mark.parametrize(
    "name", ["x.txt", "..toml", "%2e%2e%2fx.toml", "..%5cx.toml", "x" * 65 + ".toml", "davsi"]
)
def test_platform_files_have_plain_names(page: Page, commander: Commander, name: str) -> None:
    before = sorted(commander.setup.folder.rglob("*"))
    for method, path in (("PUT", ""), ("POST", "/check"), ("DELETE", ""), ("GET", "")):
        given = None if method in ("GET", "DELETE") else machine()
        answer = page.ask(f"/api/platforms/{name}{path}", given, method=method)
        assert answer.status in (404, 405, 422), answer.body
        time.sleep(0.06)
    assert sorted(commander.setup.folder.rglob("*")) == before
    refused = page.ask("/api/check", {"platform": f"../{name}"})
    assert (refused.status, refused.json["field"]) == (422, "platform")


def test_a_file_that_is_damaged_is_said_in_the_list(page: Page, commander: Commander) -> None:
    file = commander.setup.folder / "platforms" / "torn.toml"
    file.write_text('name = "x"\nsurge = 3\n')
    try:
        (found,) = (one for one in page.ask("/api/platforms").json["own"] if one["name"] == "torn.toml")
        assert "surge in torn.toml is 3, must be a table of fields" in found["text"]
        assert page.ask("/api/platforms/torn.toml").status == 422
    finally:
        file.unlink()


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"device": "template", "axes": "surge -0.2 0.2; pitch 12 -12", "on_silence": "holds"},
        {"device": "generic", "source": "beamng", "variant": "old", "pauses_silently": True},
        {"cueing": "classical", "tuning": "davsi", "dofs": "surge-pitch", "scale": 0.5},
    ],
)
def test_a_rig_is_the_session_that_its_file_makes_on_the_command_line(
    tmp_path: Path, values: dict[str, Any]
) -> None:
    rig = Rig(**values)
    made = Choices(file=keep_rig(rig, tmp_path)).session()
    assert made.settings == session_of_rig(rig, tmp_path).settings
    if made.settings.device.template is not None:
        assert made.settings.device.template.axes[1].low == pytest.approx(0.20944, abs=1e-5)


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"address": "nowhere"}, "address"),
        ({"listen": "127.0.0.1:x"}, "listen"),
        ({"source": "lfs2"}, "source"),
        ({"device": "template", "axes": "surge left right"}, "axes"),
        ({"device": "template", "axes": "surge 1 1; pitch 0 1"}, "axes"),
        ({"device": "template", "frame": "<Axis3a>"}, "frame"),
        ({"platform": "gone.toml"}, "platform"),
        ({"platform": "thesis"}, "platform"),
        ({"map": "gone.toml"}, "map"),
    ],
)
def test_what_a_session_refuses_is_said_beside_the_field(
    page: Page, commander: Commander, values: dict[str, Any], field: str
) -> None:
    answer = page.ask("/api/rig", values).json
    assert answer["field"] == field, answer
    assert "must be" in answer["sentence"]
    assert not (commander.setup.folder / "rig.json").exists()
    time.sleep(0.06)


def test_a_rig_is_kept_and_found_again(page: Page, commander: Commander) -> None:
    try:
        assert page.ask("/api/rig", {"scale": 0.4}).json["sentence"] == ""
        found = page.ask("/api/rig").json
        assert found["values"]["scale"] == 0.4
        assert found["ports"]["forza"] == 5300
        assert tomllib.loads((commander.setup.folder / "rig.toml").read_text())["scale"] == 0.4
    finally:
        for name in ("rig.json", "rig.toml"):
            (commander.setup.folder / name).unlink()


def errand(page: Page, word: str, **values: Any) -> int:
    return page.ask("/api/errand", {"word": word, **values}).status


@pytest.fixture
def listening(page: Page, commander: Commander) -> Iterator[Page]:
    """A page whose rig listens for Forza on a port that is free."""
    with opened(0) as line:
        port = line.getsockname()[1]
    assert page.ask("/api/rig", {"source": "forza", "listen": f"127.0.0.1:{port}"}).json["sentence"] == ""
    assert errand(page, "learn") == 202
    yield page
    page.say("stop")
    with page.stream() as stream:
        stream.until("rig", busy="")
    for name in ("rig.json", "rig.toml"):
        (commander.setup.folder / name).unlink()


def test_learning_shows_what_is_missing_and_ends_by_a_stop_of_anybody(
    listening: Page, commander: Commander
) -> None:
    with listening.stream() as stream:
        until(lambda: "nothing has arrived" in stream.until("rig")["shown"].get("missing", ""), every=0.0)
        assert errand(listening, "learn") == 409
        assert errand(commander.page(), "cancel") == 403  # it is not in control
        assert commander.page().say("stop") == 204
        assert stream.until("rig", busy="")["phase"] == "stopped"


def test_a_rigs_process_that_is_killed_is_told_and_the_next_errand_works(
    listening: Page, commander: Commander
) -> None:
    with listening.stream() as stream:
        stream.until("rig", busy="learn")
        os.kill(child(commander, "rig"), signal.SIGKILL)
        died = stream.until("rig", busy="")
        assert (died["errand"], died["phase"]) == ("learn", "failed")
        assert "ended unexpectedly" in died["sentence"]
        assert listening.ask("/health").status == 200
        assert errand(listening, "learn") == 202
        stream.until("rig", busy="learn")
        assert errand(listening, "cancel") == 202
        assert stream.until("rig", busy="")["phase"] == "stopped"


def test_a_port_that_another_program_holds_is_said(page: Page, commander: Commander) -> None:
    with opened(0) as line:
        page.ask("/api/rig", {"listen": f"127.0.0.1:{line.getsockname()[1]}"})
        with page.stream() as stream:
            assert errand(page, "learn") == 202
            failed = stream.until("rig", phase="failed")
    assert "cannot be opened" in failed["sentence"]
    for name in ("rig.json", "rig.toml"):
        (commander.setup.folder / name).unlink()


def test_an_errand_must_be_one_and_a_map_has_a_plain_name(page: Page) -> None:
    assert errand(page, "dance") == 422
    assert errand(page, "save", name="../x") == 422


class Talk:
    """An errand's talk without a process: it hears what a test has prepared."""

    def __init__(self, *orders: Any) -> None:
        self.orders, self.shown = list(orders), dict[str, Any]()

    def show(self, **shown: Any) -> None:
        self.shown |= shown

    def heard(self) -> list[Any]:
        if self.shown.get("learned"):
            return self.orders
        if self.shown.get("missing"):
            raise Ended
        return []


class Save:
    word, values = "save", {"name": "game.toml"}


def test_what_was_driven_is_saved_as_a_map_of_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A minute that arrives at once, with the times of its driving."""
    parser = Forza()

    def heard(ear: Ear) -> Ear:
        ear.samples = [(float(t), parser.parse(forza_packet(k))) for k, t in enumerate(DRIVE.t)]
        ear.packets = len(ear.samples)
        return ear

    monkeypatch.setattr(Ear, "__enter__", heard)
    monkeypatch.setattr(Ear, "__exit__", lambda ear, *_: ear._line.close())
    talk: Any = Talk(Save)
    sentence = learn_axes(tmp_path, talk, {"source": "forza", "listen": "127.0.0.1:0"})
    assert sentence == "axis map game.toml is saved"
    assert all(one["passed"] for one in talk.shown["parts"])
    axes = axes_from_toml((tmp_path / "maps" / "game.toml").read_text(), "game.toml")
    assert axes.evidence["circle"] > 0.99
    rig = Rig(source="forza", listen="127.0.0.1:5300", map="game.toml")
    assert Choices(file=keep_rig(rig, tmp_path)).session().axes == axes


def test_what_follows_a_game_is_only_what_it_has() -> None:
    """The variant of another game is hidden in the page, so it is no fault of this one's."""
    assert VARIED == ("beamng", "lfs", "lfs2")
    assert Rig(source="beamng", variant="old").sender == "beamng:old"
    assert Rig(source="forza", variant="old", channels="x.json").sender == "forza"
    assert Rig(source="wrc", variant="old", channels="x.json").sender == "wrc:x.json"


def test_only_a_plain_name_leads_to_a_file_of_the_games(tmp_path: Path) -> None:
    talk: Any = Talk()
    (tmp_path / "x.json").write_text(WRC_JSON)
    with pytest.raises(InputError, match=r"channels is '../x\.json', must be the name of a file"):
        learn_axes(tmp_path, talk, {"source": "wrc:../x.json", "listen": "127.0.0.1:0"})
    with pytest.raises(InputError, match="file of channels"):
        learn_axes(tmp_path, talk, {"source": "wrc:none.json", "listen": "127.0.0.1:0"})
    assert field_of(InputError("nothing of it", 1, "2")) == ""


def given(page: Page, source: str, name: str, text: str) -> Any:
    """Give the server a file of a game's, as the page does; return its answer."""
    return page.ask(f"/api/channels?source={source}&name={name}", body=text.encode())


@pytest.mark.parametrize(
    ("source", "name", "text"),
    [("wrc", "udp.json", WRC_JSON), ("codemasters-custom", "packet_data.xml", CUSTOM_XML)],
)
def test_a_game_that_a_file_describes_is_set_up_from_its_file(
    page: Page, commander: Commander, source: str, name: str, text: str
) -> None:
    lacks = page.ask("/api/rig", {"source": source, "listen": "127.0.0.1:0"}).json
    assert lacks == {"field": "channels", "sentence": f"channels is empty, must be {SOURCES[source].needs}"}
    answer = given(page, source, name, text[:-3])
    assert (answer.status, name in answer.json["sentence"]) == (422, True)
    assert not (commander.setup.folder / "channels" / name).exists()
    assert given(page, "forza", name, text).status == 422
    assert given(page, source, "../x", text).status == 422
    answer = given(page, source, name, text)
    assert answer.json == {"name": name, "sentence": f"read as a file of {source}"}
    assert name in page.ask("/api/rig").json["schema"]["properties"]["channels"]["enum"]
    rig = {"source": source, "channels": name, "listen": f"127.0.0.1:{free_port()}"}
    assert page.ask("/api/rig", rig).json == {"field": "", "sentence": ""}
    stated = tomllib.loads((commander.setup.folder / "rig.toml").read_text())["input"]["source"]
    assert stated == f"{source}:{commander.setup.folder / 'channels' / name}"
    assert Choices(file=commander.setup.folder / "rig.toml").session().source.name == source
    with page.stream() as stream:
        assert errand(page, "learn") == 202
        stream.until("rig", busy="learn")
        assert errand(page, "cancel") == 202
        assert stream.until("rig", busy="")["phase"] == "stopped"
    for file in ("rig.json", "rig.toml"):
        (commander.setup.folder / file).unlink()


def test_the_axes_of_wrc_are_learned_from_what_its_file_describes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same minute, as the game would send it: channels by name, world axes, no rates."""
    (tmp_path / "channels").mkdir()
    (tmp_path / "channels" / "udp.json").write_text(WRC_JSON)
    parser = wrc(WRC_JSON, "udp.json")

    def heard(ear: Ear) -> Ear:
        ear.samples = [(float(t), parser.parse(wrc_packet(k))) for k, t in enumerate(DRIVE.t)]
        ear.packets = len(ear.samples)
        return ear

    monkeypatch.setattr(Ear, "__enter__", heard)
    monkeypatch.setattr(Ear, "__exit__", lambda ear, *_: ear._line.close())
    talk: Any = Talk(Save)
    assert learn_axes(tmp_path, talk, {"source": "wrc:udp.json", "listen": "127.0.0.1:0"})
    axes = axes_from_toml((tmp_path / "maps" / "game.toml").read_text(), "game.toml")
    assert (axes.source, axes.force) == ("wrc", ("1", "2", "3"))
    assert axes.evidence["circle"] > 0.99


def waits(stream: Any) -> dict[str, Any]:
    """Return what an axis test says when it waits to be let begin; a cold compiler may take a while."""
    end, began = time.monotonic() + PATIENCE, False
    while time.monotonic() < end:
        told = stream.until("rig")
        began = began or bool(told["busy"])
        assert told["busy"] or not began, told
        if told["shown"].get("asks") == "ready":
            return dict(told)
    raise TimeoutError(f"not within {PATIENCE} s: {told}")


def test_a_stop_of_anybody_ends_an_axis_test_and_the_platform_parks(page: Page, commander: Commander) -> None:
    with Machine() as machine, page.stream() as stream:
        page.ask("/api/rig", {"address": f"127.0.0.1:{machine.device}"})
        assert errand(page, "axis", what="wheels") == 422
        assert errand(page, "axis", what="axes") == 202
        asked = waits(stream)
        assert (asked["shown"]["axis"], asked["shown"]["seen"]) == ("surge", "forward by 10 mm")
        assert asked["shown"]["axes"] == ["surge", "sway", "roll", "pitch"]
        assert not machine.farthest[0] > 1e-3  # it waits
        refused = page.ask("/api/run", LONG)
        assert (refused.status, "being tested" in refused.json["sentence"]) == (409, True)
        assert page.ask("/api/errand", {"word": "move"}, Cookie=commander.page().cookie).status == 403
        assert errand(page, "move") == 202
        until(lambda: machine.farthest[0] > 3e-3)
        assert commander.page().say("stop") == 204
        ended = stream.until("rig", busy="")
        assert ended["phase"] == "stopped"
        assert any(said.startswith("returning: stop") for said in ended["said"])
        machine.is_at_home()
        assert machine.base.faults == 0
    for name in ("rig.json", "rig.toml"):
        (commander.setup.folder / name).unlink()


def test_a_platform_parks_by_itself_when_the_process_that_moves_it_is_killed(
    page: Page, commander: Commander
) -> None:
    with Machine() as machine, page.stream() as stream:
        page.ask("/api/rig", {"address": f"127.0.0.1:{machine.device}"})
        assert errand(page, "axis", what="axes") == 202
        waits(stream)
        assert errand(page, "move") == 202
        until(lambda: machine.farthest[0] > 3e-3)
        os.kill(child(commander, "rig"), signal.SIGKILL)
        assert "ended unexpectedly" in stream.until("rig", phase="failed")["sentence"]
        machine.is_at_home()
        assert machine.base.faults == 0
    for name in ("rig.json", "rig.toml"):
        (commander.setup.folder / name).unlink()


def test_a_rig_is_not_tested_while_a_run_goes_on(page: Page) -> None:
    page.run(**LONG)
    assert errand(page, "axis", what="axes") == 409
    assert errand(page, "check") == 409
    page.say("stop")


def test_what_is_lacking_before_a_ride_is_said_until_it_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))

    def missing() -> list[str]:
        checks = lacking(tmp_path)
        assert all(one["sentence"] for one in checks)
        return [one["leads"] for one in checks if not one["ok"]]

    assert missing() == ["device"]
    rig = Rig(source="forza", listen="127.0.0.1:5300")
    keep_rig(rig, tmp_path)
    assert missing() == ["telemetry", "check", "axis"]
    keep_axis_test(session_of_rig(rig, tmp_path), ["surge", "sway", "roll", "pitch"])
    assert missing() == ["telemetry", "check"]
    late = Times()
    late.note(1_000)  # [ns]
    SelfTest.of(late, seconds=60.0, real_time=real_time_is_granted(OUTPUT)).keep()
    assert missing() == ["telemetry"]
    keep_rig(Rig(), tmp_path)  # another game, in our axes: the device is the same
    assert missing() == []
    keep_rig(Rig(address="127.0.0.1:9911"), tmp_path)
    assert missing() == ["axis"]
    (tmp_path / "rig.json").write_text('{"platform": "gone.toml"}')
    assert missing() == ["device"]


def test_this_computer_is_tested_by_a_session_and_the_record_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(trials, "SECONDS", 1.0)
    keep_rig(Rig(cueing="classical", tuning="davsi"), tmp_path)
    talk: Any = Talk()
    talk.tell = lambda sentence: talk.shown.setdefault("said", []).append(sentence)
    with contextlib.suppress(trials.NotPassed):  # the machine decides
        assert "this computer passes" in trials.try_host(tmp_path, talk, {})
    late = why_late(real_time=real_time_is_granted(OUTPUT))
    assert late == "" or "in the self-test of" in late
    assert talk.shown["of"] == 1


def test_an_answer_counts_for_what_was_asked_and_nobody_waits_for_ever(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    talk: Any = Talk()
    orders: list[Any] = []
    monkeypatch.setattr(talk, "heard", lambda: [orders.pop()] if orders else [])
    beside = trials.Beside(talk)
    assert beside.ready("surge") is False
    orders.append(Save)  # some other word
    beside.look()
    assert beside.ready("surge") is False
    for word in ("yes", "move"):  # said too early: it is asked whether surge may move
        orders.append(type("Word", (), {"word": word, "values": {}}))
        beside.look()
        assert beside.ready("surge") is (word == "move")
    assert beside.saw("surge") is None
    orders.append(type("Word", (), {"word": "no", "values": {}}))
    beside.look()
    assert beside.saw("surge") is False
    assert talk.shown["answers"] == {"surge": "no"}
    assert beside.ready("sway") is False
    monkeypatch.setattr(trials, "PATIENCE", -1.0)
    with pytest.raises(trials.NotPassed, match="nobody answered"):
        beside.ready("sway")


class Obedient(Talk):
    """Whoever lets every axis move, and sees it move."""

    def tell(self, sentence: str) -> None:
        """Have no page to show it on."""

    def heard(self) -> list[Any]:
        word = {"ready": "move", "saw": "yes"}.get(self.shown.get("asks", ""))
        return [] if word is None else [type("Word", (), {"word": word, "values": {}})]


def test_a_device_of_a_template_gets_10_mm_and_1_degree_in_its_own_codes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What arrives at a controller of SimTools: two bytes per axis, of the ranges that the rig states."""
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    (tmp_path / "platforms").mkdir()
    (tmp_path / "platforms" / "mine.toml").write_text(text_of(form("axes")["values"], "axes", "mine.toml"))
    with opened(0) as line:
        keep_rig(
            Rig(
                platform="mine.toml",
                dofs="surge-pitch",
                device="template",
                address=f"127.0.0.1:{line.getsockname()[1]}",
                cueing="classical",
                tuning="davsi",
            ),
            tmp_path,
        )
        packets: list[bytes] = []
        over = threading.Event()

        def take() -> None:
            while not over.is_set():
                receive(line, lambda packet, _: packets.append(packet), seconds=0.2)

        device = threading.Thread(target=take)
        device.start()
        try:
            talk: Any = Obedient()
            assert "may arm" in trials.try_axes(tmp_path, talk, {"what": "axes"})
        finally:
            over.set()
            device.join()
    codes = np.array([[int.from_bytes(one[k : k + 2], "big") for k in (2, 4)] for one in packets])
    ways = np.ptp(codes, axis=0) * np.array([0.27, 24.0]) / 65_535  # the ranges: -0.12 to 0.15 m, ±12 deg
    assert ways == pytest.approx([10e-3, 1.0], rel=0.01)
    assert talk.shown["answers"] == {"surge": "yes", "pitch": "yes"}
    assert "axis" not in [one["leads"] for one in lacking(tmp_path) if not one["ok"]]
