"""What is known before the QP is solved: a guess of the controls, or a hint of the working set.

The thesis's four cueing models (section 3.1) differ in their guess of the controls alone: none, the first
control of the previous plan held over the horizon, the explicit law's first input held, or all its inputs in
equal sections. How such a guess then enters the implicit MPC is `otolith.cueing.mpc.settings.Entry`.

A hint names the rows that will be active. Where the working set that the engine remembers does not settle at
once, it asks for the hint, takes of the two the one that fewer conditions contradict, and goes on from there:
the answer is the same in any case.
Hints from offline knowledge are in `otolith.cueing.hints`.
"""

from collections.abc import Sequence
from typing import Final, Protocol

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.cueing.mpc.explicit import ExplicitLaw


class Guess(Protocol):
    """Makes a guess of the controls over the horizon."""

    @property
    def active(self) -> bool:
        """False when there is no guess to make, so that a None is no miss."""

    def reset(self) -> None:
        """Forget the past."""

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat | None:
        """Guess (N, 2P) from the states x (6P,) of P pairs, forces wanted (P,), previous plan (N, 2P).

        Per pair the controls are [a_rot, a_tran]. None where there is no guess: the implicit MPC then
        runs without.
        """


class Hint(Protocol):
    """Guesses which rows will be active; asked only where the remembered working set does not settle."""

    def reset(self) -> None:
        """Forget the past."""

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Candidates (K, M, rows), see `otolith.qp.stage.StageSolution.working_set`, or None.

        Arguments as of `Guess.controls`. Valid until the next call.
        """


class MissingHint:
    """A hint that was refused: every decision that asks for it says that it was missing."""

    def reset(self) -> None:
        """Nothing to forget."""

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Return None: there is no hint to give."""
        del x, wanted, plan
        return None


class NoGuess:
    """Model 1: the implicit MPC on its own."""

    active: Final = False

    def reset(self) -> None:
        """Nothing to forget."""

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat | None:
        """Return None: there is no guess to make."""
        del x, wanted, plan
        return None


class HeldPlan:
    """Model 2, "with control trajectory prediction": the first control of the previous plan, held."""

    active: Final = True

    def reset(self) -> None:
        """Nothing to forget: the plan is the controller's."""

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat | None:
        """Repeat the plan's first control."""
        del x, wanted
        return np.broadcast_to(plan[0], plan.shape)


class FromExplicit:
    """Models 3 and 4: the explicit law's first input held, or all of them in equal sections."""

    active: Final = True

    def __init__(self, laws: Sequence[ExplicitLaw], *, first_only: bool) -> None:
        self._laws, self._first_only = tuple(laws), first_only  # one law per pair

    def reset(self) -> None:
        """Forget the regions of the last query."""
        for law in self._laws:
            law.reset()

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat | None:
        """Look the laws up and stretch their inputs over the finer horizon."""
        states = x.reshape(len(self._laws), -1)
        looked_up = [law.inputs(states[p], wanted[p]) for p, law in enumerate(self._laws)]
        found = [U for U in looked_up if U is not None]
        if len(found) < len(looked_up):
            return None
        U = np.hstack(found)
        if self._first_only:
            return np.broadcast_to(U[0], plan.shape)
        N, coarse = len(plan), len(U)
        section = np.minimum(np.arange(N) * coarse // N, coarse - 1)  # 1–10, 11–20, … for 5 and 50
        stretched: Mat = U[section]
        return stretched
