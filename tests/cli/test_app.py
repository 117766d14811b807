"""The table of commands: what it says of each, and that a command is all that is imported."""

import inspect
import subprocess
import sys

import pytest
import typer

from otolith.cli.app import COMMANDS, imported
from tests.cli.test_platform import refusal


@pytest.mark.parametrize("name", COMMANDS)
def test_the_line_of_help_is_the_commands_own(name: str) -> None:
    target, line = COMMANDS[name]
    command = imported(target)
    own = command.info.help if isinstance(command, typer.Typer) else inspect.getdoc(command)
    assert own is not None
    assert line == own.split("\n\n")[0].replace("\n", " ")


def loaded_by(line: list[str], heavy: tuple[str, ...]) -> tuple[str, str]:
    """What a command prints, and which of the named modules it has imported, in a process of its own."""
    script = (
        "import sys\nfrom otolith.cli import main\n"
        f"try:\n    main({line!r})\nexcept SystemExit:\n    pass\n"
        f"print('loaded:', *(name for name in {heavy!r} if name in sys.modules))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    shown, _, loaded = done.stdout.rpartition("loaded:")
    return shown, loaded.strip()


def test_help_imports_no_command_and_names_all() -> None:
    shown, loaded = loaded_by(["--help"], ("numpy", "numba", "matplotlib", "scipy"))
    assert all(name in shown for name in COMMANDS)
    assert loaded == ""


@pytest.mark.parametrize(
    ("kind", "one", "light"),
    [
        ("cueing", "predictive", ("numpy",)),
        ("platforms", "davsi", ("numpy",)),
        ("scenarios", "sine-1", ()),
        ("roads", "hockenheim", ()),
    ],
)
def test_a_list_imports_nothing_that_computes(kind: str, one: str, light: tuple[str, ...]) -> None:
    heavy = ("numba", "matplotlib", "h5py", "scipy.signal", "scipy.linalg", "otolith.platforms.platform")
    shown, loaded = loaded_by(["list", kind], (*light, *heavy))
    assert one in shown
    assert loaded == ""


@pytest.mark.parametrize(
    "command",
    [
        "drive circle --roughness C",
        "explicit verify law.h5",
        "live bench",
        "live faults",
        "platform fit davsi",
        "terminal verify sets.h5",
    ],
)
def test_a_negative_seed_is_refused_before_work_begins(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "Invalid value for '--seed'" in refusal([*command.split(), "--seed", "-1"], capsys)


def test_a_refusal_is_one_line_whatever_a_files_name_holds(capsys: pytest.CaptureFixture[str]) -> None:
    said = refusal(["log", "check", "no\nsuch\x1b[2J.csv"], capsys)
    assert said == "otolith: log no\\nsuch\\x1b[2J.csv is absent, must be an existing file\n"
