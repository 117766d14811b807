"""Several algorithms that share no axis, combined into one."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.interfaces import Command, Cueing, Outcome, PlatformState, Reference, Status

_WORST_FIRST: Final = (Status.INVALID, Status.REFUSED, Status.FALLBACK, Status.DECIDED)


class Several:
    """Several algorithms that share no axis; all of them decide, one after the other, in every period."""

    def __init__(self, parts: Sequence[Cueing]) -> None:
        self.parts = tuple(parts)
        first, *others = (part.period for part in self.parts)
        for period in others:
            if period != first:
                raise InputError(
                    "periods of several algorithms at once", f"{first} s and {period} s", "the same"
                )

    @property
    def period(self) -> float:
        """Return the time between two decisions [s]."""
        return self.parts[0].period

    @property
    def soft(self) -> frozenset[str]:
        """Return the limits that any of them may pass with a penalty."""
        return frozenset().union(*(getattr(part, "soft", ()) for part in self.parts))

    def reset(self, state: PlatformState) -> None:
        """Start all from `state`."""
        for part in self.parts:
            part.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide with all; commands are added, because each axis is zero in all but one."""
        return added([part.step(state, reference) for part in self.parts])


def added(commands: Sequence[Command]) -> Command:
    """Combine commands for different axes into one."""
    return Command(
        acceleration=np.sum([command.acceleration for command in commands], axis=0),
        pose=np.sum([command.pose for command in commands], axis=0),
        twist=np.sum([command.twist for command in commands], axis=0),
        plan=_added_plans([command.plan for command in commands]),
        outcome=worst_of([command.outcome for command in commands]),
    )


def _added_plans(plans: Sequence[Mat]) -> Mat:
    """Return the sum of plans (K_i, 6); after its end, a plan is at rest."""
    whole = np.zeros((max(map(len, plans)), 6))
    for plan in plans:
        whole[: len(plan)] += plan
    return whole


def worst_of(outcomes: Sequence[Outcome]) -> Outcome:
    """Combine the outcomes of several problems: the worst status and certificate, and the sum of changes."""
    worst = min(outcomes, key=lambda one: _WORST_FIRST.index(one.status))
    return Outcome(
        status=worst.status,
        solver=worst.solver,
        changes=sum(one.changes for one in outcomes),
        residual=max(one.residual for one in outcomes),
        guess_missed=any(one.guess_missed for one in outcomes),
    )
