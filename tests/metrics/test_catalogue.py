"""One entry per key figure: it is documented, consistent, and enough for a new one to appear everywhere."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith import cli
from otolith.loop import Run
from otolith.metrics import MEASURES, Better, Column, Measure, Reading, Scale
from otolith.report import criteria

PAGE = (Path(__file__).parents[2] / "docs" / "metrics.md").read_text(encoding="utf-8")
WAYS = {Better.LOWER: "smaller", Better.HIGHER: "greater", Better.NEUTRAL: "–"}


def documented() -> dict[str, list[str]]:
    """Cells of the first table by key."""
    rows = [line.strip("|").split("|") for line in PAGE.splitlines() if re.match(r"\| `\w+` \|", line)]
    return {row[0].strip(" `"): [cell.strip() for cell in row[1:]] for row in rows}


def test_the_documentation_tells_of_every_key_figure_its_unit_and_which_way_is_better() -> None:
    found = {name: cells[1:] for name, cells in documented().items() if name in MEASURES}
    assert found == {name: [one.unit or "–", WAYS[one.better]] for name, one in MEASURES.items()}


def test_every_key_figure_points_to_a_heading_of_its_page() -> None:
    headings = {line.lstrip("# ").strip() for line in PAGE.splitlines() if line.startswith("#")}
    assert {one.section for one in MEASURES.values()} <= headings


def test_names_of_rankings_and_headings_of_columns_are_told_once() -> None:
    columns = [column for one in MEASURES.values() for column in one.columns]
    for words in ([one.by for one in columns if one.by], [one.heading for one in columns if one.head]):
        assert len(set(words)) == len(words)


def test_the_documentation_tells_of_everything_that_runs_are_ranked_by() -> None:
    page = (Path(__file__).parents[2] / "docs" / "comparing.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `(\w[\w-]*)` \|", page, re.MULTILINE)) == set(criteria())


def test_what_is_ranked_by_has_a_better_way() -> None:
    with pytest.raises(ValueError, match="needs a better way"):
        Measure(name="x", words="x", unit="", of=None, columns=(Column("x", by="x"),), section="")


def test_a_column_is_told_in_degrees_where_it_turns() -> None:
    column = MEASURES["rate_rmse"].columns[0]
    assert column.heading == "Yaw rate error [deg/s]"
    assert column.number({"yaw": 0.1}) == pytest.approx(0.1)
    assert column.in_degrees(0.1) == pytest.approx(5.729578)
    assert column.in_degrees(column.number(None)) is None


def smoothness(run: Run) -> float:
    return 1.0 / (1.0 + float(np.abs(np.diff(run.acceleration[:, 0])).max()) / run.plant_period)


SMOOTHNESS = Measure(
    name="smoothness",
    words="Smoothness of surge",
    unit="s³/m",
    of=smoothness,
    better=Better.HIGHER,
    columns=(Column("Smooth", by="smoothness", says="How smoothly the platform surged"),),
    line=lambda value: f"smoothness {value:.3g}",
    scale=Scale(
        title="How smooth",
        ends=("no jerk", "jerks without end"),
        read=lambda summary: Reading(
            value=f"{summary['smoothness']:.2g}", share=1.0 - summary["smoothness"], words="A test’s own."
        ),
    ),
    section="Limits",
)


def printed_by(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[Any, str]:
    """The JSON on standard output, and what is written next to it."""
    with pytest.raises(SystemExit) as stopped:
        cli.main([*arguments, "--json"])
    assert stopped.value.code in (None, 0)
    output = capsys.readouterr()
    return json.loads(output.out), output.err


def test_a_new_entry_appears_in_summary_ranking_tables_and_report(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing but the entry is added."""
    monkeypatch.setitem(MEASURES, "smoothness", SMOOTHNESS)
    washouts = ["--cueing", "classical", "--cueing", "adaptive"]
    both, one = tmp_path / "both", tmp_path / "one"
    account, output = printed_by(
        ["compare", "step-1", "sine-1", *washouts, "--by", "smoothness", "--out", str(both)], capsys
    )
    assert account["ranked_by"] == "smoothness"
    kept = json.loads((both / "summary.json").read_text(encoding="utf-8"))
    for k, scenario in enumerate(kept["scenarios"].values()):
        values = {name: summary["smoothness"] for name, summary in scenario.items()}
        ranks = {standing["cueing"]: standing["ranks"][k] for standing in kept["ranking"]}
        unbroken = [name for name in values if not scenario[name]["violations"]]
        assert min(unbroken, key=lambda name: ranks[name]) == max(unbroken, key=lambda name: values[name])
        assert [s["values"][k] for s in kept["ranking"]] == [values[s["cueing"]] for s in kept["ranking"]]
    assert "smoothness 0." in output
    page = (both / "report.html").read_text(encoding="utf-8")
    assert '<th scope="col">Smooth [s³/m]</th>' in page  # the comparison's table
    assert "Smoothness of surge <small>[s³/m]</small>" in page  # all key figures
    assert "Smoothness of surge [s³/m] in each cell, greater is better." in page
    assert "How smoothly the platform surged." in page
    assert "High and to the left is best" in page
    printed_by(["run", "step-1", "--cueing", "classical", "--out", str(one)], capsys)
    page = (one / "report.html").read_text(encoding="utf-8")
    assert "How smooth" in page
    assert "Smoothness of surge <small>[s³/m]</small>" in page
