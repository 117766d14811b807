"""The table of commands: what it says of each, and that a command is all that is imported."""

import inspect
import subprocess
import sys

import pytest
import typer

from otolith.cli.app import COMMANDS, imported


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
