"""Heave and yaw beside the axis pairs: six degrees of freedom of an algorithm that cues pairs only.

Nothing couples heave and yaw to the pairs but what the driver's own turning adds, which is small of the
second order. So whatever cues the pairs, each of the two is a certified problem of its own: the
decoupled sub-problem of `otolith.mpc.linear`, with the horizon, lag, washout and engine of the implicit
MPC, tracking the physical force and rate as that one does.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from otolith.core.errors import InputError
from otolith.interfaces import Command, Cueing, PlatformState, Reference
from otolith.mpc.design import Design
from otolith.mpc.linear import single_axes, together


class Beside:
    """Several algorithms that share no axis as one; all decide, one after the other, in every period."""

    def __init__(self, parts: Sequence[Cueing]) -> None:
        self.parts = tuple(parts)
        first, *others = (part.period for part in self.parts)
        for period in others:
            if period != first:
                raise InputError("periods beside each other", f"{first} s and {period} s", "the same")

    @property
    def period(self) -> float:
        """Time between two decisions [s]."""
        return self.parts[0].period

    @property
    def soft(self) -> frozenset[str]:
        """Limits that any of them may pass at a price."""
        return frozenset().union(*(getattr(part, "soft", ()) for part in self.parts))

    def reset(self, state: PlatformState) -> None:
        """Start all from `state`."""
        for part in self.parts:
            part.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide all; axes are added, for each has one author and the others leave it at zero."""
        commands = [part.step(state, reference) for part in self.parts]
        known = min(len(command.plan) for command in commands)
        return Command(
            acceleration=np.sum([command.acceleration for command in commands], axis=0),
            pose=np.sum([command.pose for command in commands], axis=0),
            twist=np.sum([command.twist for command in commands], axis=0),
            plan=np.sum([command.plan[:known] for command in commands], axis=0),
            outcome=together([command.outcome for command in commands]),
        )


def with_singles(make: Callable[[Design], Cueing], design: Design) -> Cueing:
    """What `make` makes of the pairs of a design, and beside it the design's heave and yaw."""
    if not design.singles:
        return make(design)
    singles = single_axes(design)
    return Beside([make(replace(design, singles=())), singles]) if design.pairs else singles
