"""Several algorithms that share no axis, combined into one."""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple, cast

import numpy as np

from otolith.compiled import (
    CHANGES,
    DECIDE,
    MISSED,
    NOTHING,
    RESIDUAL,
    SOLVER,
    STATUS,
    CompiledCueing,
    offered,
)
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.methods import Bound, Method
from otolith.interfaces import Command, Cueing, Outcome, PlatformState, Reference, Status

_inner = DECIDE.call
_WORST_FIRST: Final = (Status.INVALID, Status.REFUSED, Status.FALLBACK, Status.DECIDED)


class _Parts(NamedTuple):
    methods: Ints  # (P, 2) code and data of every part
    command: Mat  # (P, 6), with a base (P, 12)
    result: Mat  # (P, 5)
    at: Ints  # (1,) the part that decides


@kernel
def _decide(
    of: Any, motion: Mat, now: Vec, preview: Mat, age: float, again: int, command: Vec, result: Vec
) -> int:
    """Let all parts decide, and add their commands; see `otolith.compiled.DECIDE`."""
    first = of.at[0] if again == 1 else 0
    for k in range(len(of.methods)):
        if k >= first:
            resumed = again if k == first else 0
            method = Method(of.methods[k, 0], of.methods[k, 1])
            request = _inner(method, (motion, now, preview, age, resumed, of.command[k], of.result[k]))
            if request != NOTHING:
                of.at[0] = k
                waiting: int = request
                return waiting
    _add(of.command, of.result, command, result)
    return NOTHING


@kernel
def _add(commands: Mat, outcomes: Mat, command: Vec, result: Vec) -> None:
    """Write the sum of commands (P, 6 or 12), and one outcome for them as `worst_of` does."""
    worst = 0
    command[:], result[:] = 0.0, 0.0
    for k in range(len(commands)):
        if outcomes[k, STATUS] > outcomes[worst, STATUS]:
            worst = k
        for axis in range(len(command)):
            command[axis] += commands[k, axis]
        result[CHANGES] += outcomes[k, CHANGES]
        result[RESIDUAL] = max(result[RESIDUAL], outcomes[k, RESIDUAL])
        result[MISSED] = max(result[MISSED], outcomes[k, MISSED])
    result[STATUS], result[SOLVER] = outcomes[worst, STATUS], outcomes[worst, SOLVER]


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
    def carriers(self) -> int:
        """Return 2 if one of them also moves the base that carries the platform, else 1."""
        return max(getattr(part, "carriers", 1) for part in self.parts)

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

    def compiled(self) -> Bound | None:
        """Return the method of all together; None if one of them offers none."""
        bound = [offered(part) for part in self.parts]
        self._bound = [one for one in bound if one is not None]  # keeps their data alive
        if len(self._bound) < len(bound):
            return None
        P = len(bound)
        self._at = np.zeros(1, dtype=np.int64)
        methods = np.array([one.method for one in self._bound])
        return DECIDE.bind(
            _decide, _Parts(methods, np.zeros((P, 6 * self.carriers)), np.zeros((P, 5)), self._at)
        )

    def answer(self, request: int, reference: Reference) -> None:
        """Meet the request of the part that is deciding."""
        cast(CompiledCueing, self.parts[self._at[0]]).answer(request, reference)


def added(commands: Sequence[Command]) -> Command:
    """Combine commands for different axes into one."""
    bases = [command.base for command in commands if command.base is not None]
    return Command(
        acceleration=np.sum([command.acceleration for command in commands], axis=0),
        pose=np.sum([command.pose for command in commands], axis=0),
        twist=np.sum([command.twist for command in commands], axis=0),
        plan=_added_plans([command.plan for command in commands]),
        outcome=worst_of([command.outcome for command in commands]),
        base=added(bases) if bases else None,
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
