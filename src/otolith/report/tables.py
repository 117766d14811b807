"""Key figures as HTML tables. Known names become words with units; unknown names are shown unchanged.

Units are those of the diagrams: angles and their rates are in degrees, whatever a summary contains.
"""

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Final

from otolith.metrics import MEASURES, Better, Measure, Topic
from otolith.metrics.measure import Summary, in_degrees
from otolith.metrics.verdict import bounds, kind
from otolith.report import texts
from otolith.report.page import table

Path = tuple[str, ...]  # keys from a summary to a value inside it
ELSEWHERE: Final = frozenset(  # shown in the page's head or under the settings
    {"scenario", "cueing", "plant", "platform", "dofs", "duration_s", "period_s", "settings"}
)
MANY: Final = 4  # with more entries than this, zeros are only counted


def key_figures(summary: Summary) -> str:
    """Return a table with one row per key figure of one run."""
    shown = _shown(summary)
    rows = [
        _row(name_with_unit((key,)), [f"<td>{_cell(_at(shown, (key,)), (key,))}</td>"])
        for key in shown
        if _listed(key)
    ]
    return f'<table class="figures"><tbody>{"".join(rows)}</tbody></table>'


def _listed(key: str) -> bool:
    return MEASURES[key].listed if key in MEASURES else key not in ELSEWHERE


def _shown(summary: Summary) -> Summary:
    """Return the summary with angles in degrees, as in the diagrams, and texts of measures that have them."""
    return {key: _text_or_value(key, summary) if key in MEASURES else summary[key] for key in summary}


def _text_or_value(key: str, summary: Summary) -> object:
    in_words = MEASURES[key].in_words
    return MEASURES[key].shown(summary[key]) if in_words is None else in_words(summary)


def limits(summary: Summary) -> str:
    """Return a table of all limits: bounds, kind, and how often and how far each was passed."""
    rows = []
    for limit in summary.get("limits", {}).values():
        hardness = kind(limit)
        mark = " class=out" if limit["nodes_beyond"] and not limit["soft"] else ""
        cells = [
            f"<td>{escape(bounds(limit))}</td>",
            f"<td>{escape(hardness)}</td>",
            f"<td{mark}>{number(limit['nodes_beyond'])}</td>",
            f"<td{mark}>{_excess(limit, 'excess')}</td>",
            f"<td>{_excess(limit, 'excess_between_nodes')}</td>",
        ]
        rows.append((escape(limit["name"]), cells))
    heads = ("Limit", "Bounds", "How it was held", "Nodes beyond", "By at most", "At any instant")
    return f'<p class="note">{texts.LIMITS}</p>{_wide(table("models", heads, rows))}' if rows else ""


def _excess(limit: Summary, key: str) -> str:
    value = limit[key]
    if value is None:
        return "no number"
    return f"{number(float(f'{value:.3g}'))} {escape(limit['unit'])}" if value else "–"


def headline(names: Sequence[str], summaries: Sequence[Summary]) -> str:
    """Return a table of algorithms: how well they cue, at what cost, and their solvers' figures last.

    A column that no summary has is left out.
    """
    heads, cells = ["Cueing"], []
    for measure in sorted(MEASURES.values(), key=lambda one: list(Topic).index(one.topic)):
        values = [_at(summary, (measure.name,)) for summary in summaries]
        if all(summary.get(measure.name) in (None, {}) for summary in summaries):
            continue
        for column in (one for one in measure.columns if one.head):
            numbers = [column.in_degrees(column.number(value)) for value in values]
            heads.append(column.heading)
            cells.append(_column(numbers, (measure.name,), better=measure.better))
            if column.against:
                against, percentages = _against(measure, names, summaries, numbers)
                heads.append(against)
                cells.append(_column(percentages, (measure.name,)))
    rows = [(escape(n), [of[k] for of in cells]) for k, n in enumerate(names)]
    return _wide(table("models", heads, rows))


def side_by_side(names: Sequence[str], summaries: Sequence[Summary]) -> str:
    """Return a table with every key figure in a row and every algorithm in a column."""
    shown = [_shown(summary) for summary in summaries]
    paths = dict.fromkeys(path for summary in shown for path in _paths(summary) if _listed(path[0]))
    rows = [(_heading(path), _column([_at(s, path) for s in shown], path)) for path in paths]
    return _wide(table("models", ["Key figure", *names], rows))


def _wide(text: str) -> str:
    return f'<div class="wide">{text}</div>'


def name_with_unit(path: Path) -> str:
    """Return words and unit of the entry at a path of a summary, escaped."""
    name, key = path[0], path[-1]
    if name in MEASURES and path == (name,):
        words, unit = MEASURES[name].words, in_degrees(MEASURES[name].unit)
    elif name in MEASURES and key in MEASURES[name].parts:
        words, unit = MEASURES[name].parts[key]
    else:
        ending = next((e for e in texts.UNITS if key.endswith(e)), "")
        words, unit = key.removesuffix(ending).replace("_", " "), texts.UNITS.get(ending, "")
    return escape(words) + (f" <small>[{escape(unit)}]</small>" if unit else "")


def number(value: object) -> str:
    """Format a plain JSON value for readers, escaped."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f").replace("-", "−")
    if isinstance(value, float):
        return "not a number" if math.isnan(value) else f"{value:.4g}".replace("-", "−")
    return escape(str(value))


def _cell(value: object, path: Path) -> str:
    if isinstance(value, Mapping) and _alike(value):
        return _grid(value, path)
    if isinstance(value, Mapping):
        shown = {k: v for k, v in value.items() if v != 0} if len(value) > MANY else value
        zeros = len(value) - len(shown)
        entries = [
            f"<div><dt>{name_with_unit((*path, str(k)))}</dt><dd>{_cell(v, (*path, str(k)))}</dd></div>"
            for k, v in shown.items()
        ]
        rest = f"<p>0 for {'the other' if entries else 'all'} {zeros}</p>" if zeros else ""
        return (f"<dl>{''.join(entries)}</dl>" if entries else "") + rest or "–"
    if isinstance(value, list | tuple):
        return ", ".join(_cell(entry, path) for entry in value) or "–"
    return number(value)


def _alike(value: Summary) -> bool:
    """Return whether the entries are mappings of numbers with the same names."""
    rows = list(value.values())
    return bool(rows) and all(
        isinstance(row, Mapping)
        and list(row) == list(rows[0])
        and not any(isinstance(cell, Mapping) for cell in row.values())
        for row in rows
    )


def _grid(rows: Mapping[str, Mapping[str, object]], path: Path) -> str:
    """Return a small table with one row per entry; entries of only zeros are left out."""
    shown = {name: row for name, row in rows.items() if any(value != 0 for value in row.values())}
    if not shown:
        return "none"
    heads = "".join(
        f'<th scope="col">{name_with_unit((*path, str(k)))}</th>' for k in next(iter(shown.values()))
    )
    body = "".join(
        _row(
            name_with_unit((*path, str(name))),
            [f"<td>{_cell(value, (*path, str(name), str(k)))}</td>" for k, value in row.items()],
        )
        for name, row in shown.items()
    )
    return f'<table class="grid"><thead><tr><td></td>{heads}</tr></thead><tbody>{body}</tbody></table>'


def _row(head: str, cells: Sequence[str]) -> str:
    return f'<tr><th scope="row">{head}</th>{"".join(cells)}</tr>'


def _column(values: Sequence[object], path: Path, *, better: Better = Better.NEUTRAL) -> list[str]:
    """Return one table cell per value; the best is marked if values differ and one direction is better."""
    numbers = [v for v in values if isinstance(v, int | float) and math.isfinite(v)]
    marked = better is not Better.NEUTRAL and len(set(numbers)) > 1
    best = better.of_all(numbers) if marked else None
    return [
        f"<td{' class=best' if best is not None and value == best else ''}>{_cell(value, path)}</td>"
        for value in values
    ]


def _paths(summary: Summary, before: Path = ()) -> list[Path]:
    found: list[Path] = []
    for key, value in summary.items():
        path = (*before, str(key))
        found += _paths(value, path) if isinstance(value, Mapping) else [path]
    return found


def _at(summary: Summary, path: Path) -> object:
    """Return the entry at a path; None if it is missing, or concerns a solver and there was none."""
    of_solver = path[0] in MEASURES and MEASURES[path[0]].topic is Topic.SOLVER
    value: object = None if of_solver and summary.get("residual_max") == 0.0 else summary
    for key in path:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def _heading(path: Path) -> str:
    return ": ".join(name_with_unit(path[: k + 1]) for k in range(len(path)))


def _against(
    measure: Measure, names: Sequence[str], summaries: Sequence[Summary], numbers: Sequence[object]
) -> tuple[str, list[object]]:
    """Return numbers relative to the implicit MPC if the summaries state them, else to the first run [%]."""
    stated = [_at(summary, (f"{measure.name}_against_implicit_percent",)) for summary in summaries]
    if any(value is not None for value in stated):
        return "Against implicit [%]", [_signed(value) for value in stated]
    return f"Against {names[0]} [%]", [_signed(_percentage(one, numbers[0])) for one in numbers]


def _percentage(value: object, base: object) -> float | None:
    if isinstance(value, int | float) and isinstance(base, int | float) and base > 0:
        return 100.0 * (value / base - 1.0)
    return None


def _signed(value: object) -> object:
    return f"{value:+.1f}".replace("-", "−") if isinstance(value, int | float) else value
