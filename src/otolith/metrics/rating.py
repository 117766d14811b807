"""A driver's rating of the motion, predicted from the mismatch of specific force."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.filter import Filter
from otolith.core.lti import StateSpace
from otolith.loop import Run
from otolith.metrics.axes import force_axes
from otolith.metrics.parts import filtered

WEIGHTS: Final = (0.34, 0.66, 0.0)  # longitudinal, lateral, vertical
TIME_CONSTANT: Final = 3.0  # [s] our own choice, see `mismatch_rating`


def mismatch_rating(run: Run, *, time_constant: float = TIME_CONSTANT) -> Vec:
    """Return the predicted incongruence over time (n,) [m/s²]: 0 is no mismatch, higher is worse.

    The rating is Σ wᵢ · low-pass of |felt − wanted|ᵢ over the cued force axes, with a first-order low-pass.
    Kolff, Venrooij, Schwienbacher, Pool & Mulder ("Reliability and models of subjective motion incongruence
    ratings in urban driving simulations") found that such a sum, with 66 % lateral and 34 % longitudinal
    mismatch, describes continuous ratings. Their time constant and gains were not available. The time
    constant here is our own choice and the scale is that of the mismatch, so ratings compare runs and are not
    absolute grades.

    Raises
    ------
    InputError : the time constant is not positive.
    """
    return np.concatenate(list(rating_in_parts(run, time_constant=time_constant)))


def rating_in_parts(run: Run, *, time_constant: float = TIME_CONSTANT) -> Iterator[Vec]:
    """Yield what `mismatch_rating` returns, by part of the run."""
    if not 0.0 < time_constant < np.inf:
        raise InputError("the rating's time constant", f"{time_constant} s", "greater than 0 s and finite")
    axes = list(force_axes(run).values())
    weights = np.array(WEIGHTS)[axes]
    lag = StateSpace.from_polynomials([1.0], [time_constant, 1.0]).discretise(run.plant_period, hold="first")
    for rating in filtered(
        run,
        Filter(lag),
        lambda part: (np.abs(part.felt_force - part.reference_force)[:, axes] @ weights)[:, None],
    ):
        yield rating[:, 0]
