"""What must have been tested before a session may arm."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from otolith.cli.live_run import Choices, permitted
from otolith.core.errors import CorruptFile
from otolith.live.core.times import Times
from otolith.live.permits import SelfTest, digest, keep_axis_test, state_folder, why_late, why_untested
from otolith.live.session import Session

MS = 1_000_000


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.delenv("LOCALAPPDATA", raising=False)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    return tmp_path / "otolith"


def late(*durations: int) -> Times:
    times = Times()
    for duration in durations:
        times.note(duration)
    return times


def session(**changes: object) -> Session:
    choices = Choices(incoming="forza+udp://127.0.0.1:5300", outgoing="moog+udp://127.0.0.1:9910")
    return replace(choices, **changes).session()  # type: ignore[arg-type]


def test_a_host_that_woke_in_time_may_arm_until_something_changes(folder: Path) -> None:
    assert "has not been tested" in why_late(real_time=True)
    test = SelfTest.of(late(*[MS // 10] * 999, 30 * MS), seconds=60.0, real_time=True)
    assert test.punctual  # one of a thousand is later
    assert test.keep() == folder / "self-test.json"
    assert why_late(real_time=True) == ""
    assert "real-time scheduling granted was True, is False" in why_late(real_time=False)
    replace(test, system="Linux 1.0").keep()
    assert "system was Linux 1.0, is " in why_late(real_time=True)
    replace(test, host="another").keep()
    assert "host was another" in why_late(real_time=True)


def test_a_host_that_woke_late_may_not_arm() -> None:
    test = SelfTest.of(late(*[MS // 10] * 998, 3 * MS, 3 * MS), seconds=60.0, real_time=True)
    assert not test.punctual
    test.keep()
    why = why_late(real_time=True)
    assert "99.9 % of wake-ups were up to 3 ms late" in why
    assert "must be at most 2 ms; --allow-jitter overrules this" in why


def test_axes_are_tested_per_device_and_platform_and_a_change_makes_them_untested() -> None:
    tested = session()
    assert "the axes of moog at 127.0.0.1:9910 are not tested" in why_untested(tested)
    keep_axis_test(tested, ["surge"])
    assert why_untested(session()) == ""
    for changed in (
        session(neutral_heave=-0.19),
        session(outgoing="moog+udp://127.0.0.1:9911"),
        session(platform="tripod"),
    ):
        assert digest(changed) != digest(tested)
        assert why_untested(changed) != ""
    assert digest(session(incoming="beamng+udp://127.0.0.1:4444")) == digest(tested)
    keep_axis_test(session(neutral_heave=-0.19), ["surge"])
    assert why_untested(tested) == ""  # both are kept


def test_jitter_can_be_overruled_and_axes_cannot() -> None:
    assert "are not tested" in permitted(session(), allow_jitter=True).forbids
    keep_axis_test(session(), ["surge"])
    assert permitted(session(), allow_jitter=True).forbids == ""
    assert "has not been tested" in permitted(session(), allow_jitter=False).forbids


@pytest.mark.parametrize("text", ["{", "[]", '{"host": "here"}'])
def test_a_damaged_record_is_named(text: str, folder: Path) -> None:
    folder.mkdir()
    (folder / "self-test.json").write_text(text)
    with pytest.raises(CorruptFile, match=r"self-test\.json is"):
        why_late(real_time=True)
    assert json.dumps(str(state_folder())) == json.dumps(str(folder))
