"""Axes, signs, units and gravity of a source, found by experiment from a recorded minute of driving.

Drive this: stand level for 3 s; accelerate straight ahead and brake, a few times; drive one circle to the
left or more; turn by 90 degrees and drive on. Four tests follow, each with the relation of physics that it
needs (`recordings.checks.relations`):

- *level rest*: the mean force is 0, 1 g or 9.8 m/s² along one channel: that one is up, and gravity is in it;
- *straight*: the channel that follows the change of speed is forward; its slope gives the unit;
- *circle*: one force and one rate go together as a = v r; both are positive to the left, for the circle was;
- world or car axes: the relations hold with vectors as they are sent, or as the attitude turns them.

A test whose correlation is below 0.9 refuses the minute by its name. Not proven by any of them, and said in
the notes: the sign of the vertical force without gravity in it, and the signs of roll and pitch rate; they
are taken as those of right-handed axes, and as turned like the yaw rate.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec
from otolith.live.wire.attitude import matrix
from otolith.live.wire.axes import AxisMap
from otolith.live.wire.minute import RATE_HZ, REST, Minute, NotLearned
from otolith.recordings.channels import Channel
from otolith.recordings.checks.kinematics import CHANGE, TURNING
from otolith.recordings.checks.relations import (
    LEAST,
    QUIET,
    SLOPES,
    WINDOW,
    Relation,
    relation,
    window_changes,
    window_means,
    windows,
)
from otolith.recordings.columns import Column
from otolith.recordings.units import STANDARD_GRAVITY

SURE: Final = 0.9  # least correlation
STANDING: Final = 0.3  # [m/s] speed below which the car stands
STILL: Final = 0.3  # [m/s²] largest standard deviation of a force at rest
LEVEL: Final = 0.1  # share of 1 g that other channels may show at rest: 6 deg of slope
MOVING: Final = 3.0  # [m/s] from which a turn is judged
TURNING_RATE: Final = 0.05  # [rad/s] below which a window counts as straight …
CURVED: Final = 0.3  # … or this share of the largest rate, where its unit is unknown
SEEN: Final = QUIET["ax"]  # [m/s²] change of speed over a window that is told as accelerating or braking
TINY: Final = 1e-9
QUARTER: Final = np.pi / 2.5  # [rad] least turn in all: 90 deg with some grace


@dataclass(frozen=True, kw_only=True)
class Learned:
    """An axis map, and what stays unproven."""

    axes: AxisMap
    notes: tuple[str, ...]

    def sentences(self) -> list[str]:
        """Return what was found, in words."""
        axes, said = self.axes, []
        for what, rows, unit in (
            ("force", axes.force, axes.force_unit),
            ("rate", axes.rate, axes.rate_unit),
        ):
            names = ("forward", "left", "up") if what == "force" else ("roll", "pitch", "yaw")
            named = ", ".join(f"{name} = channel {row}" for name, row in zip(names, rows, strict=True))
            said.append(f"{what}: {named} [{unit}]")
        gravity = "in the force, subtracted" if axes.gravity else "not in the force"
        tests = ", ".join(f"test '{name}': r = {r:.3f}" for name, r in axes.evidence.items())
        return [*said, f"gravity: {gravity}", f"vectors are in {axes.frame} axes", tests]


def learn(minute: Minute) -> Learned:
    """Return the axis map that a minute shows.

    Raises
    ------
    NotLearned : a test failed; the message says which, what it found, and what it needs.
    """
    results: list[Learned] = []
    refusals: list[NotLearned] = []
    for frame, force in _in_frames(minute):
        try:
            results.append(_Experiment(minute, force, frame).learned())
        except NotLearned as error:
            refusals.append(error)
    if not results:
        raise refusals[0]
    return max(results, key=lambda one: min(one.axes.evidence.values()))


def _in_frames(minute: Minute) -> Iterator[tuple[str, Mat]]:
    """Yield the forces as they are, and as the attitude turns them from the world to the car."""
    yield "car", minute.force
    if minute.attitude is not None:
        turned = [
            matrix(q / np.linalg.norm(q)).T @ f for q, f in zip(minute.attitude, minute.force, strict=True)
        ]
        yield "world", np.array(turned)


class Shown(NamedTuple):
    """What one part of the experiment has shown so far."""

    part: str  # stand, accelerate, brake, circle or turn
    value: float  # time at rest [s], a correlation, or a turn [deg]; 0 where nothing is known yet
    needs: float  # least value
    passed: bool


PARTS: Final[dict[str, float]] = {
    "stand": REST,
    "accelerate": SURE,
    "brake": SURE,
    "circle": SURE,
    "turn": float(np.degrees(QUARTER)),
}
NOTHING: Final = tuple(Shown(part, 0.0, needs, passed=False) for part, needs in PARTS.items())


def shown(minute: Minute) -> tuple[Shown, ...]:
    """Return what each part of the experiment shows, while it is still being driven.

    What a part lacks is no error here: `learn` decides, by the same numbers.
    """
    tried = [_Experiment(minute, force, frame).shown() for frame, force in _in_frames(minute)]
    return max(tried, key=lambda parts: sum(one.value for one in parts if one.needs == SURE))


class _Experiment:
    """The four tests, in their order, for one assumption of the frame."""

    def __init__(self, minute: Minute, force: Mat, frame: str) -> None:
        self.minute, self.force, self.frame = minute, force, frame
        self.start = windows(float(minute.t[0]), float(minute.t[-1]))
        self.means = [window_means(self._channel("ax", column), self.start) for column in force.T]
        self.speed = self._channel("vx", minute.speed)

    def learned(self) -> Learned:
        gravity, up = self._rest()
        forward, straight = self._straight(self._driven_straight())
        unit = self._unit(straight, gravity)
        left, yaw, circle, rate_unit = self._circle(abs(forward) - 1, unit)
        upward = 6 - abs(forward) - abs(left)
        if gravity and abs(up) != upward:
            raise self._failed(
                "level rest", f"gravity in channel {abs(up)}", f"in channel {upward}, which is left"
            )
        side = np.linalg.det(_signed(forward, left, upward))
        up = up if gravity else round(side) * upward
        if abs(yaw) != abs(up):
            raise self._failed(
                "circle", f"turning in rate {abs(yaw)}", f"in rate {abs(up)}, the axis that is up"
            )
        turned = 1 if (yaw > 0) == (up > 0) else -1
        rows = tuple(map(str, (forward, left, up)))
        rate = tuple(str(turned * one) for one in (forward, left, up))
        axes = AxisMap(
            source=self.minute.source,
            force=(rows[0], rows[1], rows[2]),
            force_unit=unit,
            gravity=gravity > 0.0,
            frame=self.frame,
            rate=(rate[0], rate[1], rate[2]),
            rate_unit=rate_unit,
            evidence={
                "straight": round(abs(straight.correlation), 4),
                "circle": round(circle.correlation, 4),
            },
        )
        return Learned(axes=axes, notes=tuple(self._notes(axes, side * up)))

    def shown(self) -> tuple[Shown, ...]:
        """Return what each part shows so far."""
        where = self._driven_straight()
        forward, straight = self._follows_speed(where)
        gentle, strong = (abs(straight.slope) * size for size in (STANDARD_GRAVITY, 1.0))
        unit = "g" if abs(np.log(max(gentle, TINY))) < abs(np.log(max(strong, TINY))) else "m/s²"
        _, yaw, circle = self._turns(forward, unit)
        in_degrees = abs(circle.slope) < 0.1  # 1 for rad/s, 0.0175 for deg/s
        turned = float(np.degrees(self._angle(yaw, "deg/s" if in_degrees else "rad/s")))
        r, sure = abs(straight.correlation), straight.informative
        values = {
            "stand": (self._still()[1], True),
            "accelerate": (r, sure and bool((straight.expected > SEEN).any())),
            "brake": (r, sure and bool((straight.expected < -SEEN).any())),
            "circle": (abs(circle.correlation), circle.informative),
            "turn": (turned if circle.informative else 0.0, True),
        }
        return tuple(
            Shown(part, value, needs, passed=seen and value >= needs)
            for part, needs, (value, seen) in zip(PARTS, PARTS.values(), values.values(), strict=True)
        )

    def _still(self) -> tuple[slice, float]:
        """Return the longest stretch at rest, and how long it lasts [s]."""
        still = self._longest(self.minute.speed < STANDING)
        if still.stop == still.start:
            return still, 0.0
        return still, float(self.minute.t[still.stop - 1] - self.minute.t[still.start])

    def _rest(self) -> tuple[float, int]:
        """Return gravity in the units of the force (0 if it is not in it), and the channel that points up."""
        still, length = self._still()
        if length < REST:
            raise self._failed("level rest", f"{length:.1f} s below {STANDING:g} m/s", f"at least {REST:g} s")
        inner = slice(
            still.start + (still.stop - still.start) // 4, still.stop - (still.stop - still.start) // 8
        )
        mean, spread = self.force[inner].mean(axis=0), float(self.force[inner].std(axis=0).max())
        if spread > STILL:
            raise self._failed("level rest", f"a force that varies by {spread:.2g}", f"within {STILL:g}")
        largest = int(np.argmax(np.abs(mean)))
        size, others = abs(float(mean[largest])), float(np.abs(np.delete(mean, largest)).max())
        for gravity in (STANDARD_GRAVITY, 1.0):
            if abs(size - gravity) < LEVEL * gravity and others < LEVEL * gravity:
                return gravity, (largest + 1) * (1 if mean[largest] > 0.0 else -1)
        if size < LEVEL:
            return 0.0, 0
        raise self._failed(
            "level rest",
            f"a mean force of {np.round(mean, 3).tolist()}",
            "0, 1 (g) or 9.8 (m/s²) along one channel",
        )

    def _driven_straight(self) -> Bools:
        """Return in which windows the car does not turn."""
        size = window_means(self._channel("yaw_rate", np.linalg.norm(self.minute.rate, axis=1)), self.start)
        limit = max(TURNING_RATE, CURVED * float(np.nanmax(size)))
        return np.asarray(size < limit, dtype=np.bool_)

    def _straight(self, where: Bools) -> tuple[int, Relation]:
        best, found = self._follows_speed(where)
        self._require("straight", found)
        return (best + 1) * (1 if found.correlation > 0.0 else -1), found

    def _follows_speed(self, where: Bools) -> tuple[int, Relation]:
        """Return the channel that follows the change of speed best, and how well."""
        change = window_changes(self.speed, self.start)
        found = [
            relation("ax", CHANGE, self.start[where], one[where], change[where], {}) for one in self.means
        ]
        best = max(range(3), key=lambda i: abs(found[i].correlation))
        return best, found[best]

    def _unit(self, straight: Relation, gravity: float) -> str:
        slope = abs(straight.slope)
        fits = {
            unit: SLOPES[0] < slope * size < SLOPES[1]
            for unit, size in (("m/s²", 1.0), ("g", STANDARD_GRAVITY))
        }
        at_rest = {STANDARD_GRAVITY: "m/s²", 1.0: "g"}.get(gravity)
        for unit, fit in fits.items():
            if fit and at_rest in (None, unit):
                return unit
        said = f", and {gravity:g} at rest" if gravity else ""
        raise self._failed("straight", f"a slope of {slope:.3g}{said}", "1 for m/s² or 0.102 for g")

    def _circle(self, forward: int, unit: str) -> tuple[int, int, Relation, str]:
        """Return the signed channels of left and of yaw, their relation, and the unit of the rate."""
        left, yaw, best = self._turns(forward, unit)
        self._require("circle", best)
        rate_unit = self._rate_unit(abs(best.slope))
        self._turns_enough(yaw, rate_unit)
        side = self._side(yaw)
        same = 1 if best.correlation > 0.0 else -1
        positive = relation("ay", TURNING, best.start, same * best.measured, best.expected, {})
        return (left + 1) * side * same, (yaw + 1) * side, positive, rate_unit

    def _turns(self, forward: int, unit: str) -> tuple[int, int, Relation]:
        """Return the channels of force and rate that go together best in turns, and how well."""
        size = STANDARD_GRAVITY if unit == "g" else 1.0
        fast = window_means(self.speed, self.start) > MOVING
        pairs = [pair for pair in product(range(3), range(3)) if pair[0] != forward]
        found = {pair: self._turning(*pair, size, fast) for pair in pairs}
        left, yaw = max(found, key=lambda pair: abs(found[pair].correlation))
        return left, yaw, found[left, yaw]

    def _turning(self, left: int, yaw: int, size: float, fast: Bools) -> Relation:
        product_ = window_means(self._channel("ay", self.minute.speed * self.minute.rate[:, yaw]), self.start)
        return relation("ay", TURNING, self.start[fast], size * self.means[left][fast], product_[fast], {})

    def _rate_unit(self, slope: float) -> str:
        for unit, factor in (("rad/s", 1.0), ("deg/s", 180.0 / np.pi)):
            if SLOPES[0] < slope * factor < SLOPES[1]:
                return unit
        raise self._failed("circle", f"a slope of {slope:.3g}", "1 for rad/s or 0.0175 for deg/s")

    def _turns_enough(self, yaw: int, rate_unit: str) -> None:
        angle = self._angle(yaw, rate_unit)
        if angle < QUARTER:
            raise self._failed("circle", f"a turn of {np.degrees(angle):.0f} deg in all", "at least 90 deg")

    def _angle(self, yaw: int, rate_unit: str) -> float:
        """Return how far it turned in all [rad]."""
        factor = np.pi / 180.0 if rate_unit == "deg/s" else 1.0
        return float(np.abs(np.cumsum(self.minute.rate[:, yaw])).max()) / RATE_HZ * factor

    def _side(self, yaw: int) -> int:
        """Return the sign of the rate in the longest turn, which is the circle to the left."""
        rate = self.minute.rate[:, yaw]
        turning = np.abs(rate) > CURVED * float(np.abs(rate).max())
        longest = max(
            (self._longest(turning & (sign * rate > 0.0)) for sign in (1, -1)), key=lambda s: s.stop - s.start
        )
        return 1 if float(rate[longest].mean()) > 0.0 else -1

    def _require(self, test: str, found: Relation) -> None:
        if not found.informative:
            raise self._failed(
                test,
                f"{len(found.start)} windows of {WINDOW:g} s with too little motion",
                f"at least {LEAST} with enough",
            )
        if abs(found.correlation) < SURE:
            hint = "" if self.minute.attitude is not None else "; vectors in world axes need an attitude"
            raise self._failed(
                test, f"a correlation of {abs(found.correlation):.2f}", f"at least {SURE:g}{hint}"
            )

    def _failed(self, test: str, found: str, bound: str) -> NotLearned:
        return NotLearned(f"test '{test}' of {self.minute.source}", found, bound)

    def _notes(self, axes: AxisMap, handed: float) -> Iterator[str]:
        if not axes.gravity:
            yield "the sign of the vertical force is not proven: it is that of right-handed axes"
        elif handed < 0.0:
            yield "the axes are left-handed: x, y and z were each proven"
        if self.minute.derived:
            yield "the source sends no rates: those of its attitude served the tests, and none are cued"
        else:
            yield "the signs of roll and pitch rate are not proven: they are turned like the yaw rate"

    def _channel(self, key: str, values: Vec) -> Channel:
        column = Column(key, 0, key, 1.0, "", assumed=False)
        rows = np.arange(1, len(values) + 1)
        return Channel(
            column=column,
            t=self.minute.t,
            values=values,
            rows=rows,
            place="sample",
            source=self.minute.source,
        )

    @staticmethod
    def _longest(where: Bools) -> slice:
        """Return the longest stretch in which all are true."""
        edges = np.flatnonzero(np.diff(np.r_[False, where, False].astype(np.int8)))
        begins, ends = edges[::2], edges[1::2]
        if len(begins) == 0:
            return slice(0, 0)
        best = int(np.argmax(ends - begins))
        return slice(int(begins[best]), int(ends[best]))


def _signed(*channels: int) -> Mat:
    """Return the matrix whose rows are these channels, counted from 1, with their signs."""
    M = np.zeros((3, 3))
    for row, channel in enumerate(channels):
        M[row, abs(channel) - 1] = np.sign(channel)
    return M
