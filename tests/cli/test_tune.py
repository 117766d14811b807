"""`otolith tune` as its user meets it."""

import json
from pathlib import Path

import pytest

from otolith.cli import main
from otolith.cueing.washout.tuning import parse_tuning
from tests.cli.test_platform import refusal


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


def test_a_washout_is_tuned_to_a_platform_and_a_drive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for line in (
        "example",
        "tune --cueing classical --platform example/rig.toml --log example/drive.csv --lowpass 5"
        " --evaluations 10 --jobs 1 --json --figure tuned.png",
    ):
        with pytest.raises(SystemExit) as ended:
            main(line.split())
        assert ended.value.code == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out[printed.out.index("{") :])
    assert found["trials"] == 10
    assert found["after"]["held_out"]["violations"] >= 0.0
    assert Path("tuned.png").stat().st_size > 10_000
    tuning = parse_tuning(Path("out/tuned-classical.toml").read_text("utf-8"), "tuned-classical.toml")
    assert tuning.classical is not None
    best = found["after"]["settings"]["tuning.classical.surge.natural_radps"]
    assert tuning.classical.surge.natural_radps == best
    command = (
        "otolith run --cueing classical --log example/drive.csv --lowpass 5.0 --platform example/rig.toml "
    )
    assert command + "--tuning out/tuned-classical.toml" in printed.err


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("tune --scale 2", "--scale is given, must be used together with --cueing"),
        ("tune --tuning thesis", "--tuning is given, must be used together with --cueing"),
        ("tune --cueing explicit", "--cueing is 'explicit', must be one of predictive, implicit"),
        ("tune --cueing classical --horizon 9", "--horizon is given, but classical would ignore it"),
    ],
)
def test_options_without_effect_are_refused(
    line: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in refusal(line.split(), capsys)
