"""Six key figures of a run, each on a scale whose ends are described in words, which gives it a meaning.

The ends are facts, not grades: the result of a perfect platform, of one that stands still, or of one at its
limit. Of several degrees of freedom, the worst is shown.
"""

import math
from typing import Final

from otolith.metrics.against_best import best_in_words
from otolith.metrics.false_cues import MISLEADING, THRESHOLD
from otolith.metrics.measure import Reading, Scale, Summary


def _error(summary: Summary) -> Reading | None:
    wanted, errors = summary.get("wanted_rms", {}), summary.get("rmse_per_pair", {})
    unit, what = "m/s²", "specific force"
    if not errors:
        errors, unit, what = summary.get("rate_rmse", {}), "deg/s", "yaw rate"
    size = math.hypot(*(wanted.get(name, math.nan) for name in errors))
    if not errors or not size > 0.0:
        return None
    error = math.hypot(*errors.values())
    shown = math.degrees(error) if unit == "deg/s" else error
    return Reading(
        value=f"{shown:.3g} {unit}",
        share=error / size,
        words=f"Root mean square of felt minus wanted {what}: {_percent(error / size)} of what was wanted. "
        "A platform that stands still gets 100 %.",
    )


def _times(summary: Summary) -> Reading | None:
    entry = summary.get("optimum", {})
    times = entry.get("times")
    if times is None:
        return None
    room = entry["standing_still"] - 1.0  # zero if the best motion is to stand still
    words = best_in_words(summary)
    return Reading(
        value=f"{times:.3g} times",
        share=(times - 1.0) / room if room > 0.0 else float(times > 1.0),
        words=f"{words[0].upper()}{words[1:]}. A platform that stands still has "
        f"{entry['standing_still']:.3g} times the best.",
    )


def _shape(summary: Summary) -> Reading | None:
    known = {name: r for name, r in summary.get("correlation", {}).items() if r is not None}
    if not known:
        return None
    name, r = min(known.items(), key=lambda item: item[1])
    of = f" (of {name}, the lowest)" if len(known) > 1 else ""
    return Reading(
        value=f"{r:.2f}".replace("-", "−"),
        share=1.0 - r,
        words=f"Correlation of felt and wanted{of}: 1 is the same shape, whatever the size; 0 is unrelated, "
        f"less is opposite. Squared, {_percent(r * r)} of the variation is felt in proportion.",
    )


def _misled(summary: Summary) -> Reading | None:
    duration, cues = summary.get("duration_s"), summary.get("false_cues", {})
    if not duration or not cues:
        return None
    seconds = {name: sum(of[kind]["duration_s"] for kind in MISLEADING) for name, of in cues.items()}
    name, longest = max(seconds.items(), key=lambda item: item[1])
    of = f" (in {name}, the longest)" if len(seconds) > 1 else ""
    return Reading(
        value=f"{longest:.1f} of {duration:.4g} s",
        share=longest / duration,
        words=f"Time in which a cue was missing, unwanted or of the wrong sign{of}, by {THRESHOLD} m/s² or "
        "more.",
    )


def _reach(summary: Summary) -> Reading | None:
    used = {axis: use["largest"] for axis, use in summary.get("workspace", {}).items()}
    if not used:
        return None
    axis, largest = max(used.items(), key=lambda item: item[1])
    return Reading(
        value=f"{_percent(largest)} of {axis}",
        share=largest,
        words="Largest share of its travel that any axis used. Room that is left could have carried cues; "
        "beyond 100 % the machine would have hit its end.",
    )


def _slowest(summary: Summary) -> Reading | None:
    times, period = summary.get("step_time_us"), summary.get("period_s")
    if not times or not period:
        return None
    slowest = 1e-6 * times["max"]
    return Reading(
        value=f"{1e3 * slowest:.2g} of {1e3 * period:.3g} ms",
        share=slowest / period,
        words="Longest processor time of one decision on this computer, beside the controller's period, "
        f"within which it has to be there. The median is {1e-3 * times['median']:.3g} ms.",
    )


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %" if share >= 0.1 else f"{100.0 * share:.2g} %"


TIMES_THE_BEST: Final = Scale(title="Against the best", ends=("the best", "nothing felt"), read=_times)
TRACKING_ERROR: Final = Scale(title="Tracking error", ends=("as wanted", "nothing felt"), read=_error)
SAME_SHAPE: Final = Scale(title="Same shape", ends=("same shape", "unrelated"), read=_shape)
MISLED: Final = Scale(title="Misled", ends=("never", "all the time"), read=_misled)
REACH_USED: Final = Scale(title="Reach used", ends=("at rest", "at its end"), read=_reach)
SLOWEST_DECISION: Final = Scale(title="Slowest decision", ends=("at once", "too late"), read=_slowest)
