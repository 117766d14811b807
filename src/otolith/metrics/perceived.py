"""The tracking error as the driver's otoliths perceive it."""

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.lti import StateSpace
from otolith.loop import Run
from otolith.metrics.parts import OfPart, filtered, mean
from otolith.perception import canals, otoliths, sensing


def perceived_error(run: Run, otolith: StateSpace | None = None) -> Mat:
    """Return felt minus wanted specific force after an otolith model, (n, 3) [m/s²].

    Both motions start from rest. The model is linear, so the difference of the perceived forces is the
    perceived difference, which starts at zero.

    Parameters
    ----------
    otolith : model of the organ; by default Telban's.
    """
    organ = sensing(otoliths.telban() if otolith is None else otolith, run.plant_period, before=np.zeros(3))
    return np.concatenate(list(filtered(run, organ, _force_error)))


def perceived_rmse(run: Run, otolith: StateSpace | None = None) -> Vec:
    """Return the RMSE of the perceived specific force per axis (3,) [m/s²], over all plant samples."""
    return _rms(run, otoliths.telban() if otolith is None else otolith, _force_error)


def perceived_rate_rmse(run: Run, canal: StateSpace | None = None) -> Vec:
    """Return the RMSE of the perceived rate about x, y, z (3,) [rad/s]; the model is Telban's by default."""
    organ = canals.telban() if canal is None else canal
    return _rms(run, organ, lambda part: part.felt_rate - part.reference_rate)


def _force_error(part: Run) -> Mat:
    return part.felt_force - part.reference_force


def _rms(run: Run, organ: StateSpace, error: OfPart) -> Vec:
    """Return the RMS of an error (n, 3) after an organ."""
    perceived = filtered(run, sensing(organ, run.plant_period, before=np.zeros(3)), error)
    rms: Vec = np.sqrt(mean(one**2 for one in perceived))
    return rms
