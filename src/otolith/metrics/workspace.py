"""How much of the platform's reach a run used."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Vec
from otolith.loop import Run
from otolith.metrics.axes import moving_axes
from otolith.platforms import Platform
from otolith.platforms.axes import Translation

NEAR = 0.9  # share of the reach from which the limit is near

_Part = tuple[float, float, int]  # largest share of a part, sum of its squares, samples near the limit


@dataclass(frozen=True, slots=True)
class WorkspaceUse:
    """Use of one axis, or of the limit circle, as shares of the reach in the direction of motion."""

    largest: float  # 1 at the limit
    rms: float
    near_limit: float  # share of the time beyond 90 % of the reach


def workspace_use(run: Run) -> dict[str, WorkspaceUse]:
    """Return the use of every cued axis, and of the circle of surge and sway if it bounds both."""
    axes = moving_axes(run)
    found: dict[str, list[_Part]] = {}
    for part in run.parts():
        pose = part.pose
        shares = {axis: _share(pose[:, i], *reach(run.platform, axis)) for axis, i in axes.items()}
        if run.platform.circle is not None and {"surge", "sway"} <= set(axes):
            shares["circle"] = np.hypot(pose[:, 0], pose[:, 1]) / run.platform.circle
        for name, share in shares.items():
            squares, near = float(np.sum(share**2)), int(np.count_nonzero(share > NEAR))
            found.setdefault(name, []).append((float(np.max(share)), squares, near))
    return {name: _use(parts, run.samples) for name, parts in found.items()}


def reach(platform: Platform, axis: str) -> tuple[float, float]:
    """Return the low and high limit of an axis of the platform [m or rad]."""
    limits = getattr(platform, axis)
    if isinstance(limits, Translation):
        return limits.position_m
    low, high = np.deg2rad(limits.angle_deg)
    return float(low), float(high)


def _share(position: Vec, low: float, high: float) -> Vec:
    return np.where(position < 0.0, position / low, position / high)


def _use(parts: Sequence[_Part], samples: int) -> WorkspaceUse:
    largest, squares, near = zip(*parts, strict=True)
    return WorkspaceUse(
        largest=float(np.max(largest)),
        rms=math.sqrt(sum(squares) / samples),
        near_limit=sum(near) / samples,
    )
