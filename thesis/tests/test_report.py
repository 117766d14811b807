"""The page of a reproduction, on screen and on paper, from plain values."""

from typing import Any

import pytest

from otolith_thesis.report.drawing import draw, svg
from otolith_thesis.report.page import (
    beside,
    chapter_of,
    heading_of,
    number,
    page,
    sorted_reasons,
    unexplained,
    wordy,
)

CURVE = {"label": "felt", "x": [0.1, 1.0, 10.0], "y": [0.0, 1.0, 0.5], "dash": False, "right": False}
PANEL = {
    "title": "Force",
    "x_label": "time [s]",
    "y_label": "[m/s²]",
    "right_label": "",
    "log_x": False,
    "curves": [CURVE, {**CURVE, "label": "wanted", "dash": True}],
}
TWO_SIDES = {**PANEL, "right_label": "[m]", "log_x": True, "curves": [CURVE, {**CURVE, "right": True}]}


def one(row: str, column: str, ours: float, verdict: str, **more: Any) -> dict[str, Any]:
    return {
        "row": row,
        "column": column,
        "published": 2.0,
        "at_least": False,
        "ours": ours,
        "ratio": ours / 2.0,
        "verdict": verdict,
        **more,
    }


def item(**more: Any) -> dict[str, Any]:
    counts = {"agrees": 0, "within 10 %": 0, "same order": 0, "differs": 0}
    return {
        "kind": "table",
        "title": "Iterations <of> models",
        "section": "5.2",
        "text": "How & why.",
        "verdicts": counts | {"agrees": 1, "differs": 1},
        "numbers": [],
        "claims": [],
        "grids": [],
        "panels": [],
        "reasons": [],
    } | more


DOCUMENT = {
    "version": "0.1.0",
    "date": "2026-01-01",
    "seconds": 12.3,
    "items": {
        "table-5.5": item(
            numbers=[
                one("sine", "first", 2.01, "agrees"),
                one("sine", "second", 9.0, "differs", at_least=True),
                one("step", "first", 0.0, "differs", ratio=None),
            ],
            claims=[{"text": "It holds", "holds": True, "figures": "3 of 3"}],
            grids=[{"title": "More", "header": ["a", "b"], "rows": [["x", 1.23456], ["y", None]]}],
            reasons=["study-weights", "study-elsewhere"],
        ),
        "figure-c.1": item(kind="figure", panels=[PANEL, TWO_SIDES, PANEL, PANEL]),
        "study-weights": item(
            kind="study", title="Weights decide", claims=[{"text": "No", "holds": False, "figures": "0"}]
        ),
    },
}


def test_the_page_is_complete_and_escapes_what_it_is_told() -> None:
    text = page(DOCUMENT)
    assert text.startswith("<!DOCTYPE html>")
    assert "Table 5.5. Iterations &lt;of&gt; models" in text
    assert "How &amp; why." in text
    assert "http" not in text.replace("http://www.w3.org", "").replace("https://www.w3.org", "").replace(
        "http://purl.org", ""
    ).replace("http://creativecommons.org", "").replace("https://matplotlib.org", "")
    assert text.count('<section class="item"') == 3
    assert text.index("table-5.5") < text.index("figure-c.1") < text.index('id="study-weights"')


def test_numbers_carry_their_verdict_and_reasons_their_study() -> None:
    text = page(DOCUMENT)
    assert (
        '<td class="v1" title="agrees" data-head="first"><span class="published">2</span> <b>2.01</b>' in text
    )
    assert '<span class="published">&gt; 2</span> <b>9</b>' in text
    assert '<td data-head="second">–</td>' in text  # step has no second column
    assert '<a href="#study-weights">Weights decide</a>' in text
    assert "<code>otolith reproduce study-elsewhere</code>" in text


def _with_reasons(**found: str) -> dict[str, Any]:
    studies = {f"study-{name}": item(kind="study", title=name) for name in found}
    for name, bearing in found.items():
        studies[f"study-{name}"]["bears_on"] = {"table-5.5": bearing} if bearing else {}
    table = item(numbers=[one("sine", "first", 9.0, "differs")], reasons=list(studies))
    return {"table-5.5": table, **studies}


def test_a_page_tells_what_explains_from_what_was_excluded() -> None:
    items = _with_reasons(sign="explains", solver="excluded", state="adopted", other="")
    items["table-5.5"]["reasons"].append("study-elsewhere")
    groups = dict(sorted_reasons("table-5.5", items))
    assert [studies for heading, studies in groups.items() if heading.startswith("Explained")] == [
        ["study-sign"]
    ]
    assert groups["Tested, and excluded as a reason:"] == ["study-solver"]
    assert groups["Tested by what is not part of this run:"] == ["study-elsewhere"]
    assert next(name for studies in groups.values() for name in studies) == "study-state"
    assert unexplained("table-5.5", items) == ""
    assert "excluded as a reason" in page({**DOCUMENT, "items": items})


def test_a_page_says_plainly_when_nothing_that_was_tested_explains() -> None:
    items = _with_reasons(solver="excluded", state="adopted")
    assert unexplained("table-5.5", items) == "1 number differs, and no reading that was tested explains it."
    assert "no reading that was tested explains it" in page({**DOCUMENT, "items": items})
    items["table-5.5"]["reasons"].append("study-elsewhere")  # which may explain it
    assert unexplained("table-5.5", items) == "1 number differs."
    items["table-5.5"]["verdicts"] = {**items["table-5.5"]["verdicts"], "differs": 0}
    assert unexplained("table-5.5", items) == ""


def test_contents_lead_to_every_item_and_every_panel_is_a_picture_of_its_own() -> None:
    text = page(DOCUMENT)
    contents = text[text.index('id="contents"') :].partition("</nav>")[0]
    for name in DOCUMENT["items"]:  # type: ignore[attr-defined]
        assert f'href="#{name}"' in contents
        assert f'id="{name}"' in text
    assert text.count("<svg") == 4  # a narrow screen stacks them
    assert "--across: 2" in text


def test_a_page_of_studies_alone_has_no_summary() -> None:
    text = page({**DOCUMENT, "items": {"study-weights": DOCUMENT["items"]["study-weights"]}})  # type: ignore[index]
    assert "In short" not in text
    assert "Weights decide" in text


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (True, "yes"), (False, "no"), (3, "3"), (3.0, "3"), (1.23456, "1.235"), ("x", "x")],
)
def test_cells_read_as_a_person_would_write_them(value: object, text: str) -> None:
    assert number(value) == text


def test_items_know_their_chapter() -> None:
    assert [chapter_of(name) for name in ("figure-4.2", "table-5.5", "table-6.2", "table-c.1")] == list(
        "556c"
    )
    assert heading_of("benchmark-c.2", item()) == "Benchmark C.2. Iterations <of> models"


def test_panels_stand_three_across_and_four_in_a_square() -> None:
    widths = {n: draw([PANEL] * n).get_size_inches()[0] for n in (1, 2, 3, 4, 5)}
    assert widths[3] == widths[5] > widths[4] == widths[2] > widths[1]
    assert svg(draw([TWO_SIDES])) == svg(draw([TWO_SIDES]))


def test_columns_of_words_are_told_from_columns_of_numbers() -> None:
    assert wordy(["law", "", None]) is True
    assert wordy(["law", 3]) is False
    assert wordy(["±24.3", "3 of 4"]) is False


@pytest.mark.parametrize(
    ("published", "ours", "text"),
    [
        (1.3358, 1.34136, ("1.3358", "1.3414")),
        (11131.0, 11171.0, ("11131", "11171")),
        (0.003, 0.00533, ("0.003", "0.00533")),
        (35.65, -4.634, ("35.65", "-4.63")),
        (9.0, 0.0, ("9", "0")),
        (2.0, float("nan"), ("2", "nan")),
    ],
)
def test_ours_has_as_many_digits_as_the_published_number(
    published: float, ours: float, text: tuple[str, str]
) -> None:
    assert beside(published, ours) == text
