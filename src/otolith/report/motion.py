"""The panels of one degree of freedom: an axis pair, heave or yaw."""

from collections.abc import Sequence
from typing import Final

from otolith.core.frames import PAIRS
from otolith.loop import Run
from otolith.report import palette
from otolith.report.panels import (
    Curve,
    Panel,
    axis_of,
    best_felt,
    comparison_panels,
    curve_of,
    overlay,
    overlay_panel,
    reference_of,
    require_one_scenario,
    run_panels,
    time_span,
    twin_panel,
)
from otolith.report.series import Band, SingleSeries, base_series, labels, single_series

FELT: Final = {"heave": "vertical force", "yaw": "yaw rate"}
PLACE: Final = {"heave": "height", "yaw": "yaw angle"}


def motion_panels(run: Run, dof: str, best: Run | None = None) -> tuple[Panel, ...]:
    """Return the panels that show one degree of freedom of a run, together with the optimum."""
    if dof in PAIRS:
        return (*run_panels(run, dof, best), *_base(run, dof))
    series, span = single_series(run, dof), time_span(run)
    return (_felt(series, span, best_felt(best, dof)), _place(series, span), *_base(run, dof))


def motion_comparison(runs: Sequence[Run], dof: str, best: Run | None = None) -> tuple[Panel, ...]:
    """Return the panels that show one degree of freedom of several runs of one scenario, and the optimum.

    Raises
    ------
    ValueError : there is no run, or the runs are not of one scenario.
    """
    if dof in PAIRS:
        return comparison_panels(runs, dof, best)
    require_one_scenario(runs)
    names, every = labels(runs), [single_series(run, dof) for run in runs]
    span = (0.0, max(time_span(run)[1] for run in runs))
    first = every[0]
    felt = (reference_of(first), *overlay(names, every, lambda s: s.felt), *best_felt(best, dof))
    return (
        Panel(
            key=f"compare-{dof}",
            title=FELT[dof].capitalize(),
            axes=(axis_of(f"{FELT[dof]} [{first.units[0]}]", felt),),
            curves=felt,
            x_span=span,
        ),
        overlay_panel(
            f"compare-{dof}-place",
            PLACE[dof].capitalize(),
            f"{PLACE[dof]} [{first.units[1]}]",
            overlay(names, every, lambda s: s.place),
            [s.place_band for s in every],
            span,
        ),
    )


def _base(run: Run, dof: str) -> tuple[Panel, ...]:
    """Return the panel of the base's axis that carries a degree of freedom, if there is one."""
    s = base_series(run, dof)
    if s is None:
        return ()
    curves = (
        curve_of("place", s.place, palette.ORANGE, width=1.4),
        curve_of("speed", s.speed, palette.VERMILION, width=0.9, axis=1),
    )
    labels_of = (f"place of the base [{s.units[0]}]", f"speed [{s.units[1]}]")
    bands = (s.place_band, s.speed_band)
    return (twin_panel("base", "The base", labels_of, curves, bands, time_span(run)),)


def _felt(s: SingleSeries, span: Band, best: tuple[Curve, ...]) -> Panel:
    curves = (reference_of(s), curve_of("felt", s.felt, palette.BLUE, width=1.4), *best)
    return Panel(
        key=s.axis,
        title=FELT[s.axis].capitalize(),
        axes=(axis_of(f"{FELT[s.axis]} [{s.units[0]}]", curves),),
        curves=curves,
        x_span=span,
    )


def _place(s: SingleSeries, span: Band) -> Panel:
    place, speed = PLACE[s.axis], "speed" if s.axis == "heave" else "rate"
    return twin_panel(
        f"{s.axis}-place",
        f"{place.capitalize()} and {speed}",
        (f"{place} [{s.units[1]}]", f"{speed} [{s.units[2]}]"),
        (
            curve_of(place, s.place, palette.BLUE, width=1.4),
            curve_of(speed, s.speed, palette.VERMILION, width=0.9, axis=1),
        ),
        (s.place_band, s.speed_band),
        span,
    )
