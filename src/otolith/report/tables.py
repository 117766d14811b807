"""Key figures as HTML tables. Known names become words with units; unknown ones are shown as they are.

Units are those of the diagrams: angles and their rates in degrees, whatever a summary keeps.
"""

import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, Final

from otolith.interfaces import Status
from otolith.metrics.verdict import bounds, kind
from otolith.report import texts
from otolith.report.page import table
from otolith.report.ranking import largest_use, misleading

Summary = Mapping[str, Any]
ELSEWHERE: Final = frozenset(  # stands in the page's head, in a table of its own, or under the settings
    {"scenario", "cueing", "plant", "platform", "dofs", "duration_s", "period_s", "settings", "limits"}
)
OF_A_SOLVER: Final = frozenset({"changes", "changes_against_implicit_percent", "residual_max"})
IN_DEGREES: Final = frozenset({"rate_rmse", "perceived_rate_rmse", "travel_rms", "wanted_rms"})  # of turning
TURNING: Final = frozenset({"roll", "pitch", "yaw"})
MANY: Final = 4  # more entries than this, and the zeros among them are only counted


def key_figures(summary: Summary) -> str:
    """Table with one row per key figure of one run."""
    shown = in_degrees(summary)
    rows = [
        _row(name_with_unit(key), [f"<td>{_cell(_at(shown, (key,)))}</td>"])
        for key in shown
        if key not in ELSEWHERE
    ]
    return f'<table class="figures"><tbody>{"".join(rows)}</tbody></table>'


def in_degrees(summary: Summary) -> Summary:
    """The summary with what turns in degrees, as in the diagrams."""
    turned = {
        key: {axis: math.degrees(v) if axis in TURNING else v for axis, v in summary[key].items()}
        for key in IN_DEGREES & set(summary)
    }
    return {**summary, **turned}


def limits(summary: Summary) -> str:
    """Every limit: what it protects, how it was held, how often and by how much it was passed."""
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
    """Algorithms below each other: how well they cue, what it takes; what their solvers do stands last."""
    against, percentages = _against(names, summaries)
    force = any(summary.get("rmse") is not None for summary in summaries)
    error = {"Error [m/s²]": [_at(s, ("rmse",)) for s in summaries]} if force else {}
    if any("rate_rmse" in summary for summary in summaries):
        error["Yaw rate error [deg/s]"] = [_at(in_degrees(s), ("rate_rmse", "yaw")) for s in summaries]
    columns: dict[str, list[object]] = {
        **error,
        "Misled [s]": [misleading(s) if "false_cues" in s else None for s in summaries],
        "Reach used [%]": [100.0 * largest_use(s) if "workspace" in s else None for s in summaries],
        "Hard limits passed": [_at(s, ("violations",)) for s in summaries],
        "Decisions failed": [_failed(s) for s in summaries],
        "Median step [µs]": [_at(s, ("step_time_us", "median")) for s in summaries],
        "Mean changes": [_at(s, ("changes", "mean")) for s in summaries],
        against: percentages,
        "Changes, p99": [_at(s, ("changes", "p99")) for s in summaries],
        "Changes, max": [_at(s, ("changes", "max")) for s in summaries],
    }
    cells = [_column(values, best=head != "Reach used [%]") for head, values in columns.items()]
    rows = [(escape(n), list(row)) for n, row in zip(names, zip(*cells, strict=True), strict=True)]
    return _wide(table("models", ["Cueing", *columns], rows))


def _failed(summary: Summary) -> object:
    status = summary.get("status")
    return None if status is None else sum(count for name, count in status.items() if name != Status.DECIDED)


def side_by_side(names: Sequence[str], summaries: Sequence[Summary]) -> str:
    """Every key figure in a row, every model in a column."""
    shown = [in_degrees(summary) for summary in summaries]
    paths: dict[tuple[str, ...], None] = {}
    for summary in shown:
        for path in _paths(summary):
            if path[0] not in ELSEWHERE:
                paths[path] = None
    rows = [(_heading(path), _column([_at(s, path) for s in shown])) for path in paths]
    return _wide(table("models", ["Key figure", *names], rows))


def _wide(text: str) -> str:
    return f'<div class="wide">{text}</div>'


def name_with_unit(key: str) -> str:
    """Words and unit for the key of a summary, escaped."""
    if key in texts.NAMES:
        words, unit = texts.NAMES[key]
    else:
        ending = next((e for e in texts.UNITS if key.endswith(e)), "")
        words, unit = key.removesuffix(ending).replace("_", " "), texts.UNITS.get(ending, "")
    return escape(words) + (f" <small>[{escape(unit)}]</small>" if unit else "")


def number(value: object) -> str:
    """A plain JSON value as people write it, escaped."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", "\u202f").replace("-", "−")
    if isinstance(value, float):
        return "not a number" if math.isnan(value) else f"{value:.4g}".replace("-", "−")
    return escape(str(value))


def _cell(value: object) -> str:
    if isinstance(value, Mapping) and _alike(value):
        return _grid(value)
    if isinstance(value, Mapping):
        shown = {k: v for k, v in value.items() if v != 0} if len(value) > MANY else value
        zeros = len(value) - len(shown)
        entries = [
            f"<div><dt>{name_with_unit(str(k))}</dt><dd>{_cell(v)}</dd></div>" for k, v in shown.items()
        ]
        rest = f"<p>0 for {'the other' if entries else 'all'} {zeros}</p>" if zeros else ""
        return (f"<dl>{''.join(entries)}</dl>" if entries else "") + rest or "–"
    if isinstance(value, list | tuple):
        return ", ".join(_cell(entry) for entry in value) or "–"
    return number(value)


def _alike(value: Summary) -> bool:
    """Whether the entries are mappings of numbers under the same names."""
    rows = list(value.values())
    return bool(rows) and all(
        isinstance(row, Mapping)
        and list(row) == list(rows[0])
        and not any(isinstance(cell, Mapping) for cell in row.values())
        for row in rows
    )


def _grid(rows: Mapping[str, Mapping[str, object]]) -> str:
    """A small table with one row per entry; entries that are zero throughout are left out."""
    shown = {name: row for name, row in rows.items() if any(value != 0 for value in row.values())}
    if not shown:
        return "none"
    heads = "".join(f'<th scope="col">{name_with_unit(str(k))}</th>' for k in next(iter(shown.values())))
    body = "".join(
        _row(name_with_unit(str(name)), [f"<td>{_cell(value)}</td>" for value in row.values()])
        for name, row in shown.items()
    )
    return f'<table class="grid"><thead><tr><td></td>{heads}</tr></thead><tbody>{body}</tbody></table>'


def _row(head: str, cells: Sequence[str]) -> str:
    return f'<tr><th scope="row">{head}</th>{"".join(cells)}</tr>'


def _column(values: Sequence[object], *, best: bool = False) -> list[str]:
    """One table cell per value, the lowest set off where `best`."""
    numbers = [v for v in values if isinstance(v, int | float) and math.isfinite(v)]
    lowest = min(numbers) if best and len(set(numbers)) > 1 else None
    return [
        f"<td{' class=best' if lowest is not None and value == lowest else ''}>{_cell(value)}</td>"
        for value in values
    ]


def _paths(summary: Summary, before: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found: list[tuple[str, ...]] = []
    for key, value in summary.items():
        path = (*before, str(key))
        found += _paths(value, path) if isinstance(value, Mapping) else [path]
    return found


def _at(summary: Summary, path: tuple[str, ...]) -> object:
    """What stands there; None where nothing does, or where it tells of a solver and there was none."""
    value: object = None if path[0] in OF_A_SOLVER and summary.get("residual_max") == 0.0 else summary
    for key in path:
        value = value.get(key) if isinstance(value, Mapping) else None
    return value


def _heading(path: tuple[str, ...]) -> str:
    return ": ".join(name_with_unit(key) for key in path)


def _against(names: Sequence[str], summaries: Sequence[Summary]) -> tuple[str, list[object]]:
    """Mean changes against the implicit MPC's where the summaries tell, else against the first run's [%]."""
    told = [_at(summary, ("changes_against_implicit_percent",)) for summary in summaries]
    if any(value is not None for value in told):
        return "Against implicit [%]", [_signed(value) for value in told]
    means = [_at(summary, ("changes", "mean")) for summary in summaries]
    return f"Against {names[0]} [%]", [_signed(_percentage(mean, means[0])) for mean in means]


def _percentage(value: object, base: object) -> float | None:
    if isinstance(value, int | float) and isinstance(base, int | float) and base > 0:
        return 100.0 * (value / base - 1.0)
    return None


def _signed(value: object) -> object:
    return f"{value:+.1f}".replace("-", "−") if isinstance(value, int | float) else value
