"""`otolith live replay` and `live export` of a log, whole, changed and damaged."""

import json
from pathlib import Path

import numpy as np
import pytest

from otolith.cli import main
from otolith.cli.live_run import Choices
from otolith.live.log import MOST, NAMES, Kind
from otolith.live.records import HEAD, Records, record
from otolith.live.virtual_log import VirtualLog
from otolith.live.world import World, arm_and_engage, sines
from otolith.registry import make_cueing


def run(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    return int(ended.value.code or 0)


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A log of a virtual session that a real one could have written."""
    session = Choices(
        incoming="generic+udp://127.0.0.1:9100",
        outgoing="moog+udp://127.0.0.1:9910",
        cueing="classical",
        tuning="davsi",
    ).session()
    written = VirtualLog(session.to_record())
    cueing = make_cueing("classical", session.design())
    drive = sines({0: (1.2, 0.4), 1: (0.8, 0.7)})
    world = World(cueing, session.platform, drive=drive, park=np.array(session.park), tick=2e-3)
    arm_and_engage(world.record(written)).run(5.0)
    path = tmp_path_factory.mktemp("log") / "s.otl"
    path.write_bytes(written.disk.data)
    return path


def test_a_log_replays(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["live", "replay", str(log)]) == 0
    said = capsys.readouterr()
    assert "500 plans of 5.0 s compared: equal bit for bit" in said.out
    assert "set-points of 5.0 s compared: equal bit for bit" in said.out


def test_a_changed_packet_is_told_with_the_first_plan_that_differs(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One bit of a force, in a packet and log whose checksums are right: a replay tells what it does."""
    data = log.read_bytes()
    packets = [one for one in Records(data, "s.otl", NAMES, most=MOST) if one.kind == Kind.TELEMETRY]
    lacking = packets[250]
    cut = data[: lacking.place] + data[lacking.place + HEAD.size + len(lacking.payload) :]
    path = tmp_path / "changed.otl"
    path.write_bytes(cut)
    assert run(["live", "replay", str(path), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["plans"]["different"] > 0
    assert found["plans"]["first_difference"].startswith("plan 4")
    assert found["set-points"]["different"] == 0  # the output was told the plans of then


def test_a_damaged_log_is_compared_and_exported_up_to_its_damage(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = bytearray(log.read_bytes())
    whole = Records(bytes(data), "", NAMES, most=MOST)
    middle = next(one for one in whole if one.place > len(data) // 2 and one.kind == Kind.SET_POINT)
    data[middle.place + 12] ^= 1
    path, out = tmp_path / "damaged.otl", tmp_path / "x.csv"
    path.write_bytes(data)
    sentence = f"damaged.otl is damaged at byte {middle.place:,}, in a record of kind set_point: its checksum"
    assert run(["live", "replay", str(path)]) == 2
    said = capsys.readouterr()
    assert "set-points of 3.2 s compared: equal bit for bit" in said.out
    assert sentence in said.err
    assert run(["live", "export", str(path), "--out", str(out), "--table", "set-points"]) == 0
    assert sentence in capsys.readouterr().err
    assert 1000 < len(out.read_text().splitlines()) < 2000


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "is no log of a session of version 1"),
        (record(1, b'{"format": "otolith-capture", "version": 1, "source": ""}'), "is no log of a session"),
        (record(1, b'{"format": "otolith-log", "version": 1}'), "lacks 'session'"),
    ],
)
def test_other_files_are_refused(
    data: bytes, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.otl"
    path.write_bytes(data)
    assert run(["live", "replay", str(path)]) == 2
    assert words in capsys.readouterr().err


def test_names_that_export_cannot_write_are_refused(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["live", "export", str(log), "--out", "x.xlsx"]) == 2
    assert "a name that ends in .h5 or .mf4 or .csv" in capsys.readouterr().err
    assert run(["live", "export", str(log), "--out", "x.csv", "--table", "motion"]) == 2
    assert "--table is 'motion', must be one of reference, set-points" in capsys.readouterr().err
