"""Figures as commands write them: each one as PDF, for papers, and as PNG."""

import functools
from pathlib import Path
from typing import TYPE_CHECKING

from otolith import files

if TYPE_CHECKING:  # drawing is imported when there is something to draw
    from matplotlib.figure import Figure


def write_figure(folder: Path, name: str, figure: "Figure") -> None:
    """Write `figure` as NAME.pdf and NAME.png; its parts are arranged once for both."""
    from otolith.report.figures import arranged, save_figure

    with arranged(figure):
        for ending in ("pdf", "png"):
            files.write_figure(folder / f"{name}.{ending}", functools.partial(save_figure, figure))
