"""Inverse optimal control: the washout weights of which a recorded motion is the optimum.

A controller whose weights are unknown has moved a platform along a known reference. The MPC is closed with
candidate weights along the same reference, and the weights are sought that move the platform alike,

    min over log w of Σ |x(t; w) − x_recorded(t)|²,

over the positions of the cued axes, each relative to its own RMS, by a trust-region method for least squares
in logarithms (scipy). So an expert's tuning, or another program's, can be read off its motion.

A weight that hardly acts leaves no trace in it. With residuals r, their slopes J = ∂r/∂log w, and noise of
variance σ², taken from what is left at the end, the Fisher information of the motion about log w is JᵀJ/σ².
No unbiased estimate from this motion can be better than its inverse, the covariance (Cramér & Rao), and least
squares are as good as that for noise that is small and independent from sample to sample. From it follow the
standard error and the confidence interval of each weight. Both are too small where the model itself is wrong,
because then the residuals are no noise.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy  # scipy imports its modules on first use, so unused ones cost no time

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.cueing.design import Design
from otolith.cueing.mpc.washout_weights import constant
from otolith.loop import Run
from otolith.scenarios import Scenario
from otolith.studies.jobs import Item, Job, Problem, closed

STEP: Final = 1e-3  # of a logarithm, for derivatives
START: Final = 0.3  # weight to begin with, as `otolith.tuning` does
SAMPLES: Final = 20  # so many plant samples in a row are averaged, during which the motion hardly changes
WITHIN: Final = 1.96  # standard errors on either side that hold 95 % of a normal distribution
TOLD: Final = 0.05  # largest relative standard error of a weight that the motion tells
_EXACT: Final = 1e-300  # replaces a variance of zero, which times infinity is no number
_LARGEST: Final = 50.0  # logarithm of the largest factor; an interval so wide says nothing


@dataclass(frozen=True, kw_only=True)
class Recovered:
    """Weights that were read off a motion."""

    weights: Mapping[str, float]  # by state
    spread: Mapping[str, float]  # relative standard error of each, that of its logarithm
    difference: float  # RMS of what is left between the motions, averaged, of the RMS of the motion
    loops: int

    @property
    def intervals(self) -> dict[str, tuple[float, float]]:
        """Return the 95 % confidence interval of each weight."""
        factors = {state: math.exp(min(WITHIN * one, _LARGEST)) for state, one in self.spread.items()}
        return {state: (self.weights[state] / by, self.weights[state] * by) for state, by in factors.items()}

    @property
    def untold(self) -> dict[str, float]:
        """Return the weights that the motion does not tell within 5 %, and what would.

        The number of each says how many times as long a record of this kind would have to be. Noise would
        have to be less by the root of this number.
        """
        return {state: (one / TOLD) ** 2 for state, one in self.spread.items() if one > TOLD}


def recover(
    recorded: Mat, design: Design, scenario: Scenario, start: Mapping[str, float], *, plant: str = "ideal"
) -> Recovered:
    """Recover constant washout weights of the implicit MPC from a motion.

    Parameters
    ----------
    recorded : (n, 6) [m, rad] the pose at the plant's samples, as `Run.pose`.
    design : the MPC but for its weights.
    scenario : what was wanted.
    start : weights to begin with, one for each state that is weighed.

    Raises
    ------
    InputError : there are no weights, one is not positive, or the motion has another length or stands still.
    """
    constant(start)
    if not start or not all(value > 0.0 for value in start.values()):
        raise InputError("weights to begin with", dict(start) or "none", "greater than 0")
    item = Item(name=scenario.name, scenario=scenario)
    problem = Problem(cueing="implicit", design=design, plant=plant, items=(item,), measures=())
    axes = [axis for dof in design.dofs for axis in dof.axes]
    scale = np.sqrt(np.mean(recorded[:, axes] ** 2, axis=0))
    if not (scale > 0.0).any():
        raise InputError("the recorded motion", "none", "one that moves a cued axis")
    axes = [axis for axis, size in zip(axes, scale, strict=True) if size > 0.0]
    wanted, scale = _averaged(recorded[:, axes]), scale[scale > 0.0]
    loops = 0

    def residuals(logarithms: Vec) -> Vec:
        nonlocal loops
        loops += 1
        run = _moved(problem, dict(zip(start, np.exp(logarithms).tolist(), strict=True)))
        if len(run.pose) != len(recorded):
            raise InputError("the recorded motion", f"{len(recorded)} samples", f"{len(run.pose)}, as wanted")
        return np.asarray(((_averaged(run.pose[:, axes]) - wanted) / scale).ravel())

    found = scipy.optimize.least_squares(
        residuals, np.log(list(start.values())), method="trf", diff_step=[STEP], x_scale=1.0, xtol=1e-6
    )
    left = float(np.mean(found.fun**2))
    slopes: Mat = np.asarray(found.jac)
    return Recovered(
        weights=dict(zip(start, np.exp(found.x).tolist(), strict=True)),
        spread=dict(zip(start, standard_errors(slopes, left).tolist(), strict=True)),
        difference=math.sqrt(left),
        loops=loops,
    )


def _averaged(motion: Mat) -> Mat:
    """Return the averages of samples in a row, which keep what the motion tells and little of the noise."""
    averages: Mat = np.add.reduceat(motion, range(0, len(motion), SAMPLES)) / SAMPLES
    return averages


def standard_errors(slopes: Mat, variance: float) -> Vec:
    """Return the standard error of each logarithm (n,), infinite where the residuals do not depend on it.

    Parameters
    ----------
    slopes : (m, n) J.
    variance : σ².
    """
    _, sizes, directions = np.linalg.svd(slopes, full_matrices=False)
    with np.errstate(divide="ignore", invalid="ignore"):
        of_direction = directions / sizes[:, None]  # 0/0 where a direction without effect lacks a weight
    return np.asarray(math.sqrt(max(variance, _EXACT)) * np.sqrt(np.nansum(of_direction**2, axis=0)))


def _moved(problem: Problem, weights: Mapping[str, float]) -> Run:
    return closed(problem, Job(tuple((f"weight.{state}", value) for state, value in weights.items()), 0))
