"""The reproduction of the thesis as one self-contained HTML page, for screen and paper.

It reads the plain values that `otolith reproduce` writes, so a page can be made again from its JSON.
"""

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, Final

from otolith.report.page import Part, anchor, keyed
from otolith.report.page import page as frame
from otolith_thesis.report.drawing import columns, draw, svg

Values = Mapping[str, Any]
CHAPTERS: Final = {  # key of `chapter_of` -> heading
    "5": "Chapters 4 and 5: simplified actuator dynamics",
    "6": "Chapter 6: emulator and track",
    "b": "Appendix B: perception",
    "c": "Appendix C: further simulations",
}
MARKS: Final = {"agrees": "●", "within 10 %": "◐", "same order": "○", "differs": "×"}
CLASSES: Final = {"agrees": "v1", "within 10 %": "v2", "same order": "v3", "differs": "v4"}
BEARINGS: Final = {  # conclusion of a study about a table -> heading
    "adopted": "Decided by test, and read so above:",
    "explains": "Explained by test, in whole or in part:",
    "excluded": "Tested, and excluded as a reason:",
}
UNITS: Final = {
    "rmse": "RMSE [m/s²]",
    "rmse_without": "RMSE without braking rows [m/s²]",
    "rmse_with": "with [m/s²]",
    "travel": "travel RMS [m]",
    "rise_time": "rise time [samples of 0.05 s]",
    "settling_time": "settling time [s]",
    "constant_rmse": "constant weights: RMSE [m/s²]",
    "constant_travel": "travel RMS [m] ",
}
MOST: Final = 6  # largest number of digits after the point
NEUTRAL: Final = "Tested besides:"
ABSENT: Final = "Tested by what is not part of this run:"
PANEL_WIDTH: Final = 22  # [rem] on screen
RULE: Final = (
    ("agrees", "within 2 %, or within half a unit of the last printed digit"),
    ("within 10 %", "within 10 %"),
    (
        "same order",
        "within a factor of 2, and in its place in the row’s ranking (within 2 % is a tie)",
    ),
    ("differs", "all else"),
)


def page(document: Values) -> str:
    """Return the page of a reproduction.

    Parameters
    ----------
    document : plain values with version, date, seconds and items; the items are results of
        `otolith_thesis.Outcome.as_json` by name.
    """
    items: Mapping[str, Values] = document["items"]
    parts = [Part("In short", _summary(items))]
    for key, heading in CHAPTERS.items():
        own = [n for n, item in items.items() if item["kind"] != "study" and chapter_of(n) == key]
        parts.append(Part(heading, "".join(_item(name, items[name], items) for name in own)))
    studies = [name for name, item in items.items() if item["kind"] == "study"]
    body = "".join(_item(name, items[name], items) for name in studies)
    parts.append(Part("Readings, misprints, and why numbers differ", STUDIES + body if body else ""))
    shown = [part for part in parts if part.body]
    return frame(
        "The thesis’s numbers beside ours",
        "Reproduction",
        _lead(document),
        shown,
        styles=("otolith_thesis.report:thesis.css",),
        contents=_contents(shown, items),
    )


STUDIES: Final = (
    "<p>Each is decided by an experiment. A sentence that the thesis prints, or a reason for a "
    "difference, is put to the test; the figures beside it say what came out.</p>"
)


def chapter_of(name: str) -> str:
    """Return the key of `CHAPTERS` for an item's name, e.g. "5" for "figure-4.2"."""
    first = name.split("-", 1)[1][0]
    return "5" if first == "4" else first


def heading_of(name: str, item: Values) -> str:
    """Return an item's heading, "Table 5.5. Mean iterations …"; that of a study is its finding."""
    kind, _, number = name.partition("-")
    title = str(item["title"])
    return title if item["kind"] == "study" else f"{kind.capitalize()} {number.upper()}. {title}"


def number(value: Any) -> str:
    """Format a cell's value: four significant digits, integers in full."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int) or (isinstance(value, float) and value.is_integer() and abs(value) < 1e7):
        return f"{int(value)}"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def beside(published: float, ours: float) -> tuple[str, str]:
    """Return a published number as printed, and ours with as many decimals, or three significant digits."""
    printed = f"{published:.10g}"
    decimals = len(printed.partition(".")[2]) if "e" not in printed else 0
    if not math.isfinite(ours) or ours == 0.0 or "e" in printed:
        return printed, number(ours)
    three = 0 if float(ours).is_integer() else 2 - math.floor(math.log10(abs(ours)))
    return printed, f"{ours:.{min(max(decimals, three, 0), MOST)}f}"


def wordy(cells: Sequence[Any]) -> bool:
    """Return whether a column holds words, which are aligned to the left, and not numbers."""
    words = [cell for cell in cells if isinstance(cell, str) and cell]
    return len(words) == len([cell for cell in cells if cell not in ("", None)]) and not any(
        word[0].isdigit() or word[0] in "-−+±>–" for word in words
    )


def pivot(numbers: Sequence[Values]) -> tuple[list[str], dict[str, dict[str, Values]]]:
    """Return the columns of a table in order, and its numbers by row and column."""
    columns = list(dict.fromkeys(one["column"] for one in numbers))
    rows: dict[str, dict[str, Values]] = {}
    for one in numbers:
        rows.setdefault(one["row"], {})[one["column"]] = one
    return columns, rows


def column_of(name: str) -> str:
    """Return the heading of a column: words and unit for a key of the data files."""
    return UNITS.get(name, name.replace("_", " "))


def _lead(document: Values) -> str:
    return (
        '<p class="lead"><em>Hybrid MPC based Motion Cueing Algorithm for Driving Simulators</em> (TU Delft; '
        f"arXiv:2304.03232), computed again by Otolith {escape(document['version'])} on "
        f"{escape(document['date'])} in {number(round(document['seconds']))} s. Items are named by the "
        "thesis’s table and section. SI units; degrees where a label says so.</p>"
    )


def _summary(items: Mapping[str, Values]) -> str:
    """Return the rule, and the number of verdicts table by table."""
    rule = "".join(
        f'<li><span class="mark {CLASSES[name]}">{MARKS[name]}</span> '
        f"<strong>{name}</strong>: {escape(text)}</li>"
        for name, text in RULE
    )
    rows, total = [], dict.fromkeys(MARKS, 0)
    for name, item in items.items():
        if not item["numbers"]:
            continue
        counts = item["verdicts"]
        total = {key: total[key] + counts[key] for key in total}
        rows.append(
            f'<tr><th scope="row"><a href="#{name}">{escape(_label(name))}</a></th>'
            + "".join(f'<td data-head="{key}">{counts[key] or ""}</td>' for key in MARKS)
            + f'<td data-head="statements that hold">{_kept(item)}</td></tr>'
        )
    if not rows:
        return ""
    head = "".join(f"<th>{escape(key)}</th>" for key in MARKS)
    foot = "".join(f'<td data-head="{key}">{total[key]}</td>' for key in MARKS)
    return (
        f'<p>One rule for every number:</p><ul class="rule">{rule}</ul>'
        f'<div class="wide"><table class="grid summary"><thead><tr><th>table</th>{head}'
        f"<th>the thesis’s statements that hold</th></tr></thead><tbody>{''.join(rows)}</tbody>"
        f'<tfoot><tr><th scope="row">all {sum(total.values())} numbers</th>{foot}<td></td></tr></tfoot>'
        "</table></div>"
    )


def _kept(item: Values) -> str:
    claims = item["claims"]
    return f"{sum(claim['holds'] for claim in claims)} of {len(claims)}" if claims else ""


def _label(name: str) -> str:
    kind, _, rest = name.partition("-")
    return f"{kind.capitalize()} {rest.upper()}"


def _contents(parts: Sequence[Part], items: Mapping[str, Values]) -> str:
    """Return links to the chapters and, by their short names, to the items of each."""
    chapters = {CHAPTERS[key]: key for key in CHAPTERS}
    rows = []
    for place, part in keyed(parts).items():
        chapter = chapters.get(part.title)
        own = [n for n, item in items.items() if item["kind"] != "study" and chapter_of(n) == chapter]
        links = "".join(
            f'<li><a href="#{name}" title="{escape(heading_of(name, items[name]))}">'
            f"{escape(_label(name))}</a></li>"
            for name in own
        )
        rows.append(f'<p><a href="#{place}">{escape(part.title)}</a></p>{f"<ol>{links}</ol>" * bool(own)}')
    studies = "".join(
        f'<li><a href="#{name}">{escape(item["title"])}</a></li>'
        for name, item in items.items()
        if item["kind"] == "study"
    )
    folded = f"<details><summary>The studies, one by one</summary><ol>{studies}</ol></details>" * bool(
        studies
    )
    return f'<nav class="contents" id="contents" aria-label="Contents">{"".join(rows)}{folded}</nav>'


def _item(name: str, item: Values, items: Mapping[str, Values]) -> str:
    parts = [f'<section class="item" id="{name}"><h3>{escape(heading_of(name, item))}{anchor(name)}</h3>']
    up = '<a href="#contents"> · contents</a>'
    parts.append(f'<p class="note">thesis, section {escape(item["section"])} · <code>{name}</code>{up}</p>')
    if item["text"]:
        parts.append(f"<p>{escape(item['text'])}</p>")
    parts += [_claims(item), _numbers(item["numbers"])]
    if item["panels"]:
        parts.append(_figure(item["panels"]))
    parts.append(_grids(item["grids"], folded=bool(item["numbers"] or item["panels"])))
    parts.append(_reasons(name, items))
    return "".join(parts) + "</section>"


def _figure(panels: Sequence[Values]) -> str:
    """Return panels of one size, however many are in a row; a narrow screen stacks them."""
    across = columns(len(panels))
    drawings = "".join(svg(draw([panel])) for panel in panels)
    style = f"max-width: {PANEL_WIDTH * across}rem; --across: {across}"
    return f'<figure class="drawn" style="{style}">{drawings}</figure>'


def _claims(item: Values) -> str:
    entries = "".join(
        f'<li class="{"holds" if claim["holds"] else "fails"}">'
        f"<strong>{'yes' if claim['holds'] else 'no'}</strong> "
        f"{escape(claim['text'])} <small>{escape(claim['figures'])}</small></li>"
        for claim in item["claims"]
    )
    return f'<ul class="claims">{entries}</ul>' if entries else ""


def _numbers(numbers: Sequence[Values]) -> str:
    """Return a table with one cell per number: published above, ours below, and the ratio."""
    if not numbers:
        return ""
    columns, rows = pivot(numbers)
    head = "".join(f"<th>{escape(column_of(column))}</th>" for column in columns)
    body = "".join(
        f'<tr><th scope="row">{escape(row)}</th>{"".join(_cell(cells.get(c), c) for c in columns)}</tr>'
        for row, cells in rows.items()
    )
    return (
        '<div class="wide"><table class="grid numbers"><caption>published · <b>ours</b> · ratio</caption>'
        f"<thead><tr><th></th>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _cell(one: Values | None, column: str) -> str:
    head = escape(column_of(column))
    if one is None:
        return f'<td data-head="{head}">–</td>'
    ratio = "" if one["ratio"] is None else f"{one['ratio']:.2f}"
    bound = "&gt; " if one["at_least"] else ""
    printed, ours = beside(one["published"], one["ours"])
    return (
        f'<td class="{CLASSES[one["verdict"]]}" title="{escape(one["verdict"])}" data-head="{head}">'
        f'<span class="published">{bound}{printed}</span> <b>{ours}</b> '
        f'<span class="ratio">{ratio} {MARKS[one["verdict"]]}</span></td>'
    )


def _grids(grids: Sequence[Values], *, folded: bool) -> str:
    """Return further tables of an item, folded if it also has numbers or a figure."""
    text = "".join(map(_grid, grids))
    if not text or not folded:
        return text
    titles = "; ".join(escape(grid["title"]) for grid in grids)
    return f"<details><summary>Further figures: {titles}</summary>{text}</details>"


def _grid(grid: Values) -> str:
    words = [wordy([row[k] for row in grid["rows"]]) for k in range(len(grid["header"]))]
    classes = ["" if k == 0 or not of_words else ' class="words"' for k, of_words in enumerate(words)]
    head = "".join(
        f"<th{c}>{escape(str(cell))}</th>" for c, cell in zip(classes, grid["header"], strict=True)
    )
    attributes = [
        f'{c} data-head="{escape(str(name))}"' for c, name in zip(classes, grid["header"], strict=True)
    ]
    body = "".join(
        f'<tr><th scope="row">{escape(number(row[0]))}</th>'
        + "".join(f"<td{c}>{escape(number(v))}</td>" for c, v in zip(attributes[1:], row[1:], strict=True))
        + "</tr>"
        for row in grid["rows"]
    )
    return (
        f'<div class="wide"><table class="grid"><caption>{escape(grid["title"])}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def sorted_reasons(name: str, items: Mapping[str, Values]) -> list[tuple[str, list[str]]]:
    """Group the studies of a table by their conclusion: headings with names, without empty groups.

    Parameters
    ----------
    name : name of the table.
    items : all items of the run; the conclusion of a study that is not among them is unknown.
    """
    groups: dict[str, list[str]] = {heading: [] for heading in (*BEARINGS.values(), NEUTRAL, ABSENT)}
    for study in items[name]["reasons"]:
        found = items[study].get("bears_on", {}).get(name, "") if study in items else ""
        groups[BEARINGS.get(found, NEUTRAL) if study in items else ABSENT].append(study)
    return [(heading, studies) for heading, studies in groups.items() if studies]


def unexplained(name: str, items: Mapping[str, Values]) -> str:
    """Return the sentence for a table with differences that no study in the run explains; else empty."""
    item = items[name]
    count = item["verdicts"]["differs"] if item["numbers"] else 0
    studies = [items[study] for study in item["reasons"] if study in items]
    if not count or any(study.get("bears_on", {}).get(name) == "explains" for study in studies):
        return ""
    what = "1 number differs" if count == 1 else f"{count} numbers differ"
    if len(studies) < len(item["reasons"]) or not item["reasons"]:
        return f"{what}."
    return f"{what}, and no reading that was tested explains it."


def _reasons(name: str, items: Mapping[str, Values]) -> str:
    """Return what studies found about this table's differences; studies of the same run are links."""
    parts = [f"<p><strong>{escape(sentence)}</strong></p>"] if (sentence := unexplained(name, items)) else []
    for heading, studies in sorted_reasons(name, items):
        entries = "".join(
            f'<li><a href="#{study}">{escape(items[study]["title"])}</a></li>'
            if study in items
            else f"<li><code>otolith reproduce {study}</code></li>"
            for study in studies
        )
        parts.append(f"<p>{heading}</p><ul>{entries}</ul>")
    return f'<div class="reasons">{"".join(parts)}</div>' if parts else ""
