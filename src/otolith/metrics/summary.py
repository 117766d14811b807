"""A run's summary, a table of its key figures as plain JSON values; and the summaries of several runs."""

from collections.abc import Sequence
from typing import Any, Final

from otolith.loop import Run
from otolith.metrics.against_best import Best, against_best, not_computed
from otolith.metrics.catalogue import MEASURES

BASELINE: Final = "implicit"  # percentages are relative to this model, as in Table 5.6


def summarise(run: Run, best: Best | str | None = None) -> dict[str, Any]:
    """Return every key figure of `MEASURES` by name, and what is needed to repeat the run.

    docs/metrics.md defines keys, units and figures. All values are in SI units unless a key or an entry names
    another unit.

    Parameters
    ----------
    best : the best that is possible on the run's drive (`Experiment.optimum`), or in words the reason why it
        is unknown. Without it the summary has no key `optimum`.
    """
    return {
        "scenario": run.scenario,
        "cueing": run.cueing,
        "plant": run.plant,
        "platform": run.platform.name,
        "dofs": ",".join(run.dofs),
        "duration_s": run.duration,
        "period_s": run.period,
        **{
            name: measure.of(run)
            for name, measure in MEASURES.items()
            if measure.of is not None and (measure.defined(run.dofs) or not measure.optional)
        },
        **({} if best is None else {"optimum": _against(run, best)}),
        "settings": run.settings,
    }


def with_best(summary: dict[str, Any], run: Run, best: Best | str) -> dict[str, Any]:
    """Return the summary that `summarise` makes with the best, given the one that it made without."""
    kept = {name: value for name, value in summary.items() if name != "settings"}
    return {**kept, "optimum": _against(run, best), "settings": summary["settings"]}


def _against(run: Run, best: Best | str) -> dict[str, Any]:
    return not_computed(best) if isinstance(best, str) else against_best(run, best)


def compare(runs: Sequence[Run], best: Sequence[Best | str] | None = None) -> dict[str, dict[str, Any]]:
    """Return summaries by cueing, each with its mean working-set changes relative to the implicit MPC's [%].

    Negative means fewer changes. The percentage is absent if there is no run of the baseline, or if the
    baseline made no change.

    Parameters
    ----------
    best : for each run, the argument of `summarise`.
    """
    known: Sequence[Best | str | None] = best or [None] * len(runs)
    return against_baseline(
        {run.cueing: summarise(run, of_run) for run, of_run in zip(runs, known, strict=True)}
    )


def against_baseline(summaries: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Add to summaries by cueing what `compare` adds, in place, and return them."""
    base = summaries.get(BASELINE, {}).get("changes", {}).get("mean", 0.0)
    if base > 0.0:
        for summary in summaries.values():
            summary["changes_against_implicit_percent"] = 100.0 * (summary["changes"]["mean"] / base - 1.0)
    return summaries
