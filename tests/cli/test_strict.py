"""What `run` and `compare` say about failed decisions and limits, and how they exit."""

import json
from pathlib import Path
from typing import Any

import pytest

from otolith import cli, files
from otolith.cli.output import sentence
from otolith.cli.run import _place
from otolith.report import Standing
from tests.cli.test_cli import done

FAR = ["step-2", "--scale", "2", "--cueing", "classical"]  # runs into the end of the travel


def summary(**more: Any) -> dict[str, Any]:
    spread = {"mean": 1.0, "p99": 2.0, "max": 3.0, "median": 4.0}
    known = {
        "cueing": "implicit",
        "scenario": "step-1",
        "rmse": 0.5,
        "changes": spread,
        "step_time_us": spread,
    }
    return known | {"status": {"decided": 1000}, "limits": {}} | more


def test_a_run_without_faults_says_so() -> None:
    assert sentence(summary()).endswith("; no decision failed; all limits kept at every node")


def test_decisions_that_failed_stand_in_the_printed_line() -> None:
    output = sentence(summary(status={"decided": 680, "fallback (infeasible)": 320}))
    assert "320 of 1,000 decisions fell back to braking: the problem had no solution" in output
    assert "\n" not in output


def test_ties_and_broken_limits_stand_in_the_printed_ranking() -> None:
    a, b, c = (
        Standing(cueing=name, ranks=(rank,), values=(0.1,), broken=(broken,))
        for name, rank, broken in (("a", 1, 0), ("b", 1, 0), ("c", 3, 1234))
    )
    assert [_place(one, [a, b, c]) for one in (a, b, c)] == [
        "a: rank 1, tied",
        "b: rank 1, tied",
        "c: rank 3; hard limits passed at 1,234 nodes",
    ]


def exit_code(arguments: list[str]) -> object:
    with pytest.raises(SystemExit) as stopped:
        cli.main(arguments)
    return stopped.value.code


@pytest.mark.parametrize("command", ["run", "compare"])
def test_strict_exits_with_3_when_a_hard_limit_broke_and_all_is_written(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_code([command, *FAR, "--out", str(tmp_path), "--strict", "--json"]) == 3
    output = capsys.readouterr()
    assert "hard limit broken: surge position by up to" in output.err
    stored = json.loads((tmp_path / "summary.json").read_text())
    assert json.loads(output.out) == stored
    assert {"report.html", "summary.json"} <= {path.name for path in tmp_path.iterdir()}
    done([command, *FAR, "--out", str(tmp_path)])


def test_a_soft_limit_is_no_reason_to_exit_and_is_stored_with_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A penalty so small that the tilt rate costs nothing: it is exceeded, as it may be."""
    gentle = ["step:amplitude=1,end=2,duration=2", "--cueing", "implicit", "--soft", "tilt_rate=0.001"]
    done(["run", *gentle, "--out", str(tmp_path), "--strict"])
    assert "soft comfort threshold exceeded: pitch rate by up to" in capsys.readouterr().err
    stored = json.loads((tmp_path / "summary.json").read_text())
    assert stored["violations"] == 0
    assert stored["soft_exceeded"] > 0
    assert files.read_run(tmp_path / "run.h5").soft == ("surge-pitch tilt_rate",)
