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


def test_help_imports_no_command_and_names_all() -> None:
    script = (
        "import sys\nfrom otolith.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        "loaded = [name for name in ('numpy', 'numba', 'matplotlib', 'scipy') if name in sys.modules]\n"
        "print('loaded:', loaded)\n"
    )
    shown = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout
    assert all(name in shown for name in COMMANDS)
    assert "loaded: []" in shown
