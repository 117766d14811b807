"""Panels that show many algorithms in one diagram: false cues over time, use of the reach, measures.

Every algorithm is a row; the first one is on top.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.loop import Run
from otolith.metrics import MEASURES, false_cues, workspace_use
from otolith.metrics.axes import force_axes
from otolith.metrics.false_cues import KINDS
from otolith.metrics.measure import EVERY_DOF, Better
from otolith.report import palette
from otolith.report.panels import Axis, Curve, Panel, require_one_scenario
from otolith.report.ranking import ByCueing, Criterion, criterion
from otolith.report.series import labels

COLORS: Final = dict(zip(KINDS, (palette.VERMILION, palette.ORANGE, palette.BLUE, palette.SKY), strict=True))
USE: Final = criterion("workspace", "Reach used")


def false_cue_panels(runs: Sequence[Run], dof: str) -> tuple[Panel, ...]:
    """Return the panel of false cues if the degree of freedom is felt as a force; none for yaw."""
    return (false_cue_panel(runs, dof),) if dof in force_axes(runs[0]) else ()


def false_cue_panel(runs: Sequence[Run], dof: str) -> Panel:
    """Return a panel of when and how each run misled: one row per run, one colour per kind.

    Raises
    ------
    ValueError : there is no run, or the runs are not of one scenario.
    """
    require_one_scenario(runs)
    found = [[cue for cue in false_cues(run) if cue.dof == dof] for run in runs]
    curves = []
    for kind in KINDS:
        spans = [
            (cue.start, cue.end, row) for row, cues in enumerate(found) for cue in cues if cue.kind == kind
        ]
        total = sum(end - start for start, end, _ in spans)
        if spans:
            curves.append(_bars(f"{kind}: {total:.1f} s in all", spans, COLORS[kind]))
    return Panel(
        key="compare-false-cues",
        title="False cues",
        axes=(_rows(labels(runs)),),
        curves=tuple(curves),
        x_span=(0.0, max(run.decisions * run.period for run in runs) or 1.0),
    )


def use_panel(runs: Sequence[Run]) -> Panel:
    """Return a panel of the largest share of the reach that each run used per axis; 100 % is the limit."""
    require_one_scenario(runs)
    used = [workspace_use(run) if run.samples else {} for run in runs]
    axes = list(dict.fromkeys(axis for of_run in used for axis in of_run))
    curves, largest = [], 1.1
    for k, axis in enumerate(axes):
        offset = (k - (len(axes) - 1) / 2) * 0.7 / len(axes)
        shares = [(row, of_run[axis].largest) for row, of_run in enumerate(used) if axis in of_run]
        bars = [(0.0, 100.0 * share, row + offset) for row, share in shares]
        largest = max(largest, *(share for _, share in shares))
        color = palette.GREY if axis == "circle" else palette.CYCLE[k % len(palette.CYCLE)]
        curves.append(_bars(axis, bars, color, width=9.0 / len(axes)))
    limit = Curve(
        label="limit",
        x=np.array([100.0, 100.0]),
        y=np.array([-0.6, len(runs) - 0.4]),
        color=palette.VERMILION,
        dash="dash",
        width=1.0,
    )
    return Panel(
        key="compare-use",
        title="Use of the reach",
        axes=(_rows(labels(runs)),),
        curves=(*curves, limit),
        x_label="largest share of the reach [%]",
        x_span=(0.0, 105.0 * largest),
    )


def trade_panel(summaries: ByCueing, by: Criterion, *, of: str = "") -> Panel:
    """Return a panel of each algorithm's measure against its travel on one scenario.

    Algorithms that passed a hard limit are red, and their labels say so.

    Parameters
    ----------
    of : name of the scenario, for the title.
    """
    kept = [color for color in palette.CYCLE if color != palette.VERMILION]
    curves = []
    for k, (name, summary) in enumerate(summaries.items()):
        beyond = bool(summary.get("violations"))
        curves.append(
            Curve(
                label=f"{name} (passed a hard limit)" if beyond else name,
                x=np.array([USE.of(summary)]),
                y=np.array([by.shown(by.of(summary))]),
                color=palette.VERMILION if beyond else kept[k % len(kept)],
                kind="marks",
            )
        )
    low, high = _span([curve.y for curve in curves], above=0.15, below=0.0)
    end = Curve(
        label="end of the reach",
        x=np.array([100.0, 100.0]),
        y=np.array([low, high]),
        color=palette.VERMILION,
        dash="dash",
        width=1.0,
    )
    words = f"{by.words} against travel"
    return Panel(
        key="trade-up" if by.better is Better.HIGHER else "trade",
        title=f"{of}: {words}" if of else words,
        axes=(Axis(label=by.label, span=(low, high)),),
        curves=(*curves, end),
        x_label="largest use of the reach [%]",
        x_span=(0.0, 1.06 * max([100.0, *(float(curve.x[0]) for curve in curves)])),
    )


def overview_panels(scenarios: Mapping[str, ByCueing]) -> tuple[Panel, ...]:
    """Return a small diagram for each number of the summary line: algorithms as rows, scenarios as dots."""
    summary = next(iter(next(iter(scenarios.values())).values()))
    dofs = str(summary["dofs"]).split(",") if "dofs" in summary else EVERY_DOF
    return tuple(
        _overview(f"overview-{name}", Criterion(measure, column), scenarios)
        for name, measure in MEASURES.items()
        for column in measure.columns
        if column.says and measure.defined(dofs)
    )


def _overview(key: str, by: Criterion, scenarios: Mapping[str, ByCueing]) -> Panel:
    names = list(next(iter(scenarios.values())))
    curves = []
    for k, (scenario, summaries) in enumerate(scenarios.items()):
        curves.append(
            Curve(
                label=scenario,
                x=np.array([by.shown(by.of(summaries[name])) for name in names]),
                y=np.arange(len(names), dtype=np.float64),
                color=palette.CYCLE[k % len(palette.CYCLE)],
                kind="marks",
            )
        )
    return Panel(
        key=key,
        title=by.words,
        axes=(_rows(names),),
        curves=tuple(curves),
        x_label=by.label,
        x_span=_span([curve.x for curve in curves], above=0.06, below=0.03),
        words=f"{by.column.says}.",
    )


def _span(values: Sequence[Vec], *, above: float, below: float) -> tuple[float, float]:
    """Return the range of an axis that contains zero and all values.

    Parameters
    ----------
    above, below : margins at both ends, as shares of the axis's length.
    """
    known = [float(value) for of_one in values for value in of_one if np.isfinite(value)]
    low, high = min(0.0, *known, 0.0), max(0.0, *known, 0.0)
    high = high if high > low else 1.0
    return low - (below if low == 0.0 else above) * (high - low), high + above * (high - low)


def _rows(names: Sequence[str]) -> Axis:
    return Axis(label="", span=(len(names) - 0.4, -0.6), ticks=tuple(names))


def _bars(
    label: str, spans: Sequence[tuple[float, float, float]], color: str, *, width: float = 6.0
) -> Curve:
    """Return horizontal bars (from, to, row) as one interrupted line."""
    x: Vec = np.array([value for start, end, _ in spans for value in (start, end, np.nan)])
    y: Vec = np.array([value for *_, row in spans for value in (row, row, np.nan)])
    return Curve(label=label, x=x, y=y, color=color, kind="bars", width=width)
