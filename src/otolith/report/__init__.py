"""Runs made visible: figures for papers and self-contained pages. Reads runs, knows no algorithm."""

from otolith.report.figures import comparison_figure, cueing_figure, save_figure
from otolith.report.html import render, render_comparison
from otolith.report.timing import step_time_figure

__all__ = [
    "comparison_figure",
    "cueing_figure",
    "render",
    "render_comparison",
    "save_figure",
    "step_time_figure",
]
