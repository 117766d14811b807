"""A geometry of six legs from what a data sheet prints: the range of each axis alone, and the legs' lengths.

Least squares on the relative error of every end of every range, from many random starts, over hexapods
with three regular pairs of joints on two circles: seven numbers for up to twelve ends. The answer is one
of many: quite different machines share a data sheet. Legs that stand badly in the neutral pose are refused.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final, Literal

import numpy as np
import scipy  # its modules are imported on first use: none waits for one that it does not need

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.core.frames import AXES
from otolith.platforms.geometry import Circles
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.platform import Platform, Rotation
from otolith.platforms.reach import SINGULAR, axis_speeds, leg_end, reach_ends

WELL: Final = 5.0  # condition number in the neutral pose that a fitted machine must stay below
TRIES: Final = 1000  # of random numbers for one start
ALIKE: Final = 0.01  # of relative error, within which fits count as equally good
Forward = Literal["platform", "base"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    """A fitted geometry."""

    circles: Circles
    neutral_height: float  # [m]
    reference_point: tuple[float, float, float]  # [m]
    errors: dict[str, tuple[float, float]]  # relative error of each axis's two ends
    worst: float  # largest of them
    condition: float  # in the neutral pose


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """The best geometry, and how many others do as well."""

    best: Candidate
    alike: tuple[Candidate, ...]  # those whose worst error is within `ALIKE` of the best's, best first
    starts: int
    leg_speed: float | None  # [m/s] that affords every axis's speed, where all are given
    leg_acceleration: float | None  # [m/s²] likewise


def table_of(platform: Platform) -> dict[str, tuple[float, float]]:
    """The ranges [m or rad] of the platform's axes, as its file gives them."""
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
    """Find legs of lengths within `stroke` [m] that reach what the platform's axes reach, each alone.

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
    """Ranges to meet, by seven numbers: two radii, two half-angles, height, reference point x and z."""

    def __init__(self, table: dict[str, tuple[float, float]], stroke: tuple[float, float]) -> None:
        self.table, self.stroke = table, stroke
        mean = 0.5 * (stroke[0] + stroke[1])  # [m] the one length that scales all others
        self._low = np.array([0.35 * mean, 0.2 * mean, 1.5, 1.5, 0.5 * mean, -0.5 * mean, -0.5 * mean])
        self._high = np.array([1.5 * mean, 1.3 * mean, 30.0, 30.0, 0.98 * mean, 0.5 * mean, 0.5 * mean])

    def solve(self, rng: np.random.Generator, forward: Forward) -> Candidate | None:
        """Least squares from one random start; None where it ends in a machine that cannot stand."""
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
        """Return whether the legs hold the platform all the way to the ends that their strokes allow."""
        ends = reach_ends(machine)
        return not any(end.why == SINGULAR for axis in self.table for end in ends[axis])

    def _start(self, rng: np.random.Generator, forward: Forward) -> Vec:
        """Random numbers whose legs reach the neutral pose, where there are such: elsewhere slopes vanish."""
        for _ in range(TRIES):
            x = rng.uniform(self._low, self._high)
            if self._errors(x, forward)[0] > -1.0:
                break
        return x

    def hexapod(self, candidate: Candidate) -> Hexapod:
        """The machine, with nothing but its geometry; what moves it is not known."""
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
    """The best geometry as lines of a platform file; what its ranges leave undetermined stays open."""
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
            f"# {name} =   # not told by ranges: please fill in"
            for name in ("force_n", "mass_kg", "stiffness_npm", "damping_nspm")
        ),
        "",
        "[hexapod.payload]",
        *(f"# {name} =   # please fill in" for name in ("mass_kg", "centre_m", "inertia_kgm2")),
    ]
    return "\n".join(lines) + "\n"


def _open(name: str, value: float | None, why: str) -> str:
    return f"# {name} =   # please fill in" if value is None else f"{name} = {value:.4g}  # {why}"
