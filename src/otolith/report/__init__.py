"""Runs made visible: figures for papers and self-contained pages. Reads runs, knows no algorithm."""

from otolith.report.figures import comparison_figure, cueing_figure, save_figure
from otolith.report.html import render, render_comparison

__all__ = ["comparison_figure", "cueing_figure", "render", "render_comparison", "save_figure"]
