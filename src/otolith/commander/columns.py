"""The columns of the stream: what a page can plot, with unit, group and the limits to be drawn."""

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from otolith.core.arrays import Singles
from otolith.core.frames import AXES

if TYPE_CHECKING:  # the server needs only the number of columns
    from otolith.loop import ClosedLoop, Run
    from otolith.platforms import Platform

_FORCES: Final = {"x": "Force forward", "y": "Force sideways", "z": "Vertical force"}
_PLACES: Final = dict(zip(AXES, ("x", "y", "z", "roll", "pitch", "yaw"), strict=True))  # by axis
_LEGS: Final = range(1, 7)


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """One signal; those of equal group and unit share a plot."""

    name: str
    label: str
    unit: str
    group: str
    axis: str = ""  # component of the force, axis of the platform, or leg
    limits: tuple[float, float] | None = None  # of the machine
    threshold: float | None = None  # of perception


def _force(kind: str, label: str, of: str) -> Column:
    return Column(name=f"{kind}_{of}", label=f"{label} {of}", unit="m/s²", group=_FORCES[of], axis=of)


def _pose(axis: str, platform: "Platform | None") -> Column:
    turns, place = axis in AXES[3:], _PLACES[axis]
    table = None if platform is None else getattr(platform, axis)
    return Column(
        name=f"pose_{place}",
        label=axis,
        unit="deg" if turns else "m",
        group="Angle" if turns else "Position",
        axis=place,
        limits=None if table is None else table.angle_deg if turns else table.position_m,
    )


def _tilt_rate(axis: str, platform: "Platform | None") -> Column:
    return Column(
        name=f"tilt_rate_{axis}",
        label=f"{axis} rate",
        unit="deg/s",
        group="Tilt rate",
        axis=axis,
        threshold=None if platform is None else getattr(platform.tilt_coordination, f"{axis}_degps"),
    )


def _leg(k: int, platform: "Platform | None") -> Column:
    if platform is None or platform.hexapod is None:
        return Column(name=f"leg_{k}", label=f"leg {k}", unit="m", group="Legs", axis=f"leg {k}")
    drives = platform.six_legs().drives
    return Column(
        name=f"leg_{k}",
        label=f"{drives.kind} {k}",
        unit=drives.unit,
        group="Legs",
        axis=f"{drives.kind} {k}",
        limits=drives.span,
    )


def columns(platform: "Platform | None" = None) -> tuple[Column, ...]:
    """Return the columns in their order, with the limits of a platform."""
    kinds = {"wanted": "wanted", "felt": "felt"}
    return (
        Column(name="time", label="time", unit="s", group="Time"),
        *(_force(kind, label, of) for of in _FORCES for kind, label in kinds.items()),
        *(_pose(axis, platform) for axis in AXES),
        *(_tilt_rate(axis, platform) for axis in ("pitch", "roll")),
        *(_leg(k, platform) for k in _LEGS),
        Column(name="step_us", label="time of a decision", unit="µs", group="Step time"),
        Column(name="changes", label="changes of the working set", unit="", group="Changes"),
        Column(name="residual", label="certificate", unit="", group="Residual"),
        *(_force("felt2", "felt, B", of) for of in _FORCES),
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
        hexapod = loop.platform.six_legs()
        legs = hexapod.drives.size * hexapod.lengths(run.pose)
    decisions = np.column_stack([1e6 * run.step_time, run.changes, run.residual])
    forces = np.stack([run.reference_force, run.felt_force], axis=2).reshape(n, 6)
    pose, twist = run.pose.copy(), np.degrees(run.twist[:, [4, 3]])
    pose[:, 3:] = np.degrees(pose[:, 3:])
    second = np.full((n, 3), np.nan) if other is None else other.felt_force
    rows = np.column_stack([run.time, forces, pose, twist, legs, np.repeat(decisions, every, axis=0), second])
    return rows.astype(np.float32)


def hexapod_of(platform: "Platform") -> dict[str, Any] | None:
    """Return what a page needs to draw the legs, in m and for cranks deg; None if the platform has none."""
    if platform.hexapod is None:
        return None
    legs = platform.six_legs()
    return {
        "base": legs.anchors.tolist(),
        "platform": legs.joints.tolist(),
        "neutral": (legs.drives.size * legs.lengths(np.zeros(6))).tolist(),
        "stroke": list(legs.drives.span),
        "cranks": None if legs.cranks is None else legs.cranks.plain(),
    }
