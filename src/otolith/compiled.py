"""The compiled side of the roles in `otolith.interfaces`: what one kernel asks of another one.

An algorithm, a predictor or a plant that offers a method of its role (`otolith.core.methods`) can take part
in a closed loop that is compiled as a whole. The Python side of the same object calls the same kernel, so
that there is one description of what it does.

A kernel may need what only Python can do: a guess from a stored law, or an engine of somebody else's. It then
returns a number that says what it asks for, and is called again when that is there. This is reverse
communication as in `otolith.qp.structured`: nothing has to be called back from compiled code.
"""

from typing import Any, Final, Protocol

from otolith.core.arrays import Vec
from otolith.core.methods import CUBE, INTEGER, MATRIX, NUMBER, VECTOR, Bound, Role
from otolith.interfaces import Cueing, Outcome, Reference, Status
from otolith.qp.problem import Status as SolverStatus

NOTHING: Final = 0  # what is asked for by a kernel that has done its work

# ahead(data, now (6,), preview (K, 3), coming (n, 6)): as `otolith.interfaces.Predictor.ahead`
PREDICT: Final = Role(INTEGER, (VECTOR, MATRIX, MATRIX))

# decide(data, motion (3, 6), now (6,), preview (K, 3), age, again, command (6,), told (5,)): as
# `otolith.interfaces.Cueing.step`; `again` is 1 where what was asked for is there
DECIDE: Final = Role(INTEGER, (MATRIX, VECTOR, MATRIX, NUMBER, INTEGER, VECTOR, VECTOR))

# follow(data, command (6,), motion (n, 3, 6), force (n, 3)): as n calls of `otolith.interfaces.Plant.step`
# with one new command, for the step that the method was made for; NaN as force where none is sensed
FOLLOW: Final = Role(INTEGER, (VECTOR, CUBE, MATRIX))

STATUS, SOLVER, CHANGES, RESIDUAL, MISSED = range(5)  # what `told` holds, numbers of an `Outcome`
STATUSES: Final = tuple(Status)
SOLVERS: Final = ("", *SolverStatus)
DECIDED, FALLBACK, REFUSED, INVALID = map(STATUSES.index, Status)
OPTIMAL: Final = SOLVERS.index(SolverStatus.OPTIMAL)


class CompiledCueing(Cueing, Protocol):
    """An algorithm that offers a method of the role `DECIDE`."""

    def compiled(self) -> Bound | None:
        """Return the method; None if some part of the algorithm offers none."""

    def answer(self, wish: int, reference: Reference) -> None:
        """Do what the kernel has asked for; `reference` is that of the decision."""


def offered(party: Any, *step: float) -> Bound | None:
    """Return the method of an algorithm, or of a plant for its step [s]; None if it offers none."""
    compiled = getattr(party, "compiled", None)
    return None if compiled is None else compiled(*step)


def outcome_of(told: Vec) -> Outcome:
    """The outcome that a decision's `told` (5,) describes."""
    status, solver, changes, residual, missed = told.tolist()
    return Outcome(
        status=STATUSES[int(status)],
        solver=str(SOLVERS[int(solver)]),
        changes=int(changes),
        residual=residual,
        guess_missed=missed == 1.0,
    )
