"""`otolith platform` as a user meets it."""

import json
import math
import re
from pathlib import Path
from typing import Literal

import pytest

from otolith import files
from otolith.cli import main
from otolith.core.frames import DOFS
from otolith.loop import Run
from otolith.platforms import parse_platform
from otolith.platforms.combined_limits import together
from otolith.platforms.template import template
from otolith.report.platform_page import file_share
from otolith.stored import read_run


def refusal(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    return capsys.readouterr().err


SHOW = ["platform", "show", "davsi"]


def test_show_writes_page_figure_and_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], handmade: Run
) -> None:
    files.write_run(handmade, tmp_path / "run.h5")
    out = tmp_path / "out"
    with pytest.raises(SystemExit) as caught:
        main([*SHOW, "--run", str(tmp_path / "run.h5"), "--out", str(out), "--figures", "--json"])
    assert caught.value.code == 0
    output = capsys.readouterr()
    assert json.loads(output.out) == json.loads((out / "platform.json").read_text())
    assert "surge: -0.496 to 0.627 m" in output.err
    assert "nobody on by hand" in (out / "platform.html").read_text()
    assert (out / "platform.png").stat().st_size > 10_000


def test_fit_writes_a_geometry(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["platform", "fit", "davsi", "--starts", "3", "--out", str(tmp_path / "legs.toml"), "--json"])
    assert caught.value.code == 0
    output = capsys.readouterr()
    answer = json.loads(output.out)
    assert answer["toml"] == (tmp_path / "legs.toml").read_text()
    assert answer["toml"].startswith("[hexapod]")
    assert " of 3 starts came as near" in output.err
    with pytest.raises(SystemExit):
        main(["platform", "fit", "davsi", "--leg", "1.297,1.937", "--starts", "3"])
    assert capsys.readouterr().out == answer["toml"]


@pytest.mark.parametrize("leg", ["1.3", "2,1", "a,b", "0.001,2"])
def test_wrong_leg_lengths_are_refused(leg: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert f"--leg is '{leg}', must be" in refusal(["platform", "fit", "davsi", "--leg", leg], capsys)


def test_without_legs_none_are_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["platform", "show", "benchmark", "--out", str(tmp_path)])
    assert caught.value.code == 0
    output = capsys.readouterr().err
    assert "surge: -2.600 to 2.600 m (the file)" in output
    assert "The file describes no legs" in output
    assert {path.name for path in tmp_path.iterdir()} == {".otolith", "platform.html", "platform.json"}


@pytest.mark.parametrize("kind", ["legs", "axes"])
def test_a_new_file_loads_as_it_stands_and_its_comments_do_when_used(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every field of the format stands in the template, used or behind a comment mark, and loads."""
    path = tmp_path / "rig.toml"
    with pytest.raises(SystemExit) as caught:
        main(["platform", "new", f"--{kind}", "--out", str(path)])
    assert caught.value.code == 0
    platform = files.read_platform(str(path))
    assert (platform.hexapod is not None) == (kind == "legs")
    assert "surge" in platform.axes
    used = [
        line.removeprefix("# ") if re.match(r"# (\[|\w+ = )", line) else line
        for line in path.read_text().splitlines()
    ]
    used = [line for line in used if not line.startswith(("base_m", "platform_m", "[hexapod.joints]"))]
    full = parse_platform("\n".join(used), "all of it")
    assert full.actuators.lag_s == 0.01
    assert len(full.axes) == 6
    capsys.readouterr()
    with pytest.raises(SystemExit):
        main(["platform", "new", f"--{kind}"])
    assert capsys.readouterr().out == path.read_text()
    assert "is there already, must be another one, or --force" in refusal(
        ["platform", "new", f"--{kind}", "--out", str(path)], capsys
    )


@pytest.mark.parametrize("name", ["legs", "cranks"])
def test_the_template_of_legs_keeps_what_it_promises(name: Literal["legs", "cranks"]) -> None:
    """All of its limits at once are within the legs, which `together` proves for four axes."""
    platform = parse_platform(template(name), f"{name}.toml")
    found = together(platform)
    assert (found.reach, found.speed, found.acceleration) == (1.0, 1.0, 1.0)
    assert file_share(platform) == 1.0


def test_four_posts_lift_every_corner_within_their_stroke(capsys: pytest.CaptureFixture[str]) -> None:
    """What the template says of its limits: all axes at once use the whole stroke, 100 mm, and no more."""
    with pytest.raises(SystemExit):
        main(["platform", "new", "--like", "posts"])
    posts = parse_platform(capsys.readouterr().out, "posts.toml")
    assert posts.axes == ("heave", "roll", "pitch")
    assert posts.heave is not None
    assert posts.roll is not None
    assert posts.pitch is not None
    up = posts.heave.position_m[1]
    along, across = (math.radians(axis.angle_deg[1]) for axis in (posts.pitch, posts.roll))
    highest = up + 0.65 * math.sin(along) + 0.275 * math.sin(across)
    assert 0.0495 < highest <= 0.05


def test_the_seat_of_the_template_is_cued_sideways() -> None:
    seat = parse_platform(template("seat"), "seat.toml")
    assert [dof.name for dof in DOFS.values() if seat.can_cue(dof)] == ["sway-roll"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "--legs, --axes, --like is missing, must be one of the three"),
        (["--legs", "--axes"], "--legs, --axes, --like is more than one given, must be one of the three"),
        (["--like", "crank"], "--like is 'crank', must be one of cranks, posts, seat (did you mean cranks?)"),
        (["--legs", "--out", "rig.txt"], "name of the output is rig.txt, must be a name that ends in .toml"),
    ],
)
def test_a_new_file_needs_its_kind(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in refusal(["platform", "new", *options], capsys)


def test_the_supervisors_interventions_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Far beyond the machine: the run goes on, within the legs, and says what the legs could not do."""
    line = "run step:amplitude=6,end=4.9,duration=5 --cueing implicit --plant hexapod --platform davsi"
    with pytest.raises(SystemExit) as caught:
        main([*line.split(), "--out", str(tmp_path)])
    assert caught.value.code == 0
    output = [line for line in capsys.readouterr().err.splitlines() if line.startswith("note: supervisor, ")]
    assert 0 < len(output) <= 6  # the longest five, and how many besides
    assert len(output) < 6 or "shorter interventions besides" in output[5]
    kept = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["supervisor"]
    run = read_run(tmp_path / "run.h5")
    assert sum(one["times"] for one in kept.values()) == len(run.interventions) > 0
    seconds = sum(one["seconds"] for one in kept.values())
    assert seconds == pytest.approx(sum(one.end - one.start for one in run.interventions))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    for limit, one in kept.items():
        assert f"he supervisor acted for {limit}: {one['times']} times" in page


@pytest.mark.parametrize(
    ("soft", "words"),
    [
        ("tilt=x", "--soft tilt is 'x', must be a number"),
        ("tilt_rate=-1", "penalty of tilt_rate is -1, must be from 1e-12 to 1e+12"),
        ("command=3", "--soft is 'command', must be one of tilt_rate, tilt"),
    ],
)
def test_wrong_slacks_are_refused(soft: str, words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert words in refusal(["run", "sine-0.5", "--soft", soft], capsys)
