"""Reports of runs: figures for papers, and self-contained pages. They read runs and know no algorithm.

Names are imported on first use, because plotting takes a second to import and a refused command should not
wait for that.
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
