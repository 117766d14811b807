"""How much of the platform's reach a run used."""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Vec
from otolith.loop import Run
from otolith.metrics.axes import moving_axes
from otolith.platforms import Platform
from otolith.platforms.platform import Translation

NEAR = 0.9  # share of the reach from which the limit is near


@dataclass(frozen=True, slots=True)
class WorkspaceUse:
    """Use of one axis, or of the limit circle, as shares of the reach in the direction of motion."""

    largest: float  # 1 at the limit
    rms: float
    near_limit: float  # share of the time beyond 90 % of the reach


def workspace_use(run: Run) -> dict[str, WorkspaceUse]:
    """Return the use of every cued axis, and of the circle of surge and sway if it bounds both."""
    axes = moving_axes(run)
    used = {axis: _use(_share(run.pose[:, i], *reach(run.platform, axis))) for axis, i in axes.items()}
    if run.platform.circle is not None and {"surge", "sway"} <= set(axes):
        used["circle"] = _use(np.hypot(run.pose[:, 0], run.pose[:, 1]) / run.platform.circle)
    return used


def reach(platform: Platform, axis: str) -> tuple[float, float]:
    """Return the low and high limit of an axis of the platform [m or rad]."""
    limits = getattr(platform, axis)
    if isinstance(limits, Translation):
        return limits.position_m
    low, high = np.deg2rad(limits.angle_deg)
    return float(low), float(high)


def _share(position: Vec, low: float, high: float) -> Vec:
    return np.where(position < 0.0, position / low, position / high)


def _use(share: Vec) -> WorkspaceUse:
    return WorkspaceUse(
        largest=float(np.max(share)),
        rms=float(np.sqrt(np.mean(share**2))),
        near_limit=float(np.mean(share > NEAR)),
    )
