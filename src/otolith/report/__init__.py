"""Reports of runs: figures for papers, and self-contained pages. They read runs and know no algorithm.

Names are imported on first use, because plotting takes a second to import and a refused command should not
wait for that.
"""

from typing import TYPE_CHECKING

from otolith.core.lazy import on_first_use

if TYPE_CHECKING:
    from otolith.report.comparison import render_comparison, render_contest
    from otolith.report.figures import comparison_figure, cueing_figure, overview_figure, save_figure
    from otolith.report.html import render
    from otolith.report.ranking import Criterion, Standing, criteria, criterion_named, standings
    from otolith.report.timing import step_time_figure
else:
    __getattr__ = on_first_use(
        __name__,
        {
            "render_comparison": "comparison",
            "render_contest": "comparison",
            "comparison_figure": "figures",
            "cueing_figure": "figures",
            "overview_figure": "figures",
            "save_figure": "figures",
            "render": "html",
            "Criterion": "ranking",
            "Standing": "ranking",
            "criteria": "ranking",
            "criterion_named": "ranking",
            "standings": "ranking",
            "step_time_figure": "timing",
        },
    )

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
