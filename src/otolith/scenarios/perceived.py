"""A scenario as a sense organ perceives it, which the thesis's controllers follow (section 6.3)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.scenarios.sampled import Sampled
from otolith.scenarios.scenario import Scenario

SAMPLING: Final = 1e-3  # [s]; the fastest organ of `otolith.perception` responds in 16 ms
LONGEST: Final = 3600.0  # [s]


def perceived(scenario: Scenario, organ: Callable[[Mat, float], Mat], *, name: str) -> Scenario:
    """Return the scenario with its specific force filtered by `organ`; angular rates are unchanged.

    Parameters
    ----------
    organ : function of forces (n, 3) [m/s²] and their sampling period [s] that returns perceived forces (n,
        3) [m/s²]; it chooses its initial state, see `otolith.perception.sense`.
    name : name of the organ, for the origin.

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
