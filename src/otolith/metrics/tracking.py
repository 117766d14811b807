"""How closely the felt motion follows the wanted one (thesis, section 5.1)."""

import numpy as np

from otolith.core.arrays import Vec
from otolith.loop import Run


def tracking_rmse(run: Run) -> Vec:
    """Return the RMSE of the felt specific force along x, y, z (3,) [m/s²] (eq. 5.2), at plant samples."""
    rmse: Vec = np.sqrt(np.mean((run.felt_force - run.reference_force) ** 2, axis=0))
    return rmse


def rate_rmse(run: Run) -> Vec:
    """Return the RMSE of the felt angular rate about x, y, z (3,) [rad/s], over all plant samples."""
    rmse: Vec = np.sqrt(np.mean((run.felt_rate - run.reference_rate) ** 2, axis=0))
    return rmse


def travel_rms(run: Run) -> Vec:
    """Return the RMS of the pose (6,) [m ×3, rad ×3], the "RMSE of platform displacement" of Table 5.3."""
    rms: Vec = np.sqrt(np.mean(run.pose**2, axis=0))
    return rms
