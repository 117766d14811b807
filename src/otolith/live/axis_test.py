"""The axis test: one axis, leg or crank after the other, 10 mm or 1 degree out and back, slowly.

It is a controller like the other one, so its plans go through the gate, the roll-out and the device's driver.
A motion out accelerates for one second and brakes for one second with a constant command, which covers the
distance exactly; it holds for a second, and comes back in the same way.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError, OtolithError, one_of
from otolith.core.frames import AXES
from otolith.live.core.gate import Gate
from otolith.live.core.session import CUED
from otolith.live.messages import Plan, Report
from otolith.platforms import Platform

WAY: Final = 10e-3  # [m] of an axis, a leg, or the tip of a crank
TURN: Final = np.radians(1.0)  # of a rotation
LEGS: Final = tuple(f"leg{number}" for number in range(1, 7))
CRANKS: Final = tuple(f"crank{number}" for number in range(1, 7))
_HALF: Final = 1.0  # [s] of accelerating, of braking, and of holding
LASTS: Final = 5.0 * _HALF  # [s] of a test
STRAYS: Final = 0.3  # share of a test's way by which the device may report another pose
_RESTS: Final = 0.1  # share of the way within which set-points are at the goal, and per second at rest
# name -> what a person sees when it becomes larger
SEEN: Final = {
    "surge": "forward by 10 mm",
    "sway": "to the left by 10 mm",
    "heave": "up by 10 mm",
    "roll": "its right side down by 1 degree",
    "pitch": "its nose down by 1 degree",
    "yaw": "its nose to the left by 1 degree",
}


class AxisRefused(OtolithError):
    """The gate does not let a test pass."""


def seen(name: str) -> str:
    """Return what a person should see of a test, to go after "the platform moved"."""
    if name in CRANKS:
        return f"as the tip of {name.replace('crank', 'crank ')} turned by 10 mm, to larger angles"
    return SEEN.get(name, f"as {name.replace('leg', 'leg ')} became 10 mm longer")


def movable(gate: Gate) -> list[str]:
    """Return the axes that a platform moves."""
    return [name for axis, name in enumerate(AXES) if gate.bounds.twist[axis] > 0.0]


def goal_of(name: str, platform: Platform) -> Vec:
    """Return the pose (6,) [m, rad] that a test leads to.

    Raises
    ------
    InputError : the name is no axis, leg or crank, or the platform lacks it.
    """
    goal = np.zeros(6)
    if name in AXES:
        axis = AXES.index(name)
        goal[axis] = WAY if axis < 3 else TURN
        return goal
    if name not in LEGS + CRANKS:
        raise InputError("axis", repr(name), one_of([*AXES, *LEGS, *CRANKS], name))
    if platform.hexapod is None:
        raise InputError("axis", name, "an axis: this platform's file has no legs")
    hexapod = platform.six_legs()
    actuators = LEGS if hexapod.cranks is None else CRANKS
    if name not in actuators:
        raise InputError("axis", name, f"{actuators[0]} to {actuators[-1]}, or an axis, on this platform")
    lengths = np.array(hexapod.lengths(np.zeros(6)))
    lengths[actuators.index(name)] += WAY
    return hexapod.pose_of(lengths)


def profile(goal: Vec, period: float) -> Mat:
    """Return the commanded accelerations (K, 6) that lead from neutral to a pose, and back."""
    count = round(_HALF / period)
    strength = np.asarray(goal, dtype=np.float64) / (count * period) ** 2
    pieces = (strength, -strength, 0.0 * strength, -strength, strength)
    return np.concatenate([np.tile(piece, (count, 1)) for piece in pieces])


class AxisTest:
    """Publishes one test per engagement, in the order of its goals."""

    def __init__(self, goals: Sequence[Vec], gate: Gate, period: float) -> None:
        self._plans = [profile(goal, period) for goal in goals]
        self._gate, self._period = gate, period
        self._sequence = 0
        self._current: tuple[int, int] | None = None  # generation, and when it began [ns]
        self.begun = 0  # tests

    def check(self, names: Sequence[str]) -> None:
        """Let the gate judge every test before anything moves.

        Raises
        ------
        AxisRefused : it does not let one pass.
        """
        for name, stages in zip(names, self._plans, strict=True):
            verdict = self._gate.plan(np.zeros((3, 6)), stages, self._period)
            if not verdict.passes:
                raise AxisRefused(f"the test of {name} is refused: {verdict}")

    def tick(self, now_ns: int, report: Report | None) -> Plan:
        """Return the plan for now: that of the present engagement, or none."""
        stages, begun = np.empty((0, 6)), now_ns
        if report is not None and report.state in CUED:
            if self._current is None or self._current[0] != report.generation:
                self._current = (report.generation, now_ns)
                self.begun += 1
            begun = self._current[1]
            if self.begun <= len(self._plans):
                stages = self._plans[self.begun - 1]
        self._sequence += 1
        return Plan(
            sequence=self._sequence,
            generation=-1 if report is None else report.generation,
            time_ns=begun,
            period_ns=round(1e9 * self._period),
            stages=stages,
            healthy=True,
            outcome="axis test",
        )


class Judge:
    """Judges one test by the reports of the output, however late on a busy machine things happen.

    The device must report the goal while the set-points rest there, not at a fixed time after engaging: the
    motion begins when the controller has seen the engagement, and a device is heard of later than it moves.
    Of several reports the last one counts, by which a device has had the most time to settle.

    Parameters
    ----------
    goal : (6,) [m, rad] the pose that the test leads to.
    """

    def __init__(self, goal: Vec) -> None:
        self._goal, self._way = goal, float(np.abs(goal).max())
        self._began = self._arrived = False
        self._latest: Report | None = None
        self._measured: Vec | None = None  # the last pose that was reported while the set-points were there
        self.over = False  # whether the motion has ended
        self.cut_short = ""  # what the session became before the set-points had arrived

    def look(self, report: Report | None) -> None:
        """Take in the latest report; nothing after the end counts."""
        if report is None or self.over:
            return
        if report.state not in CUED:
            self.over, self.cut_short = True, "" if self._arrived else str(report.state)
            return
        self._latest = report
        rests = float(np.abs(report.motion[1]).max()) <= _RESTS * self._way
        if rests and float(np.abs(report.motion[0] - self._goal).max()) <= _RESTS * self._way:
            self._arrived, self._measured = True, report.measured
        follows = report.follows >= 0
        self.over = self._began and rests and not follows
        self._began = self._began or follows

    def wrong(self) -> list[str]:
        """Return a sentence where the device did not report the goal, or could not be asked for it."""
        goal, latest = _words(self._goal), self._latest
        if self.cut_short:
            found = f"the session became {self.cut_short} before the set-points rested at the pose {goal}"
            if latest is None or latest.measured is None:
                return [found]
            poses = _words(latest.measured), _words(latest.motion[0])
            return ["{}: the device reported {} for set-points at {}".format(found, *poses)]
        if not self._arrived:
            return [
                f"the set-points were not seen to rest at the pose {goal}, so the device could not be judged"
            ]
        if self._measured is None or np.abs(self._measured - self._goal).max() <= STRAYS * self._way:
            return []
        return [f"the device reports the pose {_words(self._measured)}, must be near {goal}"]


def _words(pose: Vec) -> str:
    return str((np.round(pose, 4) + 0.0).tolist())  # no zero has a sign
