"""An option that would have no effect is refused in one sentence, whatever the command."""

import itertools
from pathlib import Path
from typing import Any

import pytest
import typer

from otolith.cli.app import COMMANDS, program
from otolith.cli.given import NEEDS, OVERRULED, called, refuse_lost
from otolith.cli.reading import OPTIONS
from otolith.core.errors import InputError
from tests.cli.test_platform import refusal

PAIRS = [
    (command, option, other, needed)
    for table, needed in ((NEEDS, True), (OVERRULED, False))
    for command, options in table.items()
    for option, other in options.items()
]


def line_of(command: str, *options: str) -> tuple[Any, list[str]]:
    """The program with this command, and a line that calls it with these options."""
    made = typer.main.get_command(program(command.split()[0]))
    known = called(made, command.split()).options
    words = [[known[name].opts[0]] + ([] if known[name].is_flag else ["1"]) for name in options]
    return made, [*command.split(), *itertools.chain(*words)]


@pytest.mark.parametrize(("command", "option", "other", "needed"), PAIRS)
def test_an_option_is_refused_without_what_it_needs_or_with_what_overrules_it(
    command: str, option: str, other: str, needed: bool
) -> None:
    words = "must be used together with" if needed else "must be left out with"
    lost, taken = ([option], [option, other]) if needed else ([option, other], [option])
    with pytest.raises(InputError, match=f"is given, {words} --{other.replace('_', '-')}$"):
        refuse_lost(*line_of(command, *lost))
    refuse_lost(*line_of(command, *taken))


def test_every_option_of_a_log_needs_one() -> None:
    """Whoever adds an option for logs is reminded to add it here."""
    for command in ("run", "compare"):
        assert {"lowpass", "causal", *OPTIONS} == {o for o, other in NEEDS[command].items() if other == "log"}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_option_of_every_command_is_refused_twice_unless_it_repeats(name: str) -> None:
    made: Any = typer.main.get_command(program(name))
    for command in [name, *(f"{name} {sub}" for sub in getattr(made.commands[name], "commands", ()))]:
        for option, one in called(made, command.split()).options.items():
            if one.param_type_name != "option" or one.multiple or one.is_flag:
                continue
            with pytest.raises(InputError, match="is given twice, must be given once"):
                refuse_lost(*line_of(command, option, option))


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("run sine-1 --literal", "--literal is given, but sine-1 would ignore it"),
        ("run step:end=3 --literal", "--literal is given, but step:end=3 would ignore it"),
        ("compare sine-1 sine-2 --literal", "but sine-1 and sine-2 would ignore it"),
        ("drive circle --seed 4", "--seed is given, must be used together with --roughness"),
        ("drive circle --smoothing 1", "must be left out, for 'circle' is not a file of points"),
    ],
)
def test_what_a_value_makes_pointless_is_refused(
    line: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in refusal(line.split(), capsys)


def test_lines_of_a_table_are_not_told_of_other_formats(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drive = tmp_path / "drive.json"
    drive.write_text('[{"t_s": 0, "ax_mps2": 0}, {"t_s": 1, "ax_mps2": 0}]', encoding="utf-8")
    for option in ("--header", "--units"):
        message = refusal(["log", "check", str(drive), option, "2", "--out", str(tmp_path / "x.png")], capsys)
        assert f"{option} is given, must be left out, for drive.json is no table of text" in message


@pytest.mark.parametrize("words", [["--plant="], ["--plant", ""]])
def test_an_empty_value_is_refused_instead_of_counting_as_none(words: list[str]) -> None:
    made: Any = typer.main.get_command(program("run"))
    with pytest.raises(InputError, match=r"^--plant is empty, must be given a value, or left out$"):
        refuse_lost(made, ["run", "sine-1", *words])
    refuse_lost(made, ["run", "--json", ""])  # here the empty word is the scenario, which is refused later
