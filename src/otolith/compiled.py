"""The compiled side of the roles in `otolith.interfaces`: how one kernel calls another.

An algorithm, a predictor or a plant that offers a method of its role (`otolith.core.methods`) can take part
in a closed loop that is compiled as a whole. Its Python methods call the same kernel, so that its behaviour
is described only once.

A kernel may need something that only Python can do: a guess from a stored law, or an engine of another
project. It then returns the number of a request, and is called again when the request has been met. This is
reverse communication as in `otolith.qp.structured`: compiled code never calls back into Python.
"""

from typing import Any, Final, Protocol

from otolith.core.arrays import Vec
from otolith.core.methods import CUBE, INTEGER, MATRIX, NUMBER, VECTOR, Bound, Role
from otolith.interfaces import Cueing, Outcome, Reference, Status
from otolith.qp.problem import Status as SolverStatus

NOTHING: Final = 0  # the request of a kernel that has done its work

# ahead(data, now (6,), preview (K, 3), coming (n, 6)): as `otolith.interfaces.Predictor.ahead`
PREDICT: Final = Role(INTEGER, (VECTOR, MATRIX, MATRIX))

# decide(data, motion (3, 6), now (6,), preview (K, 3), age, again, command (6,), result (5,)): as
# `otolith.interfaces.Cueing.step`; `again` is 1 when the request has been met. On a base that moves, motion
# is (6, 6) and command (12,): those of the platform, then those of the base
DECIDE: Final = Role(INTEGER, (MATRIX, VECTOR, MATRIX, NUMBER, INTEGER, VECTOR, VECTOR))

# follow(data, command (6,), motion (n, 3, 6), force (n, 3)): as n calls of `otolith.interfaces.Plant.step`
# with one new command and the time step for which the method was made; a force that is not sensed is NaN. On
# a base that moves, command is (12,) and motion (n, 6, 6), as for `DECIDE`
FOLLOW: Final = Role(INTEGER, (VECTOR, CUBE, MATRIX))

STATUS, SOLVER, CHANGES, RESIDUAL, MISSED = range(5)  # what `result` holds, numbers of an `Outcome`
STATUSES: Final = tuple(Status)
SOLVERS: Final = ("", *SolverStatus)
DECIDED, FALLBACK, REFUSED, INVALID = map(STATUSES.index, Status)
OPTIMAL: Final = SOLVERS.index(SolverStatus.OPTIMAL)
INFEASIBLE: Final = SOLVERS.index(SolverStatus.INFEASIBLE)


class CompiledCueing(Cueing, Protocol):
    """An algorithm that offers a method of the role `DECIDE`."""

    def compiled(self) -> Bound | None:
        """Return the method; None if some part of the algorithm offers none."""

    def answer(self, request: int, reference: Reference) -> None:
        """Meet a request of the kernel; `reference` is that of the decision."""


def offered(party: Any, *step: float) -> Bound | None:
    """Return the method of an algorithm, or of a plant for its step [s]; None if it offers none."""
    compiled = getattr(party, "compiled", None)
    return None if compiled is None else compiled(*step)


def outcome_of(result: Vec) -> Outcome:
    """Return the outcome that the result (5,) of a decision describes."""
    status, solver, changes, residual, missed = result.tolist()
    return Outcome(
        status=STATUSES[int(status)],
        solver=str(SOLVERS[int(solver)]),
        changes=int(changes),
        residual=residual,
        guess_missed=missed == 1.0,
    )
