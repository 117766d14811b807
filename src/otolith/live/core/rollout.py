"""From plans to set-points: the motion that is sent out moves exactly as the controller's model predicts.

A plan holds commanded accelerations by time. The motion (3, 6) integrates them through the lag of eq. 4.9,
step by step, and is never set to what a plan says it should be: so a set-point cannot jump when plans change,
are late, or contradict each other. Without a stage for now, or when the gate refuses, the motion follows the
law that leads to rest, asked anew once per period. The law is deterministic, and the gate has checked its way
from every motion that passed.
"""

from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.live.core.bounds import Bounds
from otolith.live.core.gate import Gate, Verdict, advance, verdict_of
from otolith.live.messages import Plan
from otolith.safety.law import Reach, move, stop

INSTANT: Final = 1e-9  # [s] durations that are no longer are over
SPEED_AT_REST = 1e-5  # [m/s, rad/s] below which the motion counts as at rest …
ACCELERATION_AT_REST = 1e-3  # [m/s², rad/s²] … together with this


class Track(NamedTuple):
    """Where the set-points are, in a form that kernels take."""

    motion: Mat  # (3, 6) pose, twist, acceleration
    braking: Vec  # (6,) commands of the law in its present period
    left: Vec  # (1,) [s] of that period; negative: no way to rest has begun


@kernel
def brake(of: Track, dt: float, reach: Reach) -> None:
    """Move by dt [s] along the way to rest from the motion that passed last."""
    while dt > INSTANT:
        if of.left[0] <= INSTANT:
            stop(of.motion, reach, of.braking)
            of.left[0] = reach.period
        step = min(dt, of.left[0])
        move(of.motion, of.braking, reach.lag, step)
        of.left[0] -= step
        dt -= step


@kernel
def follow(of: Track, command: Vec, dt: float, b: Bounds, reach: Reach) -> tuple[int, int]:
    """Move by dt [s] under commands (6,) if the gate lets it pass, else along the way to rest.

    Returns
    -------
    What the commands would break, an index of `otolith.live.core.gate.Refusal`, and where.
    """
    code, i = advance(of.motion, command, dt, b, reach)
    if code == 0:
        of.left[0] = -1.0
    else:
        brake(of, dt, reach)
    return code, i


class Rollout:
    """The motion of the set-points, moved in steps of any length.

    Parameters
    ----------
    gate : judges every step, and leads to rest.
    """

    def __init__(self, gate: Gate) -> None:
        self.gate = gate
        self._track = Track(np.zeros((3, 6)), np.zeros(6), np.zeros(1))
        self.follow(np.zeros(6), INSTANT)  # compiled now, so that no set-point waits for the compiler
        self.brake(INSTANT)

    @property
    def motion(self) -> Mat:
        """Pose, twist and acceleration (3, 6) of the set-points; may be written."""
        return self._track.motion

    def place(self, pose: Vec) -> None:
        """Start at rest at a pose (6,)."""
        self.motion[:] = 0.0
        self.motion[0] = pose
        self.forget()

    def forget(self) -> None:
        """Begin a new way to rest when one is needed, from the motion that is then."""
        self._track.left[0] = -1.0

    def follow(self, command: Vec, dt: float) -> Verdict:
        """Move by dt [s] under commands (6,) if the gate lets it pass, else along the way to rest."""
        gate = self.gate
        return verdict_of(follow(self._track, gate.writable(command), dt, gate.bounds, gate.reach))

    def brake(self, dt: float) -> None:
        """Move by dt [s] along the way to rest from the motion that passed last."""
        brake(self._track, dt, self.gate.reach)

    @property
    def rests(self) -> bool:
        """True if the motion is at rest but for rounding."""
        slow = float(np.abs(self.motion[1]).max()) <= SPEED_AT_REST
        return slow and float(np.abs(self.motion[2]).max()) <= ACCELERATION_AT_REST


def ahead(rollout: Rollout, motion: Mat, plan: Plan | None, span_ns: tuple[int, int]) -> Mat:
    """Return where a motion (3, 6) will be at the end of a span of time [ns] under a plan.

    `rollout` is worked with and left there. Where the plan has no stage, the law to rest acts.
    """
    now, end = span_ns
    rollout.motion[:] = motion
    rollout.forget()
    while now < end:
        command = None if plan is None else plan.command(now)
        until = end
        if plan is not None and command is not None:
            k = (now - plan.time_ns) // plan.period_ns
            until = min(end, plan.time_ns + (k + 1) * plan.period_ns)
            rollout.gate.move(rollout.motion, command, 1e-9 * (until - now))
        else:
            rollout.brake(1e-9 * (until - now))
        now = until
    return rollout.motion.copy()
