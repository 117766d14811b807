"""The columns of the stream: what a page can plot, with unit, group and the limits to be drawn."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from otolith.core.arrays import Singles
from otolith.core.frames import AXES

if TYPE_CHECKING:  # the server needs only the number of columns
    from otolith.loop import ClosedLoop, Run
    from otolith.platforms import Platform

_LETTERS: Final = ("x", "y", "z")
_LEGS: Final = range(1, 7)


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One signal."""

    name: str
    label: str
    unit: str
    group: str
    axis: str = ""  # axis of the platform, or component of the force
    limits: tuple[float, float] | None = None  # of the machine
    threshold: float | None = None  # of perception


def _forces(kind: str, label: str) -> list[Column]:
    return [
        Column(name=f"{kind}_{of}", label=f"{label} {of}", unit="m/s²", group="force", axis=of)
        for of in _LETTERS
    ]


def _pose(axis: str, platform: "Platform | None") -> Column:
    turns = axis in AXES[3:]
    table = None if platform is None else getattr(platform, axis)
    limits = None if table is None else table.angle_deg if turns else table.position_m
    return Column(name=axis, label=axis, unit="deg" if turns else "m", group="pose", axis=axis, limits=limits)


def _tilt_rate(axis: str, platform: "Platform | None") -> Column:
    threshold = None if platform is None else getattr(platform.tilt_coordination, f"{axis}_degps")
    label = f"{axis} rate"
    return Column(
        name=f"{axis}_rate", label=label, unit="deg/s", group="tilt rate", axis=axis, threshold=threshold
    )


def columns(platform: "Platform | None" = None) -> tuple[Column, ...]:
    """Return the columns in their order, with the limits of a platform."""
    legs = None if platform is None or platform.hexapod is None else platform.six_legs().stroke
    return (
        Column(name="time", label="time", unit="s", group="time"),
        *(
            column
            for pair in zip(_forces("wanted", "wanted"), _forces("felt", "felt"), strict=True)
            for column in pair
        ),
        *(_pose(axis, platform) for axis in AXES),
        *(_tilt_rate(axis, platform) for axis in ("pitch", "roll")),
        *(
            Column(name=f"leg_{k}", label=f"leg {k}", unit="m", group="legs", axis=str(k), limits=legs)
            for k in _LEGS
        ),
        Column(name="step", label="time of a decision", unit="µs", group="solver"),
        Column(name="changes", label="changes of the working set", unit="", group="solver"),
        Column(name="residual", label="certificate", unit="", group="solver"),
        *_forces("felt2", "felt B"),
    )


COUNT: Final = len(columns())


def described(platform: "Platform") -> list[dict[str, Any]]:
    """Return the columns as plain JSON values."""
    return [asdict(column) for column in columns(platform)]


def rows_of(loop: "ClosedLoop", run: "Run", other: "Run | None") -> Singles:
    """Return the rows (n, COUNT) of a stretch of a run, and of a second algorithm's over the same time.

    What a decision has (its time, changes, certificate) stands in every row until the next one.
    """
    n, every = len(run.time), loop.every
    legs = np.full((n, 6), np.nan)
    if loop.platform.hexapod is not None:
        legs = loop.platform.six_legs().lengths(run.pose)
    decisions = np.column_stack([1e6 * run.step_time, run.changes, run.residual])
    forces = np.stack([run.reference_force, run.felt_force], axis=2).reshape(n, 6)
    pose, twist = run.pose.copy(), np.degrees(run.twist[:, [4, 3]])
    pose[:, 3:] = np.degrees(pose[:, 3:])
    second = np.full((n, 3), np.nan) if other is None else other.felt_force
    rows = np.column_stack([run.time, forces, pose, twist, legs, np.repeat(decisions, every, axis=0), second])
    return rows.astype(np.float32)
