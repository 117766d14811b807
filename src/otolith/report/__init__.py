"""Runs made visible: figures for papers and self-contained pages. Reads runs, knows no algorithm.

Its names are imported on use: drawing takes a second to import, for which no refused command has to wait.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from otolith.report.comparison import render_comparison, render_contest
    from otolith.report.figures import comparison_figure, cueing_figure, overview_figure, save_figure
    from otolith.report.html import render
    from otolith.report.ranking import Criterion, Standing, criteria, criterion_named, standings
    from otolith.report.timing import step_time_figure

_MODULES: Final = {
    "comparison": ("render_comparison", "render_contest"),
    "figures": ("comparison_figure", "cueing_figure", "overview_figure", "save_figure"),
    "html": ("render",),
    "ranking": ("Criterion", "Standing", "criteria", "criterion_named", "standings"),
    "timing": ("step_time_figure",),
}

__all__ = [
    "Criterion",
    "Standing",
    "comparison_figure",
    "criteria",
    "criterion_named",
    "cueing_figure",
    "overview_figure",
    "render",
    "render_comparison",
    "render_contest",
    "save_figure",
    "standings",
    "step_time_figure",
]


def __getattr__(name: str) -> Any:
    for module, names in _MODULES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__} has no attribute {name}")
