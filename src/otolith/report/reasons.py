"""The reasons of a ranking in words: leads, costs, and algorithms that were ruled out."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

from otolith.metrics import Better, breaches
from otolith.metrics.measure import Summary
from otolith.report.ranking import ByCueing, Criterion, Standing, criterion

CLOSE: Final = 0.02  # a lead below this share is called small
USED: Final = criterion("workspace", "Reach used")
MISLED: Final = criterion("false_cues", "Misled")


def why(scenarios: Mapping[str, ByCueing], ranked: Sequence[Standing], by: Criterion) -> list[str]:
    """Return one or two sentences per scenario, preceded by one on all scenarios if there are several."""
    each = [_in_one(k, name, of_one, ranked, by) for k, (name, of_one) in enumerate(scenarios.items())]
    return ([_over_all(ranked)] if len(scenarios) > 1 else []) + each


def _over_all(ranked: Sequence[Standing]) -> str:
    best = [one for one in ranked if one.mean_rank == ranked[0].mean_rank]
    names = _listed([one.cueing for one in best])
    if len(best) > 1:
        kept = [one for one in best if not any(one.broken)]
        if len(kept) == 1 and kept[0] is best[0]:
            reason = "it alone kept every hard limit"
        else:
            reason = "its measure, relative to the best of each scenario, is the best in the mean"
            reason += " of those that kept every hard limit" if 0 < len(kept) < len(best) else ""
        return (
            f"Over all, {names} tie with a mean rank of {best[0].mean_rank:.2f}; "
            f"{best[0].cueing} stands first, for {reason}."
        )
    return f"Over all, {names} is best, with a mean rank of {best[0].mean_rank:.2f} and {_wins(best[0])}."


def _wins(one: Standing) -> str:
    return f"{one.wins} win" + ("" if one.wins == 1 else "s")


def _in_one(k: int, scenario: str, of_one: ByCueing, ranked: Sequence[Standing], by: Criterion) -> str:
    """Explain the ranking of scenario k: the lead, its cost, and who was ruled out by limits."""
    order = sorted(ranked, key=lambda one: one.ranks[k])
    best = [one for one in order if one.ranks[k] == 1]
    after = order[len(best)] if len(order) > len(best) else None
    value = f"{by.words[0].lower()}{by.words[1:]} {by.shown(best[0].values[k]):.3g} {by.unit}".rstrip()
    if len(best) > 1:
        text = f"{scenario}: {_listed([one.cueing for one in best])} tie for the first place, {value}"
    else:
        text = f"{scenario}: {best[0].cueing} is best, {value}"
    if after is not None:
        text += _against(best[0], after, k, of_one, by)
    return f"{text}.{_ruled_out(k, of_one, order, best[0], by)}{_beside_the_best(of_one, order)}"


def _against(best: Standing, after: Standing, k: int, of_one: ByCueing, by: Criterion) -> str:
    """State how far the next algorithm is behind, and the cost of both."""
    mine, other = best.values[k], after.values[k]
    if bool(best.broken[k]) != bool(after.broken[k]):
        lead = f"; {after.cueing} comes next"
    elif mine > 0.0 and other > 0.0:
        word, more = (
            ("less", 1.0 - other / mine) if by.better is Better.HIGHER else ("more", other / mine - 1.0)
        )
        size = "only " if more < CLOSE else ""
        percent = f"{100.0 * more:.0f}" if more > 0.1 else f"{100.0 * more:.2g}"
        lead = f"; {after.cueing} has {size}{percent} % {word}"
    else:
        lead = f"; {after.cueing} has {by.shown(other):.3g}"
    took = [_took(of_one[one.cueing]) for one in (best, after)]
    if not all(took):
        return lead
    if took[0] == took[1]:
        return f"{lead}. Both {took[0]}"
    return f"{lead}. {best.cueing} {took[0]}, {after.cueing} {took[1]}"


def _took(summary: Summary) -> str:
    """State the reach that was used and the time that the driver was misled, as far as defined."""
    used, misled = USED.of(summary), MISLED.of(summary)
    costs = [] if math.isnan(used) else [f"used {used:.0f} {USED.unit} of the reach"]
    costs += [] if math.isnan(misled) else [f"misled for {misled:.1f} {MISLED.unit}"]
    return " and ".join(costs)


def _ruled_out(k: int, of_one: ByCueing, order: Sequence[Standing], best: Standing, by: Criterion) -> str:
    """Name algorithms with a better measure that passed a hard limit, or state that all passed one."""
    if best.broken[k]:
        return " All of them passed a hard limit." if all(one.broken[k] for one in order) else ""
    found = []
    for one in order:
        mine, other = one.values[k], best.values[k]
        if one.broken[k] and (mine > other if by.better is Better.HIGHER else mine < other):
            first = next(iter(breaches(of_one[one.cueing])), "a hard limit was passed")
            found.append(
                f" {one.cueing} has a {by.better} one, {by.shown(mine):.3g}, and is ruled out: {first}."
            )
    return "".join(found)


def _beside_the_best(of_one: ByCueing, order: Sequence[Standing]) -> str:
    """State how far each is from the best that is possible, where that is known."""
    entries = {one.cueing: of_one[one.cueing].get("optimum", {"not_computed": ""}) for one in order}
    if all("not_computed" in one for one in entries.values()):
        return ""
    times = {name: one.get("times") for name, one in entries.items()}
    if not any(times.values()):
        return " A perfect answer is within reach of the platform on this drive."
    known = [f"{name} {value:.2f}" for name, value in times.items() if value is not None]
    return f" Times the least possible error on this drive: {', '.join(known)}."


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
