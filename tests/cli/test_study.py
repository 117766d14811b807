"""`otolith study` as its user meets it, on a tiny study of real loops."""

import csv
import json
import os
import signal
import time
import tomllib
from pathlib import Path

import pytest

from otolith.cli import main
from otolith.cueing.washout.tuning import parse_tuning
from otolith.files import read_run
from otolith.studies.measures import MEASURES
from tests.cli.test_platform import refusal

TINY = """
name = "tiny"
cueing = "classical"
training = ["step:amplitude=0.5,duration=1.5,end=1.3", "sine:amplitude=0.5,frequency=0.5,duration=2"]
judging = ["step:amplitude=0.8,duration=1.5,end=1.2"]
objectives = [{ measure = "tracking" }, { measure = "travel", over = "worst" }]
[parameters]
"tuning.classical.surge.natural_radps" = { scale = "log", low = 0.5, high = 8.0 }
[[start]]
"tuning.classical.surge.natural_radps" = 1.5
[budget]
trials = 4
batch = 2
[presets.calm]
travel = 1.0
"""


def called(words: str, capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    with pytest.raises(SystemExit) as ended:
        main(words.split())
    assert ended.value.code == 0
    printed = capsys.readouterr()
    return printed.out, " ".join(printed.err.split())


def test_a_study_from_its_file_to_a_tuning_that_run_takes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tiny.toml").write_text(TINY, encoding="utf-8")
    _, said = called("study run tiny.toml --jobs 1", capsys)
    assert "2 loops of a sample are equal, bit for bit" in said or "1 loops of a sample" in said
    store = "out/tiny.journal"
    assert "which exists" in refusal(["study", "run", "tiny.toml"], capsys)

    shown = json.loads(called(f"study show {store} --json", capsys)[0])
    assert shown["trials"] == {"of": 4, "open": 0, "done": 4, "pruned": 0, "rejected": 0}
    assert shown["agreement"]["different"] == []
    assert all(one["judging"] is not None for one in shown["front"])
    assert "4 of 4 trials done" in called(f"study show {store} --page front.html", capsys)[1]
    page = Path("front.html").read_text("utf-8")
    assert "otolith study export out/tiny.journal --preset calm --out calm.toml" in page
    assert f'<th scope="row">{shown["front"][0]["trial"]}</th>' in page

    best = json.loads(called(f"study best {store} --preset calm --json", capsys)[0])
    assert best["training"]["travel"] == min(one["training"]["travel"] for one in shown["front"])
    called(f"study export {store} --preset calm --out calm.toml", capsys)
    tuning = parse_tuning(Path("calm.toml").read_text("utf-8"), "calm.toml")
    assert tuning.classical is not None
    assert tuning.classical.surge.natural_radps == best["settings"]["tuning.classical.surge.natural_radps"]

    _, said = called(f"study export {store} --preset calm --out calm.toml", capsys)
    command = said[said.index("otolith run") :].removeprefix("otolith ").split()
    called(" ".join([*command, "--json", "--out", "cued", "--no-optimum"]), capsys)
    again = {name: MEASURES[name].of(read_run(Path("cued/run.h5")), 0.0) for name in best["judging"]}
    assert again == best["judging"]

    called(f"study resume {store} --trials 6 --jobs 1", capsys)
    called(f"study export {store} --out all.csv", capsys)
    rows = list(csv.reader(Path("all.csv").read_text("utf-8").splitlines()))
    assert len(rows) == 7
    assert rows[1][2] == "1.5"
    Path("tiny.toml").write_text(TINY.replace("trials = 4", "trials = 6"), encoding="utf-8")
    called("study run tiny.toml --jobs 1 --store again.journal", capsys)
    called("study export again.journal --out again.csv", capsys)
    assert Path("again.csv").read_text("utf-8") == Path("all.csv").read_text("utf-8")


def test_a_study_of_an_mpc_exports_settings_and_a_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from otolith.studies.definition import load_study
    from otolith.studies.export import settings_text

    study = load_study("predictive")
    text = settings_text(study, study.start[0], "shipped", "step-1")
    assert "--weight velocity=0.0348" in text
    assert "--blocks 1,1," in text
    assert "--control-weight 2e-05" in text
    assert tomllib.loads(text)["settings"] == study.start[0]


def test_an_interruption_says_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tiny.toml").write_text(TINY, encoding="utf-8")

    def interrupted(_: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(10.0)  # another thread may receive it; this one is then interrupted a little later

    signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background begins without one

    with monkeypatch.context() as patch:
        patch.setattr("otolith.studies.search.Search.run", interrupted)
        with pytest.raises(SystemExit) as ended:
            main(["study", "run", "tiny.toml", "--jobs", "1"])
    assert ended.value.code == 130
    said = " ".join(capsys.readouterr().err.split())
    assert "interrupted; otolith study resume out/tiny.journal goes on where it is" in said
    called("study resume out/tiny.journal --jobs 1", capsys)
    assert "--trials is 3, must be at least 4" in refusal(
        ["study", "resume", "out/tiny.journal", "--trials", "3"], capsys
    )
    assert "--trials is 0" in refusal(["study", "resume", "out/tiny.journal", "--trials", "0"], capsys)


NATURAL = '"tuning.classical.surge.natural_radps"'


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            NATURAL,
            '"tuning.classical.nonsense"',
            "start.0 of tiny is refused (parameter is 'tuning.classical.non",
        ),
        (
            f"[[start]]\n{NATURAL} = 1.5",
            "",
            "trials of tiny that could be done is 0 of 4; the first was refused",
        ),
        (
            '"classical"',
            '"classical"\ndofs = "yaw"',
            "dofs of a study is yaw, must be one with a specific force",
        ),
        ('"classical"', '"classical"\nplant = "ideel"', "did you mean ideal?"),
    ],
)
def test_a_study_that_could_do_no_loop_says_why(
    old: str,
    new: str,
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    text = TINY.replace(old, new)
    if not new:
        text = text.replace(NATURAL, '"tuning.classical.nonsense"')
    Path("tiny.toml").write_text(text, encoding="utf-8")
    assert words in refusal(["study", "run", "tiny.toml", "--jobs", "1"], capsys)


def test_commands_name_files_from_where_one_is_and_treat_a_drive_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    called("example --out deep", capsys)
    drive = '{ log = "drive.csv", to_s = 10.0 }'
    judged = '{ log = "drive.csv", from_s = 30.0, to_s = 36.0, lowpass_hz = 5.0, scale = 0.5 }'
    text = TINY.replace('"classical"', '"classical"\nplatform = "rig.toml"').replace(
        "trials = 4", "trials = 2"
    )
    for old, new in (("training", drive), ("judging", judged)):
        begin = text.index(f"{old} = [")
        text = text[:begin] + f"{old} = [{new}]" + text[text.index("]", begin) + 1 :]
    text = text.replace("objectives", "constraints = []\nobjectives", 1)
    Path("deep/tiny.toml").write_text(text, encoding="utf-8")
    called("study run deep/tiny.toml --jobs 1", capsys)
    _, said = called("study best out/tiny.journal", capsys)
    words = (
        "otolith run --log deep/drive.csv --lowpass 5 --scale 0.5 --cueing classical --platform deep/rig.toml"
    )
    assert f"{words} --tuning tuned.toml" in said


def test_what_is_no_study_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "must be a file of 'otolith study run'" in refusal(["study", "show", str(tmp_path / "no")], capsys)
    other = tmp_path / "other.journal"
    other.write_text("no journal\n", encoding="utf-8")
    assert "is no sound study" in refusal(["study", "show", str(other)], capsys)
    assert "did you mean classical" in refusal(["study", "run", "clasical"], capsys)


def test_weights_are_read_off_a_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    wanted = "sine:amplitude=1,frequency=0.2,duration=5"
    weights = "--weight velocity=0.1 --weight position=0.02"  # on the default's states, which are compiled
    called(f"run {wanted} --cueing implicit {weights} --out a --no-optimum", capsys)
    found = json.loads(called("study inverse a/run.h5 --on velocity,position --json", capsys)[0])
    assert found["weights"]["velocity"] == pytest.approx(0.1, rel=1e-6)
    assert found["weights"]["position"] == pytest.approx(0.02, rel=1e-6)
    assert "0.1" in called("study inverse a/run.h5 --on velocity,position", capsys)[0]
