"""`otolith optimum`, and `--optimum` of `run` and `compare`."""

from pathlib import Path

import pytest

from otolith import files
from tests.cli.test_cli import done, refused

SHORT = "step:amplitude=2,start=1,end=5,duration=6"


def test_the_optimum_is_written_as_a_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done(["optimum", SHORT, "--out", str(tmp_path / "o")])
    run = files.read_run(tmp_path / "o" / "run.h5")
    assert run.cueing == "optimum"
    assert (tmp_path / "o" / "report.html").is_file()
    assert "certified to" in capsys.readouterr().err


def test_a_comparison_says_how_far_each_is_from_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chosen = ["--cueing", "classical", "--cueing", "optimal", "--optimum"]
    done(["compare", SHORT, *chosen, "--out", str(tmp_path / "o")])
    assert capsys.readouterr().err.count("times the best that is possible (") == 2


@pytest.mark.parametrize(
    ("option", "sentence"),
    [
        (["--horizon", "5"], "--horizon is given, but the optimum would ignore it, must be left out"),
        (["--plant", "ideal"], "--plant is given, but the optimum would ignore it, must be left out"),
        (["--dofs", "surge-pitch,heave", "--platform", "davsi"], "must be without heave, or heave alone"),
    ],
)
def test_what_has_no_effect_is_refused(
    option: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert sentence in refused(["optimum", SHORT, *option], capsys)
