"""Jobs that are formulas."""

from typing import Any

from otolith.studies.jobs import JUDGING, Done, Job


def formula(shared: Any, asked: tuple[str, Job]) -> Done:
    """Two objectives that contradict each other, a constraint, and settings that are refused."""
    kind, job = asked
    of = dict(job.settings)
    x, y = float(of["weight.position"]), float(of["weight.velocity"])
    if of["horizon"] == 50 and y > 0.5:
        return Done(refused="the horizon is too long")
    shift = 0.1 * job.item + (0.05 if kind == JUDGING else 0.0) + 0.01 * (of["braking"] == "none")
    measures = {"tracking": (x - 0.2) ** 2 + shift, "travel": (x - 0.8) ** 2 + y}
    return Done(measures | {"violations": max(0.0, y - 0.4), "noticed": 0.0})
