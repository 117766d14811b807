"""How long a session, a recording or a measurement may last, at the command line."""

import pytest

from otolith.cli import main

LIVE = ["--in", "generic+udp://127.0.0.1:9109", "--out", "generic+udp://127.0.0.1:9119"]


@pytest.mark.parametrize(
    ("line", "least", "most"),
    [
        (["live", "run", *LIVE], "1", "360000"),
        (["live", "demo"], "1", "360000"),
        (["live", "check"], "1", "360000"),
        (["live", "bench"], "1", "360000"),
        (["live", "record", "generic", "--out", "x.otc"], "0.1", "360000"),
        (["live", "emulate", "moog"], "0.1", "360000"),
        (["commander", "bench"], "2", "1200"),
    ],
    ids=lambda value: " ".join(value[:2]) if isinstance(value, list) else "",
)
@pytest.mark.parametrize("seconds", ["inf", "nan", "-1", "0", "1e9"])
def test_a_time_that_is_none_is_refused_with_its_bounds(
    line: list[str], least: str, most: str, seconds: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main([*line, f"--seconds={seconds}"])
    assert ended.value.code == 2
    said = f"otolith: --seconds is {float(seconds):g} s, must be from {least} to {most} s\n"
    assert capsys.readouterr().err == said
