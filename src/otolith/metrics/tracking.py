"""How closely the felt motion follows the wanted one (thesis, section 5.1)."""

from otolith.core.arrays import Vec
from otolith.loop import Run
from otolith.metrics.parts import root_mean_square


def tracking_rmse(run: Run) -> Vec:
    """Return the RMSE of the felt specific force along x, y, z (3,) [m/s²] (eq. 5.2), at plant samples."""
    return root_mean_square(run, lambda part: part.felt_force - part.reference_force)


def rate_rmse(run: Run) -> Vec:
    """Return the RMSE of the felt angular rate about x, y, z (3,) [rad/s], over all plant samples."""
    return root_mean_square(run, lambda part: part.felt_rate - part.reference_rate)


def travel_rms(run: Run) -> Vec:
    """Return the RMS of the pose (6,) [m ×3, rad ×3], the "RMSE of platform displacement" of Table 5.3."""
    return root_mean_square(run, lambda part: part.pose)
