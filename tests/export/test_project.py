"""The folder that `otolith export c` writes: it builds without warnings, and its test program judges."""

import json
import re
import subprocess
from pathlib import Path

import pytest

from otolith.cli.app import run_program
from otolith.export.guards import gating
from otolith.platforms import load
from tests.export.in_c import COMPILER, STRICT, needs_compiler


def _exported(folder: Path, *options: str, code: int = 0) -> None:
    cueing = [] if "--cueing" in options else ["--cueing", "classical"]
    with pytest.raises(SystemExit) as ended:
        run_program(["export", "c", *cueing, "--out", str(folder), *options])
    assert ended.value.code == code


def _replay(folder: Path, name: str, *flags: str) -> subprocess.CompletedProcess[str]:
    sources = [str(folder / f"{name}.c"), str(folder / f"{name}_test.c")]
    built = folder / "replay"
    line = [str(COMPILER), *STRICT, *flags, *sources, "-lm", "-o", str(built)]
    subprocess.run(line, check=True, capture_output=True, text=True)
    return subprocess.run(
        [str(built), str(folder / "vectors.txt")], check=False, capture_output=True, text=True
    )


@needs_compiler
@pytest.mark.parametrize("kind", ["command", "platform"])
def test_its_vectors_are_replayed_under_sanitizers(kind: str, tmp_path: Path) -> None:
    folder = tmp_path / "out"
    _exported(
        folder, "--kind", kind, "--name", "washout", "--dofs", "surge-pitch,heave", "--platform", "davsi"
    )
    done = _replay(folder, "washout", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith("1000 steps")


@needs_compiler
@pytest.mark.parametrize("kind", ["gate", "supervisor"])
def test_a_guard_is_a_project_too(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "out"
    with pytest.raises(SystemExit) as ended:
        run_program(["export", "c", "--kind", kind, "--platform", "davsi", "--out", str(folder), "--json"])
    assert ended.value.code == 0
    assert json.loads(capsys.readouterr().out)["period_s"] == 0.001
    assert "-ffp-contract=off" in (folder / "CMakeLists.txt").read_text()
    done = _replay(folder, "cueing", "-O1")
    assert done.stdout.startswith("2000 steps, largest difference 0.0e+00"), done.stdout + done.stderr


@needs_compiler
def test_a_wrong_answer_is_found(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    _exported(folder)
    header = folder / "cueing.h"
    header.write_text(header.read_text().replace("9.81", "9.80"))
    done = _replay(folder, "cueing")
    assert done.returncode == 1
    assert " 0 numbers beyond" not in done.stdout


def test_json_names_the_ports(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _exported(tmp_path / "out", "--json")
    account = json.loads(capsys.readouterr().out)
    assert account["inputs"][:2] == ["wanted_force_x", "wanted_force_y"]
    assert account["outputs"][0] == "command_surge"
    assert len(account["inputs"]) == 24


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--kind", "mex"], "--kind is 'mex', must be one of command, platform"),
        (["--name", "2nd"], "name of the program is '2nd', must be letters"),
        (["--cueing", "explicit"], "--cueing is 'explicit', must be one that decides without Python"),
        (["--name", "main"], "name of the program is 'main', must be one that has no meaning yet"),
        (["--horizon", "20"], "would ignore it"),
        (["--cueing", "predictive", "--solver", "dense"], "one that asks for the engine CondensedEngine"),
        (["--set-points", "legs"], "--set-points is given with --kind command, must be left out"),
        (["--kind", "gate"], "--cueing is given with --kind gate, must be left out"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    options: list[str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _exported(tmp_path / "out", *options, code=2)
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@needs_compiler
def test_the_example_of_a_host_runs(tmp_path: Path) -> None:
    folder = tmp_path / "cueing"
    _exported(folder, "--kind", "platform")
    host, built = Path(__file__).parents[2] / "examples" / "c" / "main.c", tmp_path / "main"
    line = [
        str(COMPILER),
        *STRICT,
        f"-I{folder}",
        str(host),
        str(folder / "cueing.c"),
        "-lm",
        "-o",
        str(built),
    ]
    subprocess.run(line, check=True, capture_output=True, text=True)
    done = subprocess.run([str(built)], check=True, capture_output=True, text=True)
    assert done.stdout.count("status 0") == 12


@needs_compiler
def test_the_example_of_a_chain_keeps_the_limits(tmp_path: Path) -> None:
    """A washout that asks for too much is stopped by the gate, within the reach of `davsi`."""
    kinds = {"cueing": ["--cueing", "classical"], "gate": ["--kind", "gate"]}
    kinds["supervisor"] = ["--kind", "supervisor"]
    for name, options in kinds.items():
        line = ["export", "c", *options, "--platform", "davsi", "--name", name, "--out", str(tmp_path / name)]
        with pytest.raises(SystemExit) as ended:
            run_program(line)
        assert ended.value.code == 0
    host, built = Path(__file__).parents[2] / "examples" / "c" / "guarded.c", tmp_path / "guarded"
    sources = [str(host), *(str(tmp_path / name / f"{name}.c") for name in kinds)]
    folders = [f"-I{tmp_path / name}" for name in kinds]
    line = [str(COMPILER), *STRICT, "-ffp-contract=off", *folders, *sources, "-lm", "-o", str(built)]
    subprocess.run(line, check=True, capture_output=True, text=True)
    told = subprocess.run([str(built)], check=True, capture_output=True, text=True).stdout
    surge, refused, slowed = re.findall(r"up to ([\d.]+) m; .* refused (\d+) .* in (\d+);", told)[0]
    assert 0.1 < float(surge) <= gating(load("davsi")).values.bounds.high[0]
    assert int(refused) > 100
    assert int(slowed) == 0  # what the gate passes, the legs can do


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["gate"], "--platform is thesis, must be a machine's"),
        (["supervisor", "--platform", "benchmark"], "legs"),
        (["gate", "--platform", "davsi", "--dofs", "heave"], "--dofs is given with --kind gate"),
        (["gate", "--platform", "davsi", "--set-points", "legs"], "--set-points is given with --kind gate"),
        (["supervisor", "--platform", "davsi", "--set-points", "x"], "must be one of pose, legs"),
        (["gate", "--platform", "davsi", "--period", "1"], "--period is 1 s, must be 0.00001 to 0.05 s"),
    ],
)
def test_what_no_guard_can_be_is_one_sentence(
    options: list[str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        run_program(["export", "c", "--out", str(tmp_path / "out"), "--kind", *options])
    assert ended.value.code == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
