"""Moves between poses at rest: straight, with limited jerk, and checked before they begin.

They engage the platform from where it is measured to be, return it to neutral, and park it. The time law is
Ruckig's (Berscheid & Kröger, Jerk-limited real-time trajectory generation, 2021),
synchronised in phase, so that the six axes move along a straight line. It is sampled and judged by the gate,
and never asked for extrema or limits of position, which it does not keep.

A move begins from rest. From motion the way is: brake first, ease after. One move for both left the limits of
the axes in 18 % of the moving states within half the workspace that it was tried from.
"""

from typing import Any, Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import MissingExtra, OtolithError
from otolith.live.core.bounds import ACCELERATION, SPEED
from otolith.live.core.gate import Gate

JERK: Final = np.array([10.0] * 3 + [5.0] * 3)  # [m/s³, rad/s³]
SHARE: Final = 0.5  # of the platform's own limits that a move uses at most
SPACING: Final = 20e-3  # [s] of the samples that are judged before a move begins
NEAR: Final = 1e-9  # [m, rad] poses that are no way apart


class CannotMove(OtolithError):
    """A straight move between two poses is not within the platform's limits."""


class Move:
    """One move from rest to rest, as a function of time.

    Parameters
    ----------
    start : (3, 6) motion at rest; rounding of its speed and acceleration is taken over.
    goal : (6,) pose.

    Raises
    ------
    CannotMove : a pose on the way is out of reach of the axes or legs.
    """

    def __init__(self, start: Mat, goal: Vec, gate: Gate) -> None:
        self.goal = np.array(goal, dtype=np.float64)
        self._trajectory = _planned(start, self.goal, gate)
        self.duration = 0.0 if self._trajectory is None else float(self._trajectory.duration)  # [s]
        self._check(start, gate)

    def __deepcopy__(self, memo: dict[int, Any]) -> "Move":
        """Return the move itself: it does not change, and Ruckig's trajectory cannot be copied."""
        return self

    def at(self, seconds: float, motion: Mat) -> None:
        """Write the motion (3, 6) at a time from the start of the move."""
        if self._trajectory is None or seconds >= self.duration:
            motion[:] = 0.0
            motion[0] = self.goal
            return
        motion[0], motion[1], motion[2] = self._trajectory.at_time(seconds)

    def _check(self, start: Mat, gate: Gate) -> None:
        motion, goal = np.zeros((3, 6)), self.goal
        for seconds in np.append(np.arange(0.0, self.duration, SPACING), self.duration):
            self.at(float(seconds), motion)
            verdict = gate.point(motion, motion, 0.0)
            if not verdict.passes:
                poses = f"from {_text(start[0])} to {_text(goal)}"
                raise CannotMove(f"no straight move {poses} [m, rad]: {verdict} after {seconds:.2f} s")


def planner() -> Any:
    """Return the module that plans moves, `ruckig`; a session asks for it before it starts anything.

    Raises
    ------
    MissingExtra : it is not installed.
    """
    try:
        import ruckig
    except ModuleNotFoundError as error:
        raise MissingExtra(
            "live operation needs ruckig, which is not installed: pip install 'otolith[live]'"
        ) from error
    return ruckig


def _planned(start: Mat, goal: Vec, gate: Gate) -> Any:
    """Return Ruckig's trajectory of the axes; None if the goal is where the motion is."""
    if not float(np.abs(goal - start[0]).max()) > NEAR and not float(np.abs(start[1:]).max()) > 0.0:
        return None
    ruckig = planner()
    given = ruckig.InputParameter(6)
    given.synchronization = ruckig.Synchronization.Phase
    given.current_position, given.current_velocity, given.current_acceleration = start.tolist()
    given.target_position = goal.tolist()
    given.target_velocity = given.target_acceleration = [0.0] * 6
    bounds = gate.bounds
    given.max_velocity = _least(SPEED, bounds.twist)
    given.max_acceleration = _least(ACCELERATION, bounds.acceleration)
    given.max_jerk = _least(JERK, bounds.jerk)
    trajectory = ruckig.Trajectory(6)
    try:
        ruckig.Ruckig(6).calculate(given, trajectory)
    except ruckig.RuckigError as error:
        raise CannotMove(f"no move to {_text(goal)} [m, rad]: {error}") from error
    return trajectory


def _least(wanted: Vec, limits: Vec) -> list[float]:
    """Return what a move uses of an axis: the wanted value, or a share of the platform's limit.

    Axes that the platform does not move have a limit of zero and stay where they are; Ruckig wants a positive
    number for them too.
    """
    return [
        float(min(want, SHARE * limit) if limit > 0.0 else want)
        for want, limit in zip(wanted, limits, strict=True)
    ]


def _text(pose: Vec) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in pose) + ")"
