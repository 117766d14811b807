"""`otolith reproduce` as its user meets it."""

import inspect
import json
from importlib.metadata import distribution
from pathlib import Path

import pytest

import otolith
from otolith.cli import main, plugins
from otolith.core.plugins import distribution as declared_by
from otolith_thesis.command import command


def test_published_numbers_stand_beside_ours_on_page_and_in_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ["table-c.2", "table-5.8", "figure-4.2", "figure-c.1", "study-arithmetic"]
    with pytest.raises(SystemExit) as ended:
        main(["reproduce", *names, "--out", str(tmp_path), "--jobs", "1", "--json"])
    assert ended.value.code == 0
    printed = json.loads(capsys.readouterr().out)
    assert json.loads((tmp_path / "reproduced.json").read_text()) == printed
    table = printed["items"]["table-5.8"]
    assert (table["agree"], table["total"], table["conclusion_holds"]) == (2, 2, False)
    page = (tmp_path / "report.html").read_text()
    assert "Table 5.8. 4 DOF, regions" in page
    assert page.count("<svg") == 5  # a picture per panel: Figure 4.2 has one, Figure C.1 four
    assert "@media print" in page
    assert sorted(path.name for path in tmp_path.iterdir()) == [".otolith", "report.html", "reproduced.json"]


def test_without_json_a_table_says_how_many_agree(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["reproduce", "study-filters", "--out", str(tmp_path)])
    out = capsys.readouterr()
    assert "0 of 1" in out.out
    assert "report.html" in out.err


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [(["table-9"], "'table-9'"), (["table-5.8", "--jobs", "0"], "--jobs")],
)
def test_a_wrong_word_is_one_sentence(
    arguments: list[str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["reproduce", *arguments, "--out", str(tmp_path)])
    assert ended.value.code == 2
    assert sentence in capsys.readouterr().err


def test_the_program_finds_the_command_by_its_entry_point() -> None:
    entry = plugins.commands()["reproduce"]
    assert plugins.load(entry) is command
    assert plugins.help_line(entry) == inspect.getdoc(command)
    assert declared_by(entry) == f"otolith-thesis {otolith.__version__}"


def test_it_needs_the_otolith_of_its_own_version() -> None:
    """It uses what is no public interface."""
    assert f"otolith=={otolith.__version__}" in (distribution("otolith-thesis").requires or [])
