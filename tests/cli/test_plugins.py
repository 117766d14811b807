"""Commands that other distributions add, each installed as pip would leave it: files beside its metadata."""

import sys
from pathlib import Path

import pytest

from otolith.cli import app, main, plugins
from otolith.core import plugins as core

GREET = "def greet(name: str) -> None:\n    '''Greet.'''\n    print(f'hello {name}')\n"


def install(
    folder: Path, commands: dict[str, str], source: str = GREET, *, name: str = "greeter", about: str = ""
) -> None:
    """Lay a distribution into a folder; `commands` is its entry points, "module:attribute" by name."""
    (folder / f"{name}.py").write_text(source)
    metadata = folder / f"{name}-1.2.dist-info"
    metadata.mkdir()
    summary = f"Summary: {about}\n" if about else ""
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.2\n{summary}")
    lines = [f"[{plugins.GROUP}]", *(f"{command} = {target}" for command, target in commands.items())]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of installed distributions."""
    monkeypatch.syspath_prepend(tmp_path)
    core._search.cache_clear()
    monkeypatch.setattr(core, "_search", core._search.__wrapped__)
    for module in ("greeter", "other"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    return tmp_path


def refusal(line: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    """The one sentence with which a line is refused."""
    with pytest.raises(SystemExit) as ended:
        main(line)
    output = capsys.readouterr()
    assert (ended.value.code, output.out) == (2, "")
    assert "Traceback" not in output.err
    assert output.err.count("\n") == 1
    return output.err


def test_a_command_from_outside_runs_and_stands_in_the_help(
    site: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install(site, {"greet": "greeter:greet"}, about="Greet somebody.")
    with pytest.raises(SystemExit) as ended:
        main(["greet", "you"])
    assert (ended.value.code, capsys.readouterr().out) == (0, "hello you\n")
    with pytest.raises(SystemExit):
        main(["--help"])
    shown = capsys.readouterr().out
    assert "Greet somebody." in shown
    assert "Not offered" not in shown


def test_a_group_of_commands_from_outside_is_a_group(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = f"import typer\napp = typer.Typer()\n{GREET}app.command()(greet)\napp.command('wave')(greet)\n"
    install(site, {"greeting": "greeter:app"}, source)
    with pytest.raises(SystemExit):
        main(["greeting", "wave", "you"])
    assert capsys.readouterr().out == "hello you\n"


def test_the_help_imports_no_command_from_outside(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(site, {"greet": "greeter:greet"}, "raise SystemError('imported')\n")
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    assert "A command of greeter 1.2." in capsys.readouterr().out
    assert "greeter" not in sys.modules


@pytest.mark.parametrize(
    ("source", "target", "reason"),
    [
        ("import nowhere_to_be_found\n", "greeter:greet", "No module named 'nowhere_to_be_found'"),
        ("x = 1\n", "greeter:greet", "has no attribute 'greet'"),
        ("def greet(:\n", "greeter:greet", "SyntaxError"),
        ("raise ValueError\n", "greeter:greet", "ValueError"),
        ("greet = 3\n", "greeter:greet", "3 is neither a function nor a typer.Typer"),
        ("def greet(name: int | str) -> None: ...\n", "greeter:greet", "Union types"),
        ("import typer\ngreet = typer.Typer()\n", "greeter:greet", "RuntimeError"),
        (GREET, "greeter.gone:greet", "greeter.gone"),
        (GREET, "no target at all", "could not be imported"),
    ],
)
def test_a_broken_command_is_one_sentence_that_says_whose_it_is(
    source: str, target: str, reason: str, site: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install(site, {"greet": target}, source)
    message = refusal(["greet", "you"], capsys)
    assert "otolith.commands 'greet' of greeter 1.2" in message
    assert reason in message


def test_the_programs_own_commands_stay_its_own(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(site, {"list": "greeter:greet", "greet": "greeter:greet"})
    with pytest.raises(SystemExit):
        main(["list", "scenarios"])
    assert "sine-1" in capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["--help"])
    shown = " ".join(capsys.readouterr().out.split())
    assert "Not offered, since Otolith has commands of that name: list of greeter 1.2." in shown
    assert shown.count(app.COMMANDS["list"][1]) == 1


def test_of_two_commands_of_one_name_neither_is_taken(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install(site, {"greet": "greeter:greet"})
    install(site, {"greet": "other:greet"}, name="other")
    message = refusal(["greet", "you"], capsys)
    assert "greeter 1.2" in message
    assert "other 1.2" in message
    main(["--version"])
    with pytest.raises(SystemExit) as ended:
        main(["list", "scenarios"])
    assert ended.value.code == 0


def test_own_commands_do_not_look_for_others(monkeypatch: pytest.MonkeyPatch) -> None:
    def asked(_: str) -> None:
        raise AssertionError("metadata of all installed distributions is read")

    monkeypatch.setattr(core, "declared", asked)
    for name in app.COMMANDS:
        app.program(name)
    with pytest.raises(AssertionError, match="is read"):
        app.program("greet")


def test_the_thesis_is_named_where_it_is_not_installed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(core, "declared", lambda _: {})
    message = refusal(["reproduce", "all"], capsys)
    assert "pip install otolith-thesis" in message
    assert "make demo" in message
    with pytest.raises(SystemExit) as ended:
        main(["rappel"])
    assert ended.value.code == 2
    assert "No such command" in capsys.readouterr().err


def test_of_two_that_declare_one_command_neither_is_run_and_all_else_works(
    site: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install(site, {"greet": "greeter:greet", "wave": "greeter:greet"})
    info = site / "other-3.4.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: other\nVersion: 3.4\n")
    (info / "entry_points.txt").write_text("[otolith.commands]\ngreet = other:greet\n")
    both = "'greet' of otolith.commands is declared by "
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    shown = " ".join(capsys.readouterr().out.split())
    assert ended.value.code == 0
    assert f"Not offered: {both}" in shown
    assert "greeter 1.2" in shown
    assert "other 3.4" in shown
    with pytest.raises(SystemExit):
        main(["wave", "you"])
    assert capsys.readouterr().out == "hello you\n"
    assert both in refusal(["greet", "you"], capsys)
