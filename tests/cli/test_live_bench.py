"""`otolith live bench`: real time beside a bare loop, and the words for virtual time."""

import json

import pytest

from otolith.cli import main
from otolith.cli.live_bench import Line, _seconds
from otolith.core.errors import InputError


def ended(arguments: list[str]) -> int:
    with pytest.raises(SystemExit) as end:
        main(arguments)
    return int(end.value.code or 0)


def test_every_figure_has_a_goal_and_the_bare_loop_runs_beside(capsys: pytest.CaptureFixture[str]) -> None:
    washout = ["--cueing", "classical", "--tuning", "davsi"]
    assert ended(["live", "bench", "--seconds", "1", *washout, "--json"]) == 0
    rows = {row["what"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
    assert all(row["value"] >= 0.0 and row["goal"] > 0.0 for row in rows.values())
    late = rows["output woken late: p99"]
    assert late["reference"] > 0.0
    assert (
        rows["packet to first set-point: median"]["value"] < rows["packet to first set-point: p99"]["value"]
    )
    assert rows["packet to plan, on the processor: median"]["goal"] == 250.0


@pytest.mark.parametrize(
    ("text", "seconds"), [("90", 90.0), ("10min", 600.0), ("2h", 7200.0), ("1.5 h", 5400.0), ("3s", 3.0)]
)
def test_virtual_time_is_said_in_hours_minutes_or_seconds(text: str, seconds: float) -> None:
    assert _seconds(text) == seconds


@pytest.mark.parametrize("text", ["0", "2 days", "-1h", "101h", "h", "nan"])
def test_other_times_are_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"--virtual is .*, must be a time of 1 s to 100 h"):
        _seconds(text)


def test_a_figure_beyond_its_goal_is_marked() -> None:
    assert Line("late", 2.5, "ms", 2.0, 0.5).cells() == ("late", "2.5", "ms", "2", "0.5", "beyond")
    assert Line("late", 2.0, "ms", 2.0).cells()[-1] == ""
