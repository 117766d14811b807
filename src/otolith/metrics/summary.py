"""A run's summary, a table of its key figures as plain JSON values; and the summaries of several runs."""

from collections.abc import Sequence
from typing import Any, Final

from otolith.loop import Run
from otolith.metrics.catalogue import MEASURES

BASELINE: Final = "implicit"  # percentages are relative to this model, as in Table 5.6


def summarise(run: Run) -> dict[str, Any]:
    """Return every key figure of `MEASURES` by name, and what is needed to repeat the run.

    docs/metrics.md defines keys, units and figures. All values are in SI units unless a key or an entry names
    another unit.
    """
    return {
        "scenario": run.scenario,
        "cueing": run.cueing,
        "plant": run.plant,
        "platform": run.platform.name,
        "dofs": ",".join(run.dofs),
        "duration_s": float(run.time[-1]),
        "period_s": run.period,
        **{
            name: measure.of(run)
            for name, measure in MEASURES.items()
            if measure.of is not None and (measure.defined(run.dofs) or not measure.optional)
        },
        "settings": run.settings,
    }


def compare(runs: Sequence[Run]) -> dict[str, dict[str, Any]]:
    """Return summaries by cueing, each with its mean working-set changes relative to the implicit MPC's [%].

    Negative means fewer changes. The percentage is absent if there is no run of the baseline, or if the
    baseline made no change.
    """
    summaries = {run.cueing: summarise(run) for run in runs}
    base = summaries.get(BASELINE, {}).get("changes", {}).get("mean", 0.0)
    if base > 0.0:
        for summary in summaries.values():
            summary["changes_against_implicit_percent"] = 100.0 * (summary["changes"]["mean"] / base - 1.0)
    return summaries
