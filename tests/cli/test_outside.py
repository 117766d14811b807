"""An algorithm in a file of one's own, and one of an installed package, on the command line."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from otolith.cli.example import _SAMPLES
from tests.cli.test_cli import done, refused
from tests.core.test_plugins import distribution, site

__all__ = ["site"]  # a fixture

PROGRAM = "from otolith.cli import main; main()"  # as the script that pip installs
WANTED = "sine:amplitude=0.8,frequency=0.3,duration=3"


@pytest.fixture
def washout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The washout of `otolith example`, named as from the folder above."""
    (tmp_path / "mine").mkdir()
    shutil.copy(str(_SAMPLES / "washout.py"), tmp_path / "mine" / "washout.py")
    monkeypatch.chdir(tmp_path)
    return "mine/washout.py:HighPass"


def test_a_file_of_ones_own_runs_from_another_folder(
    washout: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    done(["run", WANTED, "--cueing", washout, "--json"])
    summary = json.loads(capsys.readouterr().out)
    assert summary["cueing"] == washout
    assert 0.0 < summary["rmse"] < summary["wanted_rms"]["surge-pitch"]
    (folder,) = (tmp_path / "out").iterdir()
    assert folder.name.endswith("-mine_washout.py_HighPass")


def test_it_stands_in_a_comparison(washout: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    done(["compare", WANTED, "--cueing", washout, "--cueing", "classical", "--out", "o", "--json"])
    assert set(json.loads(capsys.readouterr().out)) == {washout, "classical"}
    assert {path.name for path in (tmp_path / "o").glob("*.h5")} == {
        "classical.h5",
        "mine_washout.py_HighPass.h5",
    }
    assert washout in (tmp_path / "o" / "report.html").read_text()


def test_from_the_installed_program_in_another_process(washout: str) -> None:
    line = [sys.executable, "-c", PROGRAM, "run", WANTED, "--cueing", washout, "--out", "p"]
    ran = subprocess.run(line, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    assert "no decision failed" in ran.stderr


@pytest.mark.parametrize(
    ("name", "bound"),
    [
        ("mine/washout.py:LowPass", "an attribute of mine/washout.py, such as HighPass"),
        ("mine/absent.py:HighPass", "does not exist"),
        ("absent_module:HighPass", "not installed"),
        ("mine/washout.py:SURGE", "a class or function"),
        ("json:dumps", "takes an argument 'design', or none"),
        ("builtins:object", "without period and reset and step"),
        ("washout", "must be one of predictive, explicit"),
    ],
)
def test_what_is_no_algorithm_is_refused(
    washout: str, name: str, bound: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bound in refused(["run", WANTED, "--cueing", name], capsys)
    assert not Path("out").exists()


def test_what_it_raises_is_one_sentence(washout: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("bad.py").write_text(
        "class Bad:\n    period = 0.01\n    def reset(self, state): pass\n"
        "    def step(self, state, reference): return 1 / 0\n"
        "class Odd(Bad):\n    period = 0.0015\n"
    )
    message = refused(["run", WANTED, "--cueing", "bad.py:Bad"], capsys)
    assert message.endswith("failed in step: ZeroDivisionError: division by zero (line 4 of bad.py)")
    assert "must be a multiple of 0.001 s" in refused(["run", WANTED, "--cueing", "bad.py:Odd"], capsys)
    assert not Path("out").exists()


def test_an_option_that_it_does_not_read_is_refused(washout: str, capsys: pytest.CaptureFixture[str]) -> None:
    line = ["run", WANTED, "--cueing", washout, "--horizon", "20"]
    assert f"--horizon is given, but {washout} would ignore it" in refused(line, capsys)
    source = Path("mine/washout.py").read_text()
    Path("reads.py").write_text(
        source.replace("    period = 0.01", '    reads = {"horizon"}\n    period = 0.01')
    )
    done(["run", WANTED, "--cueing", "reads.py:HighPass", "--horizon", "20", "--out", "r"])


def test_an_installed_package_adds_an_algorithm(
    washout: str, site: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ("high-pass = theirs:HighPass", "implicit = theirs:HighPass", "cracked = theirs:Nothing")
    entry_points = "\n".join(["[otolith.cueing]", *names])
    distribution(site, "theirs", entry_points, Path("mine/washout.py").read_text())
    done(["list", "cueing", "--json"])
    listed = json.loads(capsys.readouterr().out)
    assert listed["high-pass"] == "from theirs 1.0"
    assert listed["implicit"] == "implicit MPC without a guess (model 1)"  # ours stands
    done(["list", "cueing"])
    assert "'implicit' of theirs 1.0 is left out" in " ".join(capsys.readouterr().err.split())
    done(["run", WANTED, "--cueing", "high-pass", "--out", "h"])
    capsys.readouterr()
    message = refused(["run", WANTED, "--cueing", "cracked"], capsys)
    assert "'cracked' of theirs 1.0 could not be imported: AttributeError" in message


def test_an_installed_package_adds_a_plant_and_a_format(
    washout: str, site: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = """
import numpy as np
from otolith.plant import Ideal
from otolith.recordings.recorded import Columns
from otolith.recordings.channels import Layout

def plant(platform):
    return Ideal()

def read(path):
    t, ax = np.loadtxt(path, skiprows=1).T
    return Columns(source=path.name, names=("t_s", "ax_mps2"), units=("", ""), values=(t, ax),
                   layout=Layout(form="two columns", rows=len(t)))
"""
    distribution(
        site,
        "more",
        "[otolith.plants]\nmine = more:plant\n[otolith.formats]\ntwo = more:read\ncsv = more:no\n",
        source,
    )
    t = np.arange(0.0, 3.0, 0.02)
    for name in ("drive.two", "drive.csv"):
        comma = "," if name.endswith("csv") else " "
        rows = [f"{a:.2f}{comma}{b:.4f}" for a, b in zip(t, np.sin(t) ** 2, strict=True)]
        Path(name).write_text("\n".join([f"t_s{comma}ax_mps2", *rows]))
        done(["run", "--log", name, "--cueing", washout, "--plant", "mine", "--out", name[-3:]])
    a, b = (json.loads((Path(name) / "summary.json").read_text()) for name in ("two", "csv"))
    assert a["plant"] == "mine"
    assert a["rmse"] == b["rmse"] > 0.0
