"""Five key figures of a run, each on a scale whose ends are said in words, so that a number means something.

The ends are facts, not grades: what a perfect platform, one that stands still, or one at its limit would get.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

from otolith.report.ranking import MISLEADING

Summary = Mapping[str, Any]
DOCS = "docs/metrics.md"


@dataclass(frozen=True, slots=True, kw_only=True)
class Gauge:
    """One figure on its scale."""

    title: str
    value: str
    share: float  # of the scale's length, from its left end; beyond 1 it is off the scale
    ends: tuple[str, str]  # what the left and the right end of the scale mean
    words: str  # what the figure is
    more: str  # heading of `DOCS` that defines it


def gauges(summary: Summary) -> list[Gauge]:
    """The five, or those of them that the summary holds; of several degrees of freedom the worst one."""
    found = (_error(summary), _shape(summary), _misled(summary), _reach(summary), _slowest(summary))
    return [gauge for gauge in found if gauge is not None]


def gauges_html(summary: Summary) -> str:
    """The five as a row of cards."""
    return f'<div class="gauges">{"".join(map(_card, gauges(summary)))}</div>'


def _error(summary: Summary) -> Gauge | None:
    wanted, errors = summary.get("wanted_rms", {}), summary.get("rmse_per_pair", {})
    unit, what = "m/s²", "specific force"
    if not errors:
        errors, unit, what = summary.get("rate_rmse", {}), "deg/s", "yaw rate"
    size = math.hypot(*(wanted.get(name, math.nan) for name in errors))
    if not errors or not size > 0.0:
        return None
    error = math.hypot(*errors.values())
    shown = math.degrees(error) if unit == "deg/s" else error
    return Gauge(
        title="Tracking error",
        value=f"{shown:.3g} {unit}",
        share=error / size,
        ends=("felt as wanted", "nothing felt"),
        words=f"Root mean square of felt minus wanted {what}: {_percent(error / size)} of what was wanted. "
        "A platform that stands still gets 100 %.",
        more="Tracking error",
    )


def _shape(summary: Summary) -> Gauge | None:
    known = {name: r for name, r in summary.get("correlation", {}).items() if r is not None}
    if not known:
        return None
    name, r = min(known.items(), key=lambda item: item[1])
    of = f" (of {name}, the lowest)" if len(known) > 1 else ""
    return Gauge(
        title="Same shape",
        value=f"{r:.2f}".replace("-", "−"),
        share=1.0 - r,
        ends=("same shape", "unrelated"),
        words=f"Correlation of felt and wanted{of}: 1 is the same shape, whatever the size; 0 is unrelated, "
        f"less is opposite. Squared, {_percent(r * r)} of the variation is felt in proportion.",
        more="Correlation",
    )


def _misled(summary: Summary) -> Gauge | None:
    duration, cues = summary.get("duration_s"), summary.get("false_cues", {})
    if not duration or not cues:
        return None
    seconds = {name: sum(of[kind]["duration_s"] for kind in MISLEADING) for name, of in cues.items()}
    name, longest = max(seconds.items(), key=lambda item: item[1])
    of = f" (in {name}, the longest)" if len(seconds) > 1 else ""
    return Gauge(
        title="Misled",
        value=f"{longest:.1f} of {duration:.4g} s",
        share=longest / duration,
        ends=("never", "all the time"),
        words=f"Time in which a cue was missing, unwanted or of the wrong sign{of}, by 0.17 m/s² or more.",
        more="False cues",
    )


def _reach(summary: Summary) -> Gauge | None:
    used = {axis: use["largest"] for axis, use in summary.get("workspace", {}).items()}
    if not used:
        return None
    axis, largest = max(used.items(), key=lambda item: item[1])
    return Gauge(
        title="Reach used",
        value=f"{_percent(largest)} of {axis}",
        share=largest,
        ends=("at rest", "at its end"),
        words="Largest share of its travel that any axis used. Room that is left could have carried cues; "
        "beyond 100 % the machine would have hit its end.",
        more="Use of the reach",
    )


def _slowest(summary: Summary) -> Gauge | None:
    times, period = summary.get("step_time_us"), summary.get("period_s")
    if not times or not period:
        return None
    slowest = 1e-6 * times["max"]
    return Gauge(
        title="Slowest decision",
        value=f"{1e3 * slowest:.2g} of {1e3 * period:.3g} ms",
        share=slowest / period,
        ends=("at once", "too late"),
        words="Longest processor time of one decision on this computer, beside the controller's period, "
        f"within which it has to be there. The median is {1e-3 * times['median']:.3g} ms.",
        more="Time and changes",
    )


def _card(gauge: Gauge) -> str:
    place = 100.0 * min(1.0, max(0.0, gauge.share)) if math.isfinite(gauge.share) else 100.0
    beyond = " beyond" if not gauge.share <= 1.0 else ""
    left, right = (escape(end) for end in gauge.ends)
    return (
        f'<div class="gauge"><h3>{escape(gauge.title)}</h3><p class="value">{escape(gauge.value)}</p>'
        f'<div class="scale{beyond}" role="img" aria-label="{place:.0f} % of the way from {left} to {right}">'
        f'<i style="width: {place:.1f}%"></i></div>'
        f'<p class="ends"><span>{left}</span><span>{right}</span></p>'
        f"<details><summary>What it says</summary><p>{escape(gauge.words)}</p>"
        f"<p>{DOCS}, “{escape(gauge.more)}”</p></details></div>"
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %" if share >= 0.1 else f"{100.0 * share:.2g} %"
