"""Every word of every help text reaches the screen, brackets and all; and so do messages and tables."""

import inspect
import io
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer
from rich.table import Table

from otolith import __version__
from otolith.cli import main, output
from otolith.cli.app import COMMANDS, program

SOURCE = Path(inspect.getfile(program)).parent


def commands(name: str) -> Iterator[tuple[list[str], Any]]:
    """A command and those below it, each with the words that call it."""
    command = typer.main.get_command(program(name)).commands[name]  # type: ignore[attr-defined]
    yield [name], command
    for below, own in getattr(command, "commands", {}).items():
        yield [name, below], own


def shown(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """What the program prints, in one line."""
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 0
    return flat(capsys.readouterr().out)


def flat(text: str) -> str:
    """A text without line ends, which wrapping puts after blanks and hyphens."""
    return re.sub(r"\s+", "", text)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_help_text_is_shown_as_its_source_says_it(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    written = "".join(flat(path.read_text("utf-8")) for path in SOURCE.glob("*.py"))
    for words, command in commands(name):
        text = shown([*words, "-h"], capsys)
        assert text == shown([*words, "--help"], capsys)
        assert flat(inspect.cleandoc(command.help)) in text
        for parameter in command.params:
            about = flat(getattr(parameter, "help", None) or "")
            assert about in text, parameter.name
            if "[" in about:  # or the comparison were worth nothing: brackets could be lost before it
                assert about in written


def test_units_in_brackets_are_among_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert flat("No faster than this [km/h].") in shown(["drive", "--help"], capsys)


def test_the_program_tells_its_options_and_all_commands(capsys: pytest.CaptureFixture[str]) -> None:
    text = shown(["-h"], capsys)
    for option in ("--version", "--debug", "--install-completion", "--help"):
        assert option in text
    assert all(flat(line) in text for _, line in COMMANDS.values())
    main(["--version"])
    assert capsys.readouterr().out == f"otolith {__version__}\n"


@pytest.mark.parametrize(
    ("line", "offered"),
    [("otolith pl", "platform"), ("otolith drive --spe", "--speed"), ("otolith explicit bui", "build")],
)
def test_the_shell_completes_commands_and_options(
    line: str, offered: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "environ", {**os.environ, "_OTOLITH_COMPLETE": "complete_bash"})
    monkeypatch.setitem(os.environ, "COMP_WORDS", line)
    monkeypatch.setitem(os.environ, "COMP_CWORD", str(len(line.split()) - 1))
    with pytest.raises(SystemExit):
        main([])
    assert offered in capsys.readouterr().out


def test_tables_and_messages_keep_their_brackets(monkeypatch: pytest.MonkeyPatch) -> None:
    console = output.screen(stderr=False, wide=True)
    console.file = io.StringIO()
    table = Table("RMSE [m/s²]", "travel [m]")
    table.add_row("[red]1.0[/red]", ":smile: [km/h]")
    console.print(table)
    console.print("speed [km/h] of lap[1].csv")
    for text in ("RMSE [m/s²]", "[red]1.0[/red]", ":smile: [km/h]", "speed [km/h] of lap[1].csv"):
        assert text in console.file.getvalue()


def test_no_command_makes_a_console_that_reads_markup() -> None:
    made = [path.name for path in SOURCE.glob("*.py") if "Console(" in path.read_text("utf-8")]
    assert sorted(made) == ["app.py", "output.py"]
