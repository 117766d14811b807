"""The tracking error as the driver's otoliths perceive it."""

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.lti import StateSpace
from otolith.loop import Run
from otolith.perception import canals, otoliths, sense


def perceived_error(run: Run, otolith: StateSpace | None = None) -> Mat:
    """Return felt minus wanted specific force after an otolith model, (n, 3) [m/s²].

    Both motions start from rest. The model is linear, so the difference of the perceived forces is the
    perceived difference, which starts at zero.

    Parameters
    ----------
    otolith : model of the organ; by default Telban's.
    """
    organ = otoliths.telban() if otolith is None else otolith
    return sense(organ, run.felt_force - run.reference_force, run.plant_period, before=np.zeros(3))


def perceived_rmse(run: Run, otolith: StateSpace | None = None) -> Vec:
    """Return the RMSE of the perceived specific force per axis (3,) [m/s²], over all plant samples."""
    rmse: Vec = np.sqrt(np.mean(perceived_error(run, otolith) ** 2, axis=0))
    return rmse


def perceived_rate_rmse(run: Run, canal: StateSpace | None = None) -> Vec:
    """Return the RMSE of the perceived rate about x, y, z (3,) [rad/s]; the model is Telban's by default."""
    organ = canals.telban() if canal is None else canal
    error = sense(organ, run.felt_rate - run.reference_rate, run.plant_period, before=np.zeros(3))
    rmse: Vec = np.sqrt(np.mean(error**2, axis=0))
    return rmse
