"""Fits six legs to a data sheet: to the range of each axis alone, and the legs' lengths.

The fit is a least-squares problem on the relative error of every end of every range, from many random starts,
over hexapods with three regular pairs of joints on two circles: seven numbers for up to twelve ends. The
solution is not unique, because very different machines can share a data sheet. Legs with poor conditioning in
the neutral pose are refused.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final, Literal

import numpy as np
import scipy  # scipy imports its modules on first use, so unused ones cost no time

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import AXES
from otolith.platforms.axes import Rotation
from otolith.platforms.geometry import Circles
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.platform import Platform
from otolith.platforms.reach import SINGULAR, axis_speeds, leg_end, reach_ends

WELL: Final = 5.0  # upper bound of a fitted machine's condition number in the neutral pose
TRIES: Final = 1000  # largest number of random draws for one start
ALIKE: Final = 0.01  # fits whose relative errors differ by less are equally good
Forward = Literal["platform", "base"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A fitted geometry."""

    circles: Circles
    neutral_height: float  # [m]
    reference_point: tuple[float, float, float]  # [m]
    errors: dict[str, tuple[float, float]]  # relative errors of both ends of each axis
    worst: float  # largest relative error
    condition: float  # condition number in the neutral pose


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """The best geometry, and others that are equally good."""

    best: Candidate
    alike: tuple[Candidate, ...]  # fits whose worst error is within `ALIKE` of the best, best first
    starts: int
    leg_speed: float | None  # [m/s] sufficient for the speed of every axis; None if one is not given
    # [m/s²] sufficient for the acceleration of every axis; None if one is not given
    leg_acceleration: float | None


def table_of(platform: Platform) -> dict[str, tuple[float, float]]:
    """Return the ranges [m or rad] of the platform's axes, as its file gives them."""
    table = {}
    for axis in platform.axes:
        limits = getattr(platform, axis)
        rotates = isinstance(limits, Rotation)
        ends = np.radians(limits.angle_deg) if rotates else limits.position_m
        table[axis] = (float(ends[0]), float(ends[1]))
    return table


def fit(
    platform: Platform,
    stroke: tuple[float, float],
    *,
    starts: int = 60,
    seed: int = 0,
    progress: Callable[[float], None] = lambda _: None,
) -> Fit:
    """Find legs with lengths within `stroke` [m] that reach the platform's ranges, each axis alone.

    Raises
    ------
    InputError : fewer than four axes are given, or no start led to a machine that stands.
    """
    table = table_of(platform)
    if len(table) < 4:
        raise InputError(
            f"axes of platform {platform.name}", ", ".join(table), "at least four, to fit seven numbers"
        )
    problem, rng, found = _Problem(table, stroke), np.random.default_rng(seed), []
    for k in range(starts):
        forward: Forward = "platform" if k % 2 == 0 else "base"
        candidate = problem.solve(rng, forward)
        if candidate is not None:
            found.append(candidate)
        progress((k + 1) / starts)
    if not found:
        raise InputError(f"fit of {platform.name}", f"without a result in {starts} starts", "tried with more")
    found.sort(key=lambda candidate: candidate.worst)
    best = found[0]
    speeds = axis_speeds(problem.hexapod(best))
    return Fit(
        best=best,
        alike=tuple(c for c in found if c.worst <= best.worst + ALIKE),
        starts=starts,
        leg_speed=_afforded(platform, speeds, ("velocity_mps", "rate_degps")),
        leg_acceleration=_afforded(platform, speeds, ("acceleration_mps2", "acceleration_degps2")),
    )


def _afforded(platform: Platform, speeds: Vec, names: tuple[str, str]) -> float | None:
    needs = []
    for i, axis in enumerate(AXES):
        limits = getattr(platform, axis)
        if limits is None:
            continue
        value = getattr(limits, names[i // 3])
        if value is None:
            return None
        needs.append(float(speeds[i] * (np.radians(value) if i >= 3 else value)))
    return max(needs)


class _Problem:
    """The fit of seven numbers: two radii, two half-angles, height, reference point x and z."""

    def __init__(self, table: dict[str, tuple[float, float]], stroke: tuple[float, float]) -> None:
        self.table, self.stroke = table, stroke
        mean = 0.5 * (stroke[0] + stroke[1])  # [m] the length that scales all others
        self._low = np.array([0.35 * mean, 0.2 * mean, 1.5, 1.5, 0.5 * mean, -0.5 * mean, -0.5 * mean])
        self._high = np.array([1.5 * mean, 1.3 * mean, 30.0, 30.0, 0.98 * mean, 0.5 * mean, 0.5 * mean])

    def solve(self, rng: np.random.Generator, forward: Forward) -> Candidate | None:
        """Solve from one random start; None if the result is a machine that cannot stand."""
        result = scipy.optimize.least_squares(
            partial(self._errors, forward=forward),
            self._start(rng, forward),
            bounds=(self._low, self._high),
            x_scale=self._high - self._low,
            max_nfev=100,
        )
        errors = self._errors(result.x, forward).reshape(-1, 2)
        candidate = Candidate(
            circles=_circles(result.x, forward),
            neutral_height=float(result.x[4]),
            reference_point=(float(result.x[5]), 0.0, float(result.x[6])),
            errors={axis: (float(e[0]), float(e[1])) for axis, e in zip(self.table, errors, strict=True)},
            worst=float(np.abs(errors).max()),
            condition=np.inf,
        )
        machine = self.hexapod(candidate)
        condition = machine.condition(np.zeros(6))
        if not (condition < WELL and self._stands(machine)):
            return None
        return replace(candidate, condition=condition)

    def _stands(self, machine: Hexapod) -> bool:
        """Return whether the legs hold the platform up to all ends of their strokes."""
        ends = reach_ends(machine)
        return not any(end.why == SINGULAR for axis in self.table for end in ends[axis])

    def _start(self, rng: np.random.Generator, forward: Forward) -> Vec:
        """Draw numbers whose legs reach the neutral pose if possible, because elsewhere gradients vanish."""
        for _ in range(TRIES):
            x = rng.uniform(self._low, self._high)
            if self._errors(x, forward)[0] > -1.0:
                break
        return x

    def hexapod(self, candidate: Candidate) -> Hexapod:
        """Return the machine with its geometry only; its drives are unknown."""
        base, platform = candidate.circles.points()
        reference = np.array(candidate.reference_point)
        return _bare(
            platform - reference, base - reference - [0.0, 0.0, candidate.neutral_height], self.stroke
        )

    def _errors(self, x: Vec, forward: Forward) -> Vec:
        base, platform = _circles(x, forward).points()
        reference = np.array([x[5], 0.0, x[6]])
        joints, anchors = platform - reference, base - reference - np.array([0.0, 0.0, x[4]])
        errors = []
        for axis, ends in self.table.items():
            i = AXES.index(axis)
            for end in ends:
                way = leg_end(joints, anchors, self.stroke, i, float(np.sign(end)))
                errors.append(way / abs(end) - 1.0)
        return np.array(errors)


def _circles(x: Vec, forward: Forward) -> Circles:
    values: dict[str, Any] = {
        "base_radius_m": float(x[0]),
        "platform_radius_m": float(x[1]),
        "base_half_angle_deg": float(x[2]),
        "platform_half_angle_deg": float(x[3]),
    }
    return Circles(**values, forward=forward)


def _bare(joints: Vec, anchors: Vec, stroke: tuple[float, float]) -> Hexapod:
    unknown: dict[str, Any] = dict.fromkeys(
        ("speed", "acceleration", "force", "leg_mass", "stiffness", "damping", "mass"), np.nan
    )
    zero = np.zeros(3)
    return Hexapod(
        joints=joints, anchors=anchors, stroke=stroke, head=zero, centre=zero, inertia=zero, **unknown
    )


def as_toml(result: Fit, stroke: tuple[float, float]) -> str:
    """Return the best geometry as lines of a platform file; undetermined fields are left open."""
    best, circles = result.best, result.best.circles
    others = len(result.alike) - 1
    x, _, z = best.reference_point
    lines = [
        f"[hexapod]  # fitted: worst end {100 * best.worst:.2f} % off; {others} other of {result.starts} "
        f"starts came within {100 * ALIKE:g} %",
        f"neutral_height_m = {best.neutral_height:.5f}",
        f"reference_point_m = [{x:.5f}, 0.0, {z:.5f}]",
        "",
        "[hexapod.circles]",
        f"base_radius_m = {circles.base_radius_m:.5f}",
        f"base_half_angle_deg = {circles.base_half_angle_deg:.4f}",
        f"platform_radius_m = {circles.platform_radius_m:.5f}",
        f"platform_half_angle_deg = {circles.platform_half_angle_deg:.4f}",
        f'forward = "{circles.forward}"',
        "",
        "[hexapod.legs]",
        f"length_m = [{stroke[0]!r}, {stroke[1]!r}]",
        _open("speed_mps", result.leg_speed, "affords the speed of every axis alone"),
        _open("acceleration_mps2", result.leg_acceleration, "affords the acceleration of every axis alone"),
        *(
            f"# {name} =   # cannot be found from ranges: please fill in"
            for name in ("force_n", "mass_kg", "stiffness_npm", "damping_nspm")
        ),
        "",
        "[hexapod.payload]",
        *(f"# {name} =   # please fill in" for name in ("mass_kg", "centre_m", "inertia_kgm2")),
    ]
    return "\n".join(lines) + "\n"


def _open(name: str, value: float | None, why: str) -> str:
    return f"# {name} =   # please fill in" if value is None else f"{name} = {value:.4g}  # {why}"
