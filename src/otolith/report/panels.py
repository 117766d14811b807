"""The contents of each panel of a report, defined once for paper and page: curves, limits, axes.

A panel is data. `figures` draws it with matplotlib and `plots` with plotly; neither adds content.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeVar

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.frames import AXES, PAIRS
from otolith.loop import Run
from otolith.report import palette
from otolith.report.series import (
    Band,
    Effort,
    Line,
    PairSeries,
    SingleSeries,
    decimate,
    effort,
    extent,
    labels,
    pair_series,
    single_series,
    stairs,
    survival,
)

# A limit this many times larger than all data is named, not drawn: it would flatten the curve
FAR: Final = 2.5
MARGIN: Final = 0.06  # share of an axis beyond its data
SPREAD: Final = 10.0  # ratio of the slowest step to the median from which the axis is logarithmic

Series = TypeVar("Series", PairSeries, SingleSeries)
Kind = Literal["line", "stairs", "dots", "points", "marks", "bars"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """Points to draw: `points` are dots joined by a line, `stairs` a filled outline, `bars` thick lines."""

    label: str
    x: Vec
    y: Vec
    color: str
    kind: Kind = "line"
    dash: str = "solid"  # solid, dash, dashdot or dot
    width: float = 1.2  # [pt]
    axis: int = 0  # 0 left, 1 right


@dataclass(frozen=True, slots=True, kw_only=True)
class Bound:
    """A limit or another constant, drawn across the panel; if `far`, it is named only in the legend."""

    label: str
    values: tuple[float, ...]
    color: str
    dash: str = "dash"
    axis: int = 0
    far: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """A vertical axis; `color` relates it to its curve if a panel has two; `ticks` name the rows 0, 1, …"""

    label: str
    span: Band
    color: str = ""
    log: bool = False
    ticks: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Panel:
    """One diagram."""

    key: str
    title: str
    axes: tuple[Axis, ...]  # left, and optionally right
    curves: tuple[Curve, ...]
    bounds: tuple[Bound, ...] = ()
    x_label: str = "time [s]"
    x_span: Band = (0.0, 1.0)
    words: str = ""  # explanation; empty for the text of this key in `otolith.report.texts.PANELS`

    @property
    def over_time(self) -> bool:
        """Return whether the horizontal axis is time, which panels share."""
        return self.x_label.startswith("time")


def run_panels(run: Run, pair: str, best: Run | None = None) -> tuple[Panel, ...]:
    """Return the panels of one axis pair: specific force with its parts, tilt, position (figs 5.2 to 5.8)."""
    series = pair_series(run, pair)
    span = time_span(run)
    return (_force(series, span, best_felt(best, pair)), _tilt(series, span), _position(series, span))


def effort_panels(run: Run) -> tuple[Panel, ...]:
    """Return the panels of each decision's cost: working-set changes and time."""
    cost = effort(run)
    span = time_span(run)
    return (_changes(cost, span), _step_time(cost, span))


def comparison_panels(runs: Sequence[Run], pair: str, best: Run | None = None) -> tuple[Panel, ...]:
    """Return the panels of several runs of one scenario: felt force with the optimum; tilt; position.

    Raises
    ------
    ValueError : there is no run, or the runs are not of one scenario.
    """
    require_one_scenario(runs)
    names = labels(runs)
    all_series = [pair_series(run, pair) for run in runs]
    span = (0.0, max(time_span(run)[1] for run in runs))
    first = all_series[0]
    felt = overlay(names, all_series, lambda s: s.felt)
    curves = (reference_of(first), *felt, *best_felt(best, pair))
    return (
        Panel(
            key="compare-force",
            title="Specific force",
            axes=(axis_of("specific force [m/s²]", curves),),
            curves=curves,
            x_span=span,
        ),
        overlay_panel(
            "compare-tilt",
            "Tilt",
            "tilt [deg]",
            overlay(names, all_series, lambda s: s.tilt_deg),
            [s.tilt_band_deg for s in all_series],
            span,
        ),
        overlay_panel(
            "compare-position",
            "Position",
            "position [m]",
            overlay(names, all_series, lambda s: s.position),
            [s.position_band for s in all_series],
            span,
        ),
    )


def changes_panel(runs: Sequence[Run]) -> Panel:
    """Return a panel of how often each run needed at least k working-set changes in one step."""
    curves = []
    for k, (name, run) in enumerate(zip(labels(runs), runs, strict=True)):
        solver = solves(run)
        changes = effort(run).changes if solver else np.zeros(0)
        x, y = survival(changes)
        color, dash = _style(k)
        label = f"{name}: {_spread(changes) if solver else 'no solver'}"
        curves.append(Curve(label=label, x=x, y=y, color=color, kind="points", dash=dash, width=1.0))
    smallest = min((float(c.y.min()) for c in curves if len(c.y)), default=0.1)
    highest = max((float(c.x.max()) for c in curves if len(c.x)), default=1.0)
    return Panel(
        key="compare-changes",
        title="Distribution of working-set changes",
        axes=(Axis(label="share of steps", span=(0.6 * smallest, 1.6), log=True),),
        curves=tuple(curves),
        x_label="working-set changes in one step, at least",
        x_span=(-0.03 * max(1.0, highest), 1.03 * max(1.0, highest)),
    )


def solves(run: Run) -> bool:
    """Return whether the algorithm of a run solved anything: then its decisions have certificates."""
    return not len(run.residual) or bool(run.residual.any())


def require_one_scenario(runs: Sequence[Run]) -> None:
    """Refuse runs that cannot be compared.

    Raises
    ------
    ValueError : there is no run, or the runs are not of one scenario.
    """
    scenarios = sorted({run.scenario for run in runs})
    if len(scenarios) != 1:
        raise ValueError(f"a comparison needs runs of one scenario, got {scenarios}")


def _force(s: PairSeries, span: Band, best: tuple[Curve, ...]) -> Panel:
    curves = (
        reference_of(s),
        curve_of("felt", s.felt, palette.BLUE, width=1.4),
        curve_of(f"from {AXES[s.pair.translation]}", s.translation, palette.VERMILION, width=0.9),
        curve_of(f"from {AXES[s.pair.rotation]}", s.gravity, palette.GREEN, dash="dash", width=1.1),
        *(() if s.base is None else (curve_of("from the base", s.base, palette.ORANGE, width=0.9),)),
        *best,
    )
    return Panel(
        key="force",
        title="Specific force and its parts",
        axes=(axis_of("specific force [m/s²]", curves),),
        curves=curves,
        x_span=span,
    )


def _tilt(s: PairSeries, span: Band) -> Panel:
    return twin_panel(
        "tilt",
        "Tilt and tilt rate",
        ("tilt [deg]", "tilt rate [deg/s]"),
        (
            curve_of("tilt", s.tilt_deg, palette.BLUE, width=1.4),
            curve_of("tilt rate", s.tilt_rate_deg, palette.VERMILION, width=0.9, axis=1),
        ),
        (s.tilt_band_deg, s.tilt_rate_band_deg),
        span,
    )


def _position(s: PairSeries, span: Band) -> Panel:
    return twin_panel(
        "position",
        "Position and velocity",
        ("position [m]", "velocity [m/s]"),
        (
            curve_of("position", s.position, palette.BLUE, width=1.4),
            curve_of("velocity", s.velocity, palette.VERMILION, width=0.9, axis=1),
        ),
        (s.position_band, s.velocity_band),
        span,
    )


def _changes(cost: Effort, span: Band) -> Panel:
    x, y = stairs(cost.time, cost.changes, cost.period)
    label = f"changes: {_spread(cost.changes)}"
    bars = Curve(label=label, x=x, y=y, color=palette.BLUE, kind="stairs", width=0.6)
    marks = []
    for k, (status, where) in enumerate(cost.troubled().items()):
        at, height = decimate(cost.time[where] + cost.period / 2, cost.changes[where])
        color = (palette.VERMILION, palette.ORANGE, palette.PURPLE, palette.GREEN)[k % 4]
        name = f"{status}, ×{len(where)}"
        marks.append(Curve(label=name, x=at, y=height, color=color, kind="marks"))
    top = max(1.0, extent(y)[1])
    return Panel(
        key="changes",
        title="Working-set changes per step",
        axes=(Axis(label="changes", span=(0.0, top * (1.0 + 2 * MARGIN))),),
        curves=(bars, *marks),
        x_span=span,
    )


def _step_time(cost: Effort, span: Band) -> Panel:
    us = cost.step_time_us
    median, p99 = (float(np.percentile(us, q)) if len(us) else 0.0 for q in (50, 99))
    low, high = extent(us)
    log = len(us) > 0 and float(us.min()) > 0 and high > SPREAD * median
    bottom = 0.8 * float(us.min()) if log else low
    x, y = decimate(cost.time, us)
    return Panel(
        key="step-time",
        title="Time of each step",
        axes=(Axis(label="step time [µs]", span=(bottom, 1.2 * high or 1.0), log=log),),
        curves=(Curve(label="step", x=x, y=y, color=palette.SKY, kind="dots", width=1.5),),
        bounds=(
            Bound(label=f"median {_digits(median)} µs", values=(median,), color=palette.BLUE, dash="solid"),
            Bound(label=f"p99 {_digits(p99)} µs", values=(p99,), color=palette.VERMILION),
        ),
        x_span=span,
    )


def time_span(run: Run) -> Band:
    """Return the time from the start to the end of the last decision's period [s]."""
    return 0.0, max(run.period, run.decisions * run.period)


def curve_of(
    label: str, line: Line, color: str, *, dash: str = "solid", width: float, axis: int = 0
) -> Curve:
    """Return a line as a curve of a panel."""
    return Curve(label=label, x=line.x, y=line.y, color=color, dash=dash, width=width, axis=axis)


def reference_of(s: PairSeries | SingleSeries) -> Curve:
    """Return the reference as a broad grey line behind all others."""
    return curve_of("reference", s.reference, palette.GREY, width=2.6)


def best_felt(best: Run | None, dof: str) -> tuple[Curve, ...]:
    """Return what is felt along a degree of freedom in the best run that is possible, if that is known."""
    if best is None:
        return ()
    s = pair_series(best, dof) if dof in PAIRS else single_series(best, dof)
    return (curve_of("best possible", s.felt, palette.PURPLE, dash="dash", width=1.3),)


def _style(k: int) -> tuple[str, str]:
    n = len(palette.CYCLE)
    return palette.CYCLE[k % n], palette.DASHES[(k + k // n) % len(palette.DASHES)]


def overlay(
    names: Sequence[str], all_series: Sequence[Series], pick: Callable[[Series], Line]
) -> tuple[Curve, ...]:
    """Return one curve per run; later ones are thinner, so that equal curves all remain visible."""
    curves = []
    for k, (name, s) in enumerate(zip(names, all_series, strict=True)):
        color, dash = _style(k)
        curves.append(curve_of(name, pick(s), color, dash=dash, width=max(1.0, 2.0 - 0.3 * k)))
    return tuple(curves)


def overlay_panel(
    key: str, title: str, label: str, curves: tuple[Curve, ...], bands: Sequence[Band], span: Band
) -> Panel:
    """Return a panel of one quantity of several runs, with the limits of all of them."""
    unit = _unit(label)
    bounds = tuple(_bound(band, unit, curves, palette.GREY) for band in sorted(set(bands)))
    return Panel(
        key=key,
        title=title,
        axes=(axis_of(label, curves, bounds),),
        curves=curves,
        bounds=bounds,
        x_span=span,
    )


def twin_panel(
    key: str,
    title: str,
    axes: tuple[str, str],
    curves: tuple[Curve, Curve],
    bands: tuple[Band, Band],
    span: Band,
) -> Panel:
    """Return a panel of two curves, each with its own axis and colour, and zero at the same height."""
    bounds = tuple(
        _bound(band, _unit(label), (curve,), curve.color)
        for label, curve, band in zip(axes, curves, bands, strict=True)
    )
    return Panel(
        key=key,
        title=title,
        axes=tuple(
            _mirrored_axis(label, curve, bound)
            for label, curve, bound in zip(axes, curves, bounds, strict=True)
        ),
        curves=curves,
        bounds=bounds,
        x_span=span,
    )


def _bound(band: Band, unit: str, curves: Sequence[Curve], color: str) -> Bound:
    largest = max(map(abs, extent(*(curve.y for curve in curves))))
    far = min(map(abs, band)) > FAR * largest
    low, high = band
    size = f"±{high:.3g}" if high == -low else f"{low:.3g} to {high:.3g}"
    label = f"limit {size.replace('-', '−')} {unit}{' (off scale)' if far else ''}"
    return Bound(label=label, values=band, color=color, axis=curves[0].axis, far=far)


def axis_of(label: str, curves: Sequence[Curve], bounds: Sequence[Bound] = ()) -> Axis:
    """Return an axis that contains its curves and the limits near them."""
    low, high = _shown_extent(curves, bounds)
    margin = MARGIN * (high - low) or 1.0
    return Axis(label=label, span=(low - margin, high + margin))


def _mirrored_axis(label: str, curve: Curve, bound: Bound) -> Axis:
    """Return an axis with zero in its middle, so that both curves of a panel share their zero line.

    The right axis has a larger margin, so that the limits of both axes do not coincide.
    """
    margin = (2 + 4 * curve.axis) * MARGIN
    largest = max(map(abs, _shown_extent((curve,), (bound,)))) * (1.0 + margin) or 1.0
    return Axis(label=label, span=(-largest, largest), color=curve.color)


def _shown_extent(curves: Sequence[Curve], bounds: Sequence[Bound]) -> Band:
    shown = [np.array(bound.values) for bound in bounds if not bound.far]
    return extent(*(curve.y for curve in curves), *shown)


def _unit(label: str) -> str:
    return label[label.index("[") + 1 : label.index("]")]


def _digits(value: float) -> str:
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def _spread(changes: Vec) -> str:
    if len(changes) == 0:
        return "no steps"
    mean, p99, largest = changes.mean(), np.percentile(changes, 99), changes.max()
    return f"mean {_digits(mean)}, p99 {_digits(p99)}, max {largest:.0f}"
