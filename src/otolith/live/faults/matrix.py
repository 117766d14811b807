"""All cases of the fault matrix, and the worlds that they begin in."""

import re
from collections.abc import Iterator
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.interfaces import Cueing, PlatformState, Reference
from otolith.live.faults.around import AROUND_CASES
from otolith.live.faults.case import ENGAGED_S, Case, Result, run_case
from otolith.live.faults.decisions import DECISION_CASES
from otolith.live.faults.machine import MACHINE_CASES
from otolith.live.faults.outside import OUTSIDE_CASES
from otolith.live.faults.processes import PROCESS_CASES
from otolith.live.faults.telemetry import TELEMETRY_CASES
from otolith.live.world import World, arm_and_engage, sines
from otolith.platforms import Platform
from otolith.platforms.reach import reach_ends

CASES: Final = (
    *TELEMETRY_CASES,
    *DECISION_CASES,
    *PROCESS_CASES,
    *MACHINE_CASES,
    *OUTSIDE_CASES,
    *AROUND_CASES,
)
ROWS: Final = 38  # of the matrix
PARK_HEAVE: Final = -0.15  # [m] where the virtual platform rests, if its legs reach that far …
DEEPEST: Final = 0.8  # … or at this share of what they reach
DRIVE: Final = sines({0: (0.5, 0.5), 1: (0.4, 0.7)})  # within what a washout that knows no limits may move


def row_of(case: Case) -> int:
    """Return the number of the row that a case belongs to: 13 of "13b" and of "13.8000"."""
    found = re.match(r"\d+", case.row)
    if found is None:
        raise ValueError(f"row {case.row!r} has no number")
    return int(found[0])


def park_of(platform: Platform) -> Vec:
    """Return the pose (6,) [m, rad] at which the virtual platform rests without power."""
    park = np.array([0.0, 0.0, PARK_HEAVE, 0.0, 0.0, 0.0])
    if platform.hexapod is not None:
        park[2] = max(PARK_HEAVE, DEEPEST * reach_ends(platform.six_legs())["heave"][0].at)
    return park


def prepare(cueing: Cueing, platform: Platform, *, seed: int = 0, tick: float = 2e-3) -> tuple[World, World]:
    """Return an idle world and one that is cued, with the reference faded in.

    Parameters
    ----------
    tick : [s] of the output; 1 ms as in real operation takes twice the time of 2 ms.
    """
    cueing.reset(PlatformState())
    cueing.step(PlatformState(), Reference(specific_force=np.zeros(3)))  # compiled now
    cueing.reset(PlatformState())
    idle = World(cueing, platform, drive=DRIVE, park=park_of(platform), seed=seed, tick=tick).run(0.5)
    engaged = arm_and_engage(idle.again(), idle.seconds).run(ENGAGED_S)
    return idle, engaged


def run_matrix(
    cueing: Cueing,
    platform: Platform,
    cases: tuple[Case, ...] = CASES,
    *,
    seed: int = 0,
    tick: float = 2e-3,
) -> Iterator[Result]:
    """Run cases one after the other, each from a copy of a prepared world; see `prepare`."""
    idle, engaged = prepare(cueing, platform, seed=seed, tick=tick)
    for case in cases:
        yield run_case(case, engaged if case.engaged else idle, platform)
