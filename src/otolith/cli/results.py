"""The files that commands write of their runs: run.h5, summary.json, report.html and, if asked, figures."""

from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from otolith import files
from otolith.cli.figures import write_figure
from otolith.cueing.optimum import Optimum
from otolith.loop import Run

if TYPE_CHECKING:  # imported on use, so that bad input is refused sooner
    from matplotlib.figure import Figure

Out = Annotated[Path | None, typer.Option(help="Folder for the results (default: out/SCENARIO-CUEING).")]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
]

# Drawing takes as long as all the rest of a short run, and most runs are looked at on their page alone.
Figures = Annotated[
    bool, typer.Option("--figures", help="Draw figures for papers besides, each as PDF and as PNG.")
]


def write_results(
    result: Run, folder: Path, *, command: str, force: bool, best: Optimum | str, figures: bool = False
) -> dict[str, Any]:
    """Write run.h5, and all that `write_account` writes; return the key figures."""
    with files.whole_folder(folder, command=command, force=force) as made:
        files.write_run(result, made / "run.h5")
        return write_account(result, made, best=best, figures=figures)


def write_account(result: Run, folder: Path, *, best: Optimum | str, figures: bool = False) -> dict[str, Any]:
    """Write summary.json and report.html of one run; return the key figures.

    Parameters
    ----------
    best : the optimum of the run's drive, or in words why it is unknown.
    figures : draw a figure for each degree of freedom, too.
    """
    from otolith import metrics, report

    summary = metrics.summarise(result, best)
    drawn = None if isinstance(best, str) or best.run is result else best.run
    write_all(folder, summary, report.render(result, summary, date=today(), best=drawn))
    if figures:
        write_figures(
            folder, figures_of(result.dofs, lambda dof: report.cueing_figure(result, dof, best=drawn))
        )
    return summary


def figures_of(dofs: Sequence[str], draw: Callable[[str], "Figure"]) -> dict[str, "Figure"]:
    """Return one figure per degree of freedom, by file name."""
    return {"figure" if len(dofs) == 1 else f"figure-{dof}": draw(dof) for dof in dofs}


def write_all(folder: Path, summary: dict[str, Any], page: str) -> None:
    """Write the summary and the page."""
    files.write_json(folder / "summary.json", summary)
    files.write_text(folder / "report.html", page)


def write_figures(folder: Path, figures: dict[str, "Figure"]) -> None:
    """Write figures by file name."""
    for name, figure in figures.items():
        write_figure(folder, name, figure)


def today() -> str:
    """Return the date, as pages show it."""
    return datetime.now().astimezone().date().isoformat()
