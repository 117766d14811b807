"""Runs in a notebook: a small table of key figures instead of printed arrays, and a figure."""

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from otolith.core.errors import InputError, one_of
from otolith.loop import Run
from otolith.metrics import breaches, failures, summarise

if TYPE_CHECKING:  # plotting is imported only when something is drawn
    from matplotlib.figure import Figure

_HEAD = ("cued by", "scenario", "platform", "plant", "RMSE [m/s²]", "decisions that failed", "limits passed")


def card(runs: Sequence[Run]) -> str:
    """Return a small HTML table of key figures, one row per run, without styles or scripts."""
    head = "".join(f"<th>{escape(name)}</th>" for name in _HEAD)
    rows = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in _cells(run))}</tr>" for run in runs)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>"


def _cells(run: Run) -> tuple[str, ...]:
    summary = summarise(run)
    rmse = "–" if summary["rmse"] is None else f"{summary['rmse']:.4f}"
    failed, passed = "; ".join(failures(summary)) or "none", "; ".join(breaches(summary)) or "none"
    return run.cueing, run.scenario, run.platform.name, run.plant, rmse, failed, passed


def figure(runs: Sequence[Run], dof: str | None = None) -> "Figure":
    """Draw one run, or several side by side, for one degree of freedom (default: the first that is cued).

    Raises
    ------
    InputError : this degree of freedom was not cued.
    """
    from otolith.report.figures import comparison_figure, cueing_figure

    cued = runs[0].dofs
    name = cued[0] if dof is None else dof
    if name not in cued:
        raise InputError("degree of freedom", repr(name), one_of(cued, name))
    return cueing_figure(runs[0], name) if len(runs) == 1 else comparison_figure(list(runs), name)


class Comparison:
    """Runs of one scenario side by side: `summaries` by algorithm, a table in a notebook, `plot()`.

    Raises
    ------
    InputError : there are fewer than two runs, or they differ in scenario or degrees of freedom.
    """

    def __init__(self, runs: Sequence[Run]) -> None:
        if len(runs) < 2:
            raise InputError("runs to compare", len(runs), "at least 2")
        kinds = {(run.scenario, run.dofs) for run in runs}
        if len(kinds) > 1:
            raise InputError("runs to compare", f"of {len(kinds)} kinds", "of one scenario and what is cued")
        self.runs = tuple(runs)

    def _repr_html_(self) -> str:
        return card(self.runs)

    def plot(self, dof: str | None = None) -> "Figure":
        """Draw the runs side by side; arguments and errors are those of `figure`."""
        return figure(self.runs, dof)
