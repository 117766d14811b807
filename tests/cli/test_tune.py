"""`otolith tune` as its user meets it."""

import json

import pytest

from otolith.cli import main


def test_it_prints_weights_that_run_takes(capsys: pytest.CaptureFixture[str]) -> None:
    line = [
        "tune",
        "step:amplitude=0.5,duration=2,end=1.5",
        "--on",
        "velocity,position",
        "--evaluations",
        "4",
    ]
    for extra in (["--json"], []):
        with pytest.raises(SystemExit) as ended:
            main([*line, *extra])
        assert ended.value.code == 0
        printed = capsys.readouterr()
        assert "--weight velocity=" in printed.err
        if extra:
            assert set(json.loads(printed.out)["weights"]) == {"velocity", "position"}
        else:
            assert "step:amplitude=0.5" in printed.out
