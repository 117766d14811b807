"""Knowledge before the QP is solved: a guess of the controls, or a hint of the working set.

The thesis's four cueing models (section 3.1) differ only in their guess of the controls: none, the first
control of the previous plan held over the horizon, the explicit law's first input held, or all its inputs in
equal sections. `otolith.cueing.mpc.settings.Entry` states how such a guess enters the implicit MPC.

A hint names the rows that will be active. If the working set that the engine remembers is not optimal at
once, the engine requests the hint, takes from the two the one that violates fewer conditions, and continues
from there. The answer is the same in any case. Hints from offline knowledge are in `otolith.cueing.hints`.
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
        """Return whether there is a guess to make, so that None means that it was missed."""

    def reset(self) -> None:
        """Discard the past."""

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat | None:
        """Return a guess (N, 2P), or None if there is none; the implicit MPC then runs without it.

        Parameters
        ----------
        x : (6P,) states of P pairs.
        wanted : (P,) wanted forces.
        plan : (N, 2P) previous plan; the controls of a pair are [a_rot, a_tran].
        """


class Hint(Protocol):
    """Guesses which rows will be active; requested only if the remembered working set is not optimal."""

    def reset(self) -> None:
        """Discard the past."""

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Return candidates (K, M, rows), see `otolith.qp.stage.StageSolution.working_set`, or None.

        Arguments are those of `Guess.controls`. The result is valid until the next call.
        """


class MissingHint:
    """A hint that was refused; every decision that requests it reports that it was missing."""

    def reset(self) -> None:
        """Do nothing: there is no memory."""

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Return None: there is no hint."""
        del x, wanted, plan
        return None


class NoGuess:
    """Model 1: the implicit MPC without a guess."""

    active: Final = False

    def reset(self) -> None:
        """Do nothing: there is no memory."""

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat | None:
        """Return None: there is no guess."""
        del x, wanted, plan
        return None


class HeldPlan:
    """Model 2, "with control trajectory prediction": the first control of the previous plan, held."""

    active: Final = True

    def reset(self) -> None:
        """Do nothing: the controller keeps the plan."""

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat | None:
        """Repeat the plan's first control."""
        del x, wanted
        return np.broadcast_to(plan[0], plan.shape)


class FromExplicit:
    """Models 3 and 4: the explicit law's first input held, or all its inputs in equal sections."""

    active: Final = True

    def __init__(self, laws: Sequence[ExplicitLaw], *, first_only: bool) -> None:
        self._laws, self._first_only = tuple(laws), first_only  # one law per pair

    def reset(self) -> None:
        """Discard the regions of the last query."""
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
