"""Runs through the real server: what is streamed, what words do, what is written, and who survives whom."""

import csv
import io
import os
import shlex
import signal
import time
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from websockets.exceptions import ConnectionClosed

from otolith import files
from otolith.cli.commander import listening, setup_for
from otolith.cli.commander_job import Choices
from otolith.cli.options import RunOptions, with_run_options
from otolith.commander.bench import Bench, cost, disturbance, running, stops, stops_of_preparing
from otolith.commander.frames import ENVELOPE, RAW, envelope
from otolith.commander.schema import checked
from otolith.commander.security import Refused, Secrets
from otolith.commander.session import LEFT, Session
from otolith.core.errors import InputError
from otolith.experiment import Experiment, differences
from otolith.scenarios import scenario
from tests.commander.client import Page
from tests.commander.conftest import Commander, until

# An algorithm whose kernels are quick to compile; longer than the drives whose optimum is computed.
QUICK = {"cueing": "classical", "platform": "davsi", "tuning": "davsi"}
LONG = QUICK | {"scenario": "sine:amplitude=0.5,frequency=0.25,start=0,duration=61"}


def finished(page: Page, generation: int, **values: Any) -> dict[str, Any]:
    with page.stream() as stream:
        return stream.until("done", generation=generation)


def test_what_is_streamed_is_what_is_stored(page: Page) -> None:
    with page.stream() as stream:
        generation = page.run(**LONG, speed=0.0)
        schema = stream.until("schema", generation=generation)
        stream.until("done", generation=generation)
    names = [column["name"] for column in schema["columns"]]
    folder = page.ask("/api/result").json
    assert folder["generation"] == generation
    stored = files.read_run(results(page) / "run.h5")
    rows = np.vstack([frame.rows for frame in stream.frames])
    assert {frame.kind for frame in stream.frames} == {ENVELOPE}
    for name, series in (
        ("wanted_x", stored.reference_force[:, 0]),
        ("felt_x", stored.felt_force[:, 0]),
        ("pose_x", stored.pose[:, 0]),
        ("pose_pitch", np.degrees(stored.pose[:, 4])),
        ("tilt_rate_pitch", np.degrees(stored.twist[:, 4])),
    ):
        column = rows[:, names.index(name)]
        assert column.max() == pytest.approx(series.max(), rel=1e-6)
        assert column.min() == pytest.approx(series.min(), rel=1e-6)
    first = stream.frames[0]
    wide = first.decimation
    expected = envelope(
        np.column_stack([stored.time, stored.felt_force[:, 0]])[: wide * len(first.rows) // 2], wide
    )
    np.testing.assert_allclose(first.rows[:, names.index("felt_x")], expected[:, 1], rtol=1e-6)
    assert rows[-1, 0] == pytest.approx(61.0, abs=0.1)
    assert np.isnan(rows[:, names.index("felt2_x")]).all()


def results(page: Page) -> Path:
    """Return the folder of the latest results, which no page is told."""
    return max(FOLDERS[page.port].glob("results/*"), key=lambda folder: folder.stat().st_mtime_ns)


FOLDERS: dict[int, Path] = {}


@pytest.fixture(autouse=True)
def _folders(commander: Commander) -> None:
    FOLDERS[commander.port] = commander.setup.folder


def test_a_run_is_that_of_the_command_line_that_is_shown(page: Page) -> None:
    generation = page.run(**LONG, speed=0.0, scale=0.7)
    finished(page, generation)
    command = page.ask("/api/result").json["command"]
    stored = files.read_run(results(page) / "run.h5")
    chosen: list[Experiment] = []

    def run(choices: RunOptions, cueing: str = "predictive", tuning: str | None = None) -> None:
        design = replace(choices.design(), washout=files.read_tuning(tuning) if tuning else None)
        chosen.append(choices.experiment(cueing, design))

    app = typer.Typer()
    app.command()(with_run_options(run))
    words = shlex.split(command)
    assert words[:2] == ["otolith", "run"]
    typer.main.get_command(app)(words[2:], standalone_mode=False)
    assert differences(stored, chosen[0].run()) == []
    assert Experiment.of(stored).wanted.scale == 0.7


def test_every_setting_that_a_run_reads_stands_in_the_command_line(tmp_path: Path) -> None:
    values = {
        "scale": 0.5,
        "through": "young",
        "plant": "actuator",
        "liveliness": 0.3,
        "high_pass": 1.5,
        "low_pass": 0.7,
        "prediction": "hold",
        "horizon": 23,
        "blocks": "1,1,2,7,12",
        "washout": "printed",
        "weight_position": 0.25,
        "braking": "position",
        "guess_entry": "primal",
        "solver": "dense",
        "dofs": "surge-pitch,sway-roll",
    }
    made = Choices(checked(values).model_dump(), tmp_path)
    words = shlex.split(made.command())
    chosen: list[RunOptions] = []
    app = typer.Typer()
    app.command()(with_run_options(lambda choices: chosen.append(choices)))
    typer.main.get_command(app)(words[2:], standalone_mode=False)
    for one in fields(RunOptions):
        assert getattr(chosen[0], one.name) == getattr(made.options, one.name) or one.name == "given"
    assert chosen[0].given - {"scenario", "platform"} == made.options.given


def test_a_drive_below_this_folder_is_named_from_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = Choices(checked({"log": "lap.csv"}).model_dump(), tmp_path / "own")
    monkeypatch.chdir(tmp_path)
    assert shlex.split(made.command())[2:4] == ["--log", "own/drives/lap.csv"]
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert shlex.split(made.command())[2:4] == ["--log", str(tmp_path / "own" / "drives" / "lap.csv")]


def test_stop_ends_a_run_at_once_and_what_was_run_is_written(page: Page) -> None:
    generation = page.run(**LONG)
    with page.stream() as stream:
        stream.until("schema", generation=generation)
        stream.frame()
        assert page.say("stop") == 204
        stream.until("state", state="stopped")
    stored = files.read_run(results(page) / "run.h5")
    assert 0.0 < stored.time[-1] < 30.0
    (stop,) = stored.settings["by_hand"]
    assert stop["stopped"] is True
    assert stop["at"] == pytest.approx(stored.time[-1])
    with pytest.raises(InputError, match="by hand"):
        Experiment.of(stored)


def test_a_changed_scale_is_felt_from_the_next_decision_on_and_logged(page: Page) -> None:
    generation = page.run(**LONG)
    with page.stream() as stream:
        stream.until("schema", generation=generation)
        until(lambda: stream.frame().rows[-1, 0] > 0.5, every=0.0)
        assert page.ask("/api/parameters", {"scale": 0.25}).json["applied"] == {"scale": 0.25}
        event = stream.until("event", level="parameter")
        for values, field in (({"scale": 1e3}, "scale"), ({"cueing": "optimal"}, "cueing"), ({}, "")):
            refused = page.ask("/api/parameters", values)
            assert (refused.status, refused.json["field"]) == (422, field)
        page.ask("/api/parameters", {"liveliness": 0.9})
        assert "no algorithm of this run reads it" in stream.until("event", level="warn")["text"]
        page.say("stop")
        stream.until("state", state="stopped")
    assert event["text"] == "scale: 1 → 0.25"
    stored = files.read_run(results(page) / "run.h5")
    t, wanted = stored.time, stored.reference_force[:, 0]
    sine = scenario(LONG["scenario"]).specific_force(t - 1e-9)[:, 0]
    late = t > event["time"] + 1e-6
    np.testing.assert_allclose(wanted[~late], sine[~late], atol=1e-9)
    np.testing.assert_allclose(wanted[late], 0.25 * sine[late], atol=1e-9)
    assert np.abs(wanted[late]).max() > 0.01


def test_a_paused_run_waits_and_goes_on_where_it_was(page: Page) -> None:
    generation = page.run(**LONG)
    with page.stream() as stream:
        stream.until("schema", generation=generation)
        stream.frame()
        page.say("pause")
        paused = stream.until("state", state="paused")["time"]
        time.sleep(0.5)
        assert page.state()["time"] == paused
        page.say("resume")
        resumed = stream.until("state", state="running")["time"]
    assert paused <= resumed < paused + 0.4


def test_two_algorithms_run_on_one_reference_side_by_side(page: Page) -> None:
    generation = page.run(**LONG, second="adaptive", speed=0.0)
    with page.stream() as stream:
        schema = stream.until("schema", generation=generation)
        done = stream.until("done", generation=generation)
    names = [column["name"] for column in schema["columns"]]
    rows = stream.rows()
    result = page.ask("/api/result").json
    assert done["summary"]["cueing"] == "classical"
    assert result["second"]["cueing"] == "adaptive"
    assert {"classical.h5", "adaptive.h5", "report.html", "summary.json"} <= set(result["files"])
    other = files.read_run(results(page) / "adaptive.h5")
    felt = rows[:, names.index("felt2_x")]
    assert felt.max() == pytest.approx(other.felt_force[:, 0].max(), rel=1e-6)
    assert result["command"].startswith("otolith compare")


def test_only_who_is_in_control_speaks_but_anybody_stops(page: Page, commander: Commander) -> None:
    other = commander.page()
    generation = page.run(**LONG)
    with page.stream() as stream:
        assert stream.until("state", generation=generation)["control"] is True
        assert other.say("pause") == 403
        assert other.ask("/api/parameters", {"scale": 0.5}).status == 403
        assert other.ask("/api/run", LONG).status == 403
        assert page.ask("/api/run", LONG).status == 409
        assert other.state()["control"] is False
        assert other.say("control") == 204
        assert page.say("pause") == 403
        stream.until("state", state="running")
        with other.stream() as line:  # over the websocket, too
            line.send({"word": "pause"})
            line.until("state", state="paused")
            assert page.say("stop") == 204
            line.until("state", state="stopped")


def test_a_refused_form_says_which_field_and_why(page: Page) -> None:
    for path in ("/api/check", "/api/run"):
        for values, field in (
            ({"liveliness": 3}, "liveliness"),
            ({"cueing": "classical", "liveliness": 0.7}, "liveliness"),
            ({"scenario": "nonsense"}, "scenario"),
            ({"cueing": "classical", "second": "classical"}, "second"),
            ({"dofs": "yaw", "platform": "davsi-4dof"}, ""),
            ({"log": "../../etc/passwd"}, "log"),
        ):
            answer = page.ask(path, values)
            assert (answer.status, answer.json["field"]) == (422, field), answer.body
            assert answer.json["sentence"]
            time.sleep(0.06)  # no more words in a second than are allowed
    assert page.ask("/api/check", [1, 2]).status == 422


def test_raw_samples_come_on_request_and_end_by_themselves(page: Page) -> None:
    generation = page.run(**LONG)
    with page.stream() as stream:
        stream.until("schema", generation=generation)
        stream.send({"want": "raw", "columns": ["felt_x"]})
        schema = stream.until("schema")
        assert [column["name"] for column in schema["columns"]] == ["time", "felt_x"]
        frames = [stream.frame() for _ in range(12)]
        raw = [frame for frame in frames if frame.kind == RAW]
        times = np.concatenate([frame.rows[:, 0] for frame in raw])
        assert raw[0].decimation == 1
        np.testing.assert_allclose(np.diff(times), 1e-3, atol=2e-5)
        began = time.monotonic()
        until(lambda: stream.frame().kind == ENVELOPE, 20.0, 0.0)
        assert time.monotonic() - began < 15.0


def test_columns_that_are_chosen_come_finely_after_what_is_kept_of_the_past(page: Page) -> None:
    generation = page.run(**LONG)
    with page.stream() as stream:
        first = stream.until("schema", generation=generation)
        assert first["offered"] == first["columns"]
        until(lambda: stream.frame().rows[-1, 0] > 2.0, every=0.0)
        assert {stream.frame().decimation, stream.frame().decimation} == {10}
        moving = until(lambda: "felt_x" in (told := stream.until("state")["moving"]) and told)
        assert {"wanted_x", "pose_x", "pose_pitch", "step_us"} <= set(moving)
        assert {"time", "felt_y", "felt2_x", "pose_yaw"}.isdisjoint(moving)  # still, or unknown
        stream.send({"want": "envelope", "columns": ["pose_x", "felt_x", "pose_x"]})
        schema = stream.until("schema")
        assert [column["name"] for column in schema["columns"]] == ["time", "pose_x", "felt_x"]
        assert (schema["offered"], schema["rate"]) == (first["offered"], 400.0)
        past = stream.frame()
        assert past.rows[0, 0] < 0.01
        assert past.rows[-1, 0] > 2.0
        assert past.rows.shape[1] == 3
        assert stream.frame().decimation == 5
        for k in range(12):
            stream.send({"want": "envelope", "columns": ["felt_x"][: k % 2]})
        with pytest.raises(ConnectionClosed, match="8 choices of columns within a second"):
            until(lambda: stream.next() is None, every=0.0)


def test_a_client_that_does_not_acknowledge_gets_three_frames_and_then_the_present(page: Page) -> None:
    generation = page.run(**LONG)
    with page.stream() as stream:
        stream.until("schema", generation=generation)
        stream.frame()
        for _ in range(3):
            stream.frame(acknowledge=False)
        with pytest.raises(TimeoutError):
            stream.next(acknowledge=False, timeout=2.0)
        stream.send({"ack": stream.frames[-1].sequence})
        late = stream.frame()
        assert late.age < 0.5
        assert np.isnan(late.rows[:2, 1:]).all()  # the gap
        assert late.rows[0, 0] > stream.frames[-2].rows[-1, 0] + 1.0
        assert np.isfinite(late.rows[2:, 1]).all()
        again = stream.frame()
        assert np.isfinite(again.rows[:, 1]).all()


def test_a_killed_server_comes_back_and_the_run_has_gone_on(page: Page, commander: Commander) -> None:
    generation = page.run(**LONG)
    with page.stream() as stream:
        stream.until("schema", generation=generation)
        before = until(lambda: (late := stream.frame().rows[-1, 0]) > 0.5 and late, every=0.0)
        os.kill(child(commander, "server"), signal.SIGKILL)
    again = until(lambda: reconnected(page), 60.0)
    with again:
        assert again.until("schema")["generation"] == generation
        rows = again.frame().rows
        assert rows[0, 0] < before  # all that the ring still holds
        assert again.frame().rows[-1, 0] > before
    assert page.say("control") == 204  # the same page, with the same secret
    assert any("the server died" in said for said in commander.said)


def reconnected(page: Page):
    try:
        return page.stream()
    except (OSError, TimeoutError):
        return None


def child(commander: Commander, name: str) -> int:
    return next(one.pid for one in commander.processes() if one.name == f"otolith {name}")


def test_a_killed_simulation_is_a_fault_that_is_told_and_the_next_run_works(
    page: Page, commander: Commander
) -> None:
    generation = page.run(**LONG)
    with page.stream() as stream:
        stream.until("schema", generation=generation)
        stream.frame()
        os.kill(child(commander, "simulation"), signal.SIGKILL)
        assert stream.until("event", level="fault")["generation"] == generation
        assert stream.until("state", state="failed")["busy"] is False
        following = page.run(**LONG, speed=0.0)
        assert following == generation + 1
        stream.until("schema", generation=following)
        stream.until("done", generation=following)


def test_samples_are_those_of_the_stored_run(page: Page) -> None:
    finished(page, page.run(**LONG, speed=0.0))
    answer = page.ask("/api/result/samples.csv")
    stored = files.read_run(results(page) / "run.h5")
    table = list(csv.reader(io.StringIO(answer.body.decode())))
    column = table[0].index("felt_x_mps2")
    read = np.array([float(row[column]) for row in table[1:]])
    np.testing.assert_allclose(read, stored.felt_force[:, 0], rtol=1e-5, atol=1e-9)
    report = page.ask("/api/result/report.html")
    assert report.status == 200
    assert "sandbox" in report.headers["content-security-policy"]
    assert page.ask("/api/result/run.h5").body == (results(page) / "run.h5").read_bytes()


def test_presets_are_kept_and_found_again(page: Page) -> None:
    assert page.ask("/api/presets/gentle", {"scale": 0.5}, method="PUT").status == 204
    (found,) = page.ask("/api/presets").json
    assert (found["name"], found["values"]["scale"]) == ("gentle", 0.5)
    assert page.ask("/api/presets/gentle", {"scale": 99}, method="PUT").json["field"] == "scale"
    assert page.ask("/api/presets/gentle", method="DELETE").status == 204
    assert page.ask("/api/presets").json == []
    assert page.ask("/api/presets/gentle", method="DELETE").status == 404


def test_an_uploaded_drive_is_understood_and_can_be_run(page: Page) -> None:
    t = np.arange(0.0, 62.0, 0.05)
    rows = np.column_stack([t, np.sin(t), 0.3 * np.cos(t)])
    text = "t [s],ax [m/s2],ay [m/s2]\n" + "\n".join(",".join(f"{x:.5f}" for x in row) for row in rows)
    answer = page.ask("/api/upload?name=drive.csv", body=text.encode())
    assert answer.status == 200, answer.body
    assert "ax" in answer.json["sentence"]
    assert page.ask("/api/start").json["choices"]["logs"] == ["drive.csv"]
    done = finished(page, page.run(**QUICK, log="drive.csv", speed=0.0))
    assert done["summary"]["duration_s"] == pytest.approx(61.9, abs=0.2)
    damaged = page.ask("/api/upload?name=broken.csv", body=b"\xff\x00 no drive")
    assert damaged.status == 422
    assert page.ask("/api/start").json["choices"]["logs"] == ["drive.csv"]


def test_the_legs_of_a_platform_can_be_drawn(page: Page) -> None:
    finished(page, page.run(**LONG, speed=0.0))
    legs = page.ask("/api/hexapod").json
    base, platform = np.array(legs["base"]), np.array(legs["platform"])
    np.testing.assert_allclose(np.linalg.norm(platform - base, axis=1), legs["neutral"], rtol=1e-12)
    assert page.ask("/api/map").json is None


def test_the_bench_measures_a_commander(tmp_path: Path) -> None:
    """Nothing is said of speed here; but no row is lost, and all figures are there."""
    with listening("127.0.0.1", 0) as line:
        setup = setup_for(line, "127.0.0.1", tmp_path, Secrets())
        with running(setup):
            bench = Bench(setup, checked(LONG).model_dump())
            bench.begin()
            assert cost(bench, 2, 1.0)["kB_per_s"] > 0.0
            assert set(stops(bench, 4)) == {
                f"{way}_{p}_ms" for way in ("post", "websocket") for p in ("p50", "p99")
            }
            assert 0.0 < stops_of_preparing(bench, 1)["most_ms"] < 60_000.0
            found = disturbance(bench, 1.0, 1)
    assert [one["lost"] for one in found.values()] == [0, 0]


def test_a_browser_that_left_is_in_control_no_more() -> None:
    session = Session(
        rows=None,  # type: ignore[arg-type]
        state=None,  # type: ignore[arg-type]
        card=None,  # type: ignore[arg-type]
        orders=None,  # type: ignore[arg-type]
        desk=None,
        folder=Path(),
        secrets=Secrets(),
        hosts=frozenset(),
        now=lambda: clock[0],
    )
    clock = [100.0]
    session.control("first")
    session.came("first")
    clock[0] += 60.0
    with pytest.raises(Refused, match="somebody else"):
        session.control("second")
    session.went("first")
    clock[0] += LEFT - 0.1
    assert session.in_control() == "first"
    clock[0] += 0.2
    assert session.in_control() == ""
    session.control("second")
    assert session.in_control() == "second"
