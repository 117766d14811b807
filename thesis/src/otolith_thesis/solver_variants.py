"""Details that the thesis does not print: the terminal weight, ACADO's regularisation, the solver's start.

Each variant changes one property of the implicit MPC, so that its effect is separated from all others.
"""

from contextlib import redirect_stdout
from dataclasses import dataclass
from enum import StrEnum
from importlib import import_module
from importlib.util import find_spec
from io import StringIO
from typing import Any, Final, cast

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.cueing.mpc.guess import Guess
from otolith.qp.certificate import kkt_residual
from otolith.qp.condensed import CondensedSolver
from otolith.qp.dense import DenseSolver
from otolith.qp.engines import CondensedEngine, StageEngine, expand
from otolith.qp.problem import Qp, Solution, Status
from otolith.qp.stage import OnRequest, StageProblem, StageSolution

_REST: Final = 1e-12  # a smaller gradient at z = 0 counts as rest
QPOASES: Final = "qpoases"  # solver of a loop; needs casadi (extra `check`)
ACADO: Final = "acado"  # solver of a loop: qpOASES as ACADO starts it, see `otolith_thesis.parametric`


def has_qpoases() -> bool:
    """Return whether the thesis's own solver is installed."""
    return find_spec("casadi") is not None


class Start(StrEnum):
    """The working set from which the active-set method starts."""

    PREVIOUS = "previous"  # the last answer's working set
    SHIFTED = "shifted"  # the last answer's working set, shifted by one stage
    COLD = "cold"  # nothing active


class StartedEngine:
    """The dense engine, started from a chosen working set."""

    def __init__(self, problem: StageProblem, *, start: Start, **options: Any) -> None:
        self._engine, self._start = CondensedEngine(problem, **options), start
        self.memory = self._engine.memory
        self._set = np.zeros(self.memory.lower.shape, dtype=np.int64)

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve the problem in the memory."""
        del start, hint
        begin = self._set if self._start is Start.SHIFTED else np.zeros_like(self._set)
        solution = self._engine.run(begin)
        self._set = np.vstack([solution.working_set[1:], solution.working_set[-1:]])
        return solution

    def reset(self) -> None:
        """Discard the last answer."""
        self._engine.reset()
        self._set[:] = 0


class _WarmQpOases:
    """qpOASES (Ferreau et al., 2014) through casadi, which keeps it and hot-starts every further solve."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self._solver: Any = None

    def solve(self, qp: Qp, start: Ints) -> Solution:
        """Solve from qpOASES's own last working set; `start` is ignored."""
        del start
        b, none = qp.bounds, np.full(len(qp.g) - qp.bounds, np.inf)
        with redirect_stdout(
            StringIO()
        ):  # it prints its notice at any print level, which would mix with results
            solver = self._solver = self._solver or self._made(qp)
            found = solver(
                h=qp.H,
                g=qp.g,
                a=qp.A,
                lba=qp.lower[b:],
                uba=qp.upper[b:],
                lbx=np.concatenate([qp.lower[:b], -none]),
                ubx=np.concatenate([qp.upper[:b], none]),
            )
        z, of_rows, of_bounds = (np.asarray(found[name].full()).ravel() for name in ("x", "lam_a", "lam_x"))
        y = np.concatenate([of_bounds[:b], of_rows])
        residual = kkt_residual(qp, z, y)
        if (
            np.max(np.abs(qp.g)) < _REST and not y.any()
        ):  # its accuracy is absolute, so rest is exact only within it
            residual = float(np.max(np.abs(qp.H @ z + qp.g)))
        status = Status.OPTIMAL if residual < self.tolerance else Status.UNCERTIFIED
        return Solution(status, z, y, int(solver.stats()["iter_count"]), residual)

    def _made(self, qp: Qp) -> Any:
        casadi = import_module("casadi")
        sparsity = {name: casadi.Sparsity.dense(*M.shape) for name, M in (("h", qp.H), ("a", qp.A))}
        return casadi.conic(
            "hot", "qpoases", sparsity, {"printLevel": "none", "error_on_fail": False, "sparse": False}
        )


class QpOasesEngine:
    """The thesis's own solver on the condensed problem, hot-started (Table D.1); it needs casadi."""

    def __init__(self, problem: StageProblem, *, tolerance: float, blocks: tuple[int, ...] = ()) -> None:
        self._problem, self._tolerance = problem, 10.0 * tolerance  # its default accuracy
        self.memory = CondensedEngine(problem, tolerance=tolerance, blocks=blocks).memory
        self.reset()

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve the problem in the memory."""
        del start, hint
        return self._solver.solve(expand(self._problem, self.memory))

    def reset(self) -> None:
        """Discard the last answer."""
        dense = cast(DenseSolver, _WarmQpOases(self._tolerance))  # it has the same method
        self._solver = CondensedSolver(self._problem, dense)


class TerminalWeight:
    """An engine whose last stage has a weight (eq. 4.6 has a terminal cost, but no weight is printed)."""

    def __init__(self, engine: StageEngine, factor: float) -> None:
        self._engine, self._factor = engine, factor
        self.memory = engine.memory

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve the problem in the memory with the last stage weighted, and leave the memory as it was."""
        memory, root = self.memory, np.sqrt(self._factor)
        last = (memory.output[-1], memory.error[-1], memory.state_weight[-1])
        kept = [values.copy() for values in last]  # what does not vary is not written again
        for values, weight in zip(last, (root, root, self._factor), strict=True):
            values *= weight
        solution = self._engine.run(start, hint)
        for values, before in zip(last, kept, strict=True):
            values[:] = before
        return solution

    def reset(self) -> None:
        """Discard the last answer."""
        self._engine.reset()


@dataclass(frozen=True, slots=True)
class Damped:
    """A guess as control reference that includes ACADO's Levenberg-Marquardt term λ‖u − u_plan‖².

    R‖u − g‖² + λ‖u − p‖² has the minimiser of (R + λ)‖u − (R g + λ p)/(R + λ)‖². So the term draws the
    controls to the previous plan p like a reference (Table D.1: λ = 1e-4, a tenth of R).
    """

    guess: Guess
    control_weight: float  # R
    damping: float  # λ

    @property
    def active(self) -> bool:
        """Return whether the inner guess is used."""
        return self.guess.active

    def reset(self) -> None:
        """Discard the past."""
        self.guess.reset()

    def controls(self, x: Vec, wanted: Vec, plan: Mat) -> Mat | None:
        """Mix guess and previous plan; None if a guess was requested and not available."""
        inner = self.guess.controls(x, wanted, plan)
        if inner is None and self.active:
            return None
        about = np.zeros_like(plan) if inner is None else inner
        mixed: Mat = (self.control_weight * about + self.damping * plan) / (
            self.control_weight + self.damping
        )
        return mixed
