"""Runs made visible: figures for papers and self-contained pages. Reads runs, knows no algorithm."""

from otolith.report.comparison import render_comparison, render_contest
from otolith.report.figures import comparison_figure, cueing_figure, overview_figure, save_figure
from otolith.report.html import render
from otolith.report.ranking import MEASURES, Standing, measure_named, standings
from otolith.report.timing import step_time_figure

__all__ = [
    "MEASURES",
    "Standing",
    "comparison_figure",
    "cueing_figure",
    "measure_named",
    "overview_figure",
    "render",
    "render_comparison",
    "render_contest",
    "save_figure",
    "standings",
    "step_time_figure",
]
