"""From plans to set-points: the motion that is sent out moves exactly as the controller's model predicts.

A plan holds commanded accelerations by time. The motion (3, 6) integrates them through the lag of eq. 4.9,
step by step, and is never set to what a plan says it should be: so a set-point cannot jump when plans change,
are late, or contradict each other. Without a stage for now, or when the gate refuses, the motion follows the
law that leads to rest, asked anew once per period. The law is deterministic, and the gate has checked its way
from every motion that passed.
"""

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.live.core.gate import Gate, Verdict
from otolith.live.messages import Plan

SPEED_AT_REST = 1e-5  # [m/s, rad/s] below which the motion counts as at rest …
ACCELERATION_AT_REST = 1e-3  # [m/s², rad/s²] … together with this


class Rollout:
    """The motion of the set-points, moved in steps of any length.

    Parameters
    ----------
    gate : judges every step, and leads to rest.
    """

    def __init__(self, gate: Gate) -> None:
        self.gate = gate
        self.motion = np.zeros((3, 6))  # pose, twist, acceleration
        self._braking = np.zeros(6)  # commands of the law in its present period
        self._left = 0.0  # [s] of that period; negative: no way to rest has begun

    def place(self, pose: Vec) -> None:
        """Start at rest at a pose (6,)."""
        self.motion[:] = 0.0
        self.motion[0] = pose
        self._left = -1.0

    def follow(self, command: Vec, dt: float) -> Verdict:
        """Move by dt [s] under commands (6,) if the gate lets it pass, else along the way to rest."""
        verdict = self.gate.advance(self.motion, command, dt)
        if verdict.passes:
            self._left = -1.0
        else:
            self.brake(dt)
        return verdict

    def brake(self, dt: float) -> None:
        """Move by dt [s] along the way to rest from the motion that passed last."""
        while dt > 1e-9:
            if self._left <= 1e-9:
                self.gate.brake(self.motion, self._braking)
                self._left = self.gate.reach.period
            step = min(dt, self._left)
            self.gate.move(self.motion, self._braking, step)
            self._left -= step
            dt -= step

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
    rollout._left = -1.0
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
