"""A scenario as a sense organ passes it on: what the thesis gives its controllers to follow (section 6.3)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.scenarios.sampled import Sampled
from otolith.scenarios.scenario import Scenario

SAMPLING: Final = 1e-3  # [s]; the quickest organ of `otolith.perception` answers in 16 ms
LONGEST: Final = 3600.0  # [s]


def perceived(scenario: Scenario, organ: Callable[[Mat, float], Mat], *, name: str) -> Scenario:
    """The scenario with its specific force as `organ` passes it on; angular rates stay as they are.

    Parameters
    ----------
    organ : forces (n, 3) [m/s²] sampled at a period [s] -> sensed forces (n, 3) [m/s²]; its initial state
        is its own affair, see `otolith.perception.sense`.
    name : of the organ, for the origin.

    Raises
    ------
    InputError : the scenario lasts more than an hour.
    """
    if scenario.duration > LONGEST:
        bound = f"at most {LONGEST:g} s to be passed through an organ"
        raise InputError(f"duration of {scenario.name}", f"{scenario.duration:g} s", bound)
    t = np.arange(round(scenario.duration / SAMPLING) + 1, dtype=np.float64) * SAMPLING
    sensed = organ(scenario.specific_force(t), SAMPLING)
    return replace(
        scenario,
        specific_force=Sampled(SAMPLING, sensed),
        origin=f"{scenario.origin}, through {name}" if scenario.origin else f"through {name}",
    )
