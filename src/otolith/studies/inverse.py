"""Inverse optimal control: the washout weights of which a recorded motion is the optimum.

A controller whose weights are unknown has moved a platform along a known reference. The MPC is closed with
candidate weights along the same reference, and the weights are sought that move the platform alike,

    min over log w of Σ |x(t; w) − x_recorded(t)|²,

over the positions of the cued axes, each relative to its own RMS, by a trust-region method for least squares
in logarithms (scipy). So an expert's tuning, or another program's, can be read off its motion. A weight that
hardly acts leaves no trace in it; the spread of each says how well it is determined.
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
SAMPLES: Final = 20  # every so many plant samples count


@dataclass(frozen=True, kw_only=True)
class Recovered:
    """Weights that were read off a motion."""

    weights: Mapping[str, float]  # by state
    spread: Mapping[str, float]  # relative standard error of each
    difference: float  # RMS of what is left between the motions, of the RMS of the motion
    loops: int


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
    wanted, scale = recorded[::SAMPLES, axes], scale[scale > 0.0]
    loops = 0

    def residuals(logarithms: Vec) -> Vec:
        nonlocal loops
        loops += 1
        run = _moved(problem, dict(zip(start, np.exp(logarithms).tolist(), strict=True)))
        if len(run.pose) != len(recorded):
            raise InputError("the recorded motion", f"{len(recorded)} samples", f"{len(run.pose)}, as wanted")
        return np.asarray(((run.pose[::SAMPLES, axes] - wanted) / scale).ravel())

    found = scipy.optimize.least_squares(
        residuals, np.log(list(start.values())), method="trf", diff_step=[STEP], x_scale=1.0, xtol=1e-6
    )
    left = float(np.mean(found.fun**2))
    slopes: Mat = np.asarray(found.jac)
    covariance = left * np.linalg.pinv(slopes.T @ slopes)
    return Recovered(
        weights=dict(zip(start, np.exp(found.x).tolist(), strict=True)),
        spread={name: math.sqrt(max(0.0, covariance[k, k])) for k, name in enumerate(start)},
        difference=math.sqrt(left),
        loops=loops,
    )


def _moved(problem: Problem, weights: Mapping[str, float]) -> Run:
    return closed(problem, Job(tuple((f"weight.{state}", value) for state, value in weights.items()), 0))
