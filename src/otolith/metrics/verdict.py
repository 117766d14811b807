"""What went wrong in a run, in words that the command line and the reports share.

Everything is read from a run's summary (`otolith.metrics.summarise`), so that all places agree. Only a hard
limit of the machine is "broken"; limits that an algorithm may pass, or that a driver may notice, are
"exceeded".
"""

from typing import Final

from otolith.interfaces import Status
from otolith.metrics.measure import Summary

FAILURES: Final = {  # status of a decision -> what happened, and why
    "fallback": "fell back to braking",
    "fallback (infeasible)": "fell back to braking: the problem had no solution",
    "fallback (limit)": "fell back to braking: the solver ended without a solution",
    "fallback (uncertified)": "fell back to braking: the solver's answer did not stand the test",
    "refused": "fell back to braking: the answer led to where the platform could not stop",
    "invalid": "went without their input, which held no number or one beyond all reason",
}


def failures(summary: Summary) -> list[str]:
    """Return a sentence, with the count, per kind of decision that the algorithm did not make itself."""
    status = summary.get("status", {})
    total = sum(status.values())
    return [
        f"{count:,} of {total:,} decisions {FAILURES.get(kind, f'ended as {kind}')}"
        for kind, count in status.items()
        if kind != Status.DECIDED and count
    ]


def breaches(summary: Summary) -> list[str]:
    """Return a sentence per limit that was passed at a controller's node, the machine's hard limits first."""
    nodes = sum(summary.get("status", {}).values())
    passed = [one for one in summary.get("limits", {}).values() if one["nodes_beyond"]]
    passed.sort(key=lambda one: (one["soft"], one["comfort"]))
    return [
        f"{kind(one)} {'exceeded' if one['soft'] or one['comfort'] else 'broken'}: {one['name']} "
        f"{by_how_much(one)} beyond {bounds(one)}, at {one['nodes_beyond']:,} of {nodes:,} nodes"
        for one in passed
    ]


def held_back(summary: Summary) -> list[str]:
    """Return a sentence per limit for which the legs' supervisor reduced the motion."""
    return [
        f"the supervisor acted for {limit}: {one['times']:,} times, {_short(one['seconds'])} s together, "
        f"up to {_short(1e3 * one['behind_m'])} mm behind"
        for limit, one in summary.get("supervisor", {}).items()
    ]


def between_nodes(summary: Summary) -> list[str]:
    """Return a sentence per limit that was kept at the nodes but passed between them."""
    return [
        f"between nodes {one['name']} {by_how_much(one, 'excess_between_nodes')} beyond {bounds(one)}"
        for one in summary.get("limits", {}).values()
        if not one["nodes_beyond"] and one["excess_between_nodes"] != 0.0
    ]


def kind(limit: Summary) -> str:
    """Return whether a limit was hard or soft in a run, and whether it protects the machine or the driver."""
    hardness = "soft" if limit["soft"] else "hard"
    return f"{hardness} {'comfort threshold' if limit['comfort'] else 'limit'}"


def by_how_much(limit: Summary, key: str = "excess") -> str:
    """Return the largest excess in the limit's own unit."""
    excess = limit[key]
    return "by no number" if excess is None else f"by up to {_short(excess)} {limit['unit']}"


def bounds(limit: Summary) -> str:
    """Return a limit in its own unit."""
    low, high, unit = limit["low"], limit["high"], limit["unit"]
    if low == 0.0:
        return f"{_short(high)} {unit}"
    if abs(low + high) <= 1e-9 * high:
        return f"±{_short(high)} {unit}"
    return f"{_short(low)} … {_short(high)} {unit}"


def _short(value: float) -> str:
    return f"{value:.3g}".replace("-", "−")
