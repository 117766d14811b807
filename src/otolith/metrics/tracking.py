"""How well the wanted specific force is felt (thesis, section 5.1)."""

import numpy as np

from otolith.core.arrays import Vec
from otolith.loop import Run


def tracking_rmse(run: Run) -> Vec:
    """RMSE of the felt specific force per axis x, y, z [m/s²], (3,) (eq. 5.2), over all plant samples."""
    rmse: Vec = np.sqrt(np.mean((run.felt_force - run.reference_force) ** 2, axis=0))
    return rmse


def rate_rmse(run: Run) -> Vec:
    """RMSE of the felt angular rate about x, y, z [rad/s], (3,), over all plant samples."""
    rmse: Vec = np.sqrt(np.mean((run.felt_rate - run.reference_rate) ** 2, axis=0))
    return rmse


def travel_rms(run: Run) -> Vec:
    """Root mean square of the pose (6,) [m ×3, rad ×3]: "RMSE of platform displacement" in Table 5.3."""
    rms: Vec = np.sqrt(np.mean(run.pose**2, axis=0))
    return rms
