"""The structured engine: a workspace, the kernels of its structure, and the memory of its last answer."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.lti import condense
from otolith.qp.blocked import Lengths, block_bounds, block_ends, block_starts, hold
from otolith.qp.problem import Status
from otolith.qp.stage import OnRequest, StageProblem, StageQp, StageSolution
from otolith.qp.structured.generate import CODES, OFFERS, PENDING, SETTINGS, module_of
from otolith.qp.structured.layout import Structure, Workspace, powers, values

_STATUS: Final = tuple(Status[name] for name in CODES)
_OPTIMAL: Final = CODES.index("OPTIMAL")
_ASKING: Final = (CODES + PENDING).index("ASKING")
_ON_REQUEST, _REFUSED, _GIVEN = (OFFERS.index(name) for name in ("ON_REQUEST", "REFUSED", "GIVEN"))
_HARD: Final = 1e10  # replaces an infinite penalty
_STIFFNESS: Final = 2e8  # ρ c of an active row, where c is its compliance


@dataclass(frozen=True, slots=True, kw_only=True)
class StructuredSettings:
    """How much effort the engine spends, and which answers it accepts."""

    tolerance: float = 1e-6  # largest certificate that counts as solved
    exchange_limit: int = (
        20  # largest number of factorisations from the previous working set; 0 starts cold every time
    )
    polish_limit: int = 12  # largest number of factorisations after each interior point
    iteration_limit: int = 60  # largest number of interior-point iterations


class StructuredSolver:
    """Solves problems of one structure, each starting from the working set of the previous one.

    `solve` takes a whole `StageQp`. In real time, write into the views that `part` and `rows` return and run
    `kernels.solve(vector)`.

    Parameters
    ----------
    blocks : number of steps of each block of constant inputs, see `otolith.qp.blocked`; empty for one block
        per step. The N of the answers then counts blocks.
    extension : Python source that is compiled together with the engine, to make a whole step one call: a
        function with `@kernel` that writes parts of the workspace W (their names are their offsets),
        linearised about the states that `predict_plan(W)` leaves in STEP_STATE, and ends with `solve(W)`.
    """

    def __init__(
        self,
        problem: StageProblem,
        settings: StructuredSettings | None = None,
        *,
        blocks: Lengths = (),
        extension: str = "",
    ) -> None:
        if blocks and (min(blocks) < 1 or sum(blocks) != problem.horizon):
            raise ValueError(f"blocks {blocks} do not fill a horizon of {problem.horizon} steps")
        self.problem, self.settings = problem, settings or StructuredSettings()
        self.structure = Structure.of(problem, blocks)
        self.kernels: Any = module_of(self.structure, extension)
        self._workspace = Workspace(self.structure)
        self._offered, self._hint = self.part("OFFERED"), self.rows("HINT")
        self._answer = (self.part("INFO"), self.part("PLAN"), self.part("X"), self.rows("MULTIPLIER"))
        self._write_constants()

    @property
    def vector(self) -> Vec:
        """The workspace, in the form that the kernels take."""
        return self._workspace.vector

    def part(self, name: str) -> Mat:
        """View of a part of the workspace; `otolith.qp.structured.layout` lists names and shapes."""
        return self._workspace[name]

    def rows(self, name: str) -> Mat:
        """View (N, rows) of a part that has one number per row."""
        return self._workspace.rows(name)

    def reset(self) -> None:
        """Forget working set, multipliers and plan."""
        self.kernels.forget(self.vector)

    def load(self, qp: StageQp) -> None:
        """Copy a problem into the workspace; its arrays cover all steps, also when stages are blocks."""
        s = self.structure
        self.part("START")[:] = qp.x0
        self.part("OUTPUT")[:] = values(s.D, qp.output)
        self.part("ERROR")[:] = qp.error
        self.part("STATE_WEIGHT")[:] = qp.state_weight
        self.part("STATE_LINEAR")[:] = qp.state_linear
        lengths = s.lengths or (1,) * s.N
        self.part("INPUT_LINEAR")[:] = np.add.reduceat(qp.input_linear, block_starts(lengths), axis=0)
        self.part("VARYING")[:] = values(s.V, qp.varying)[block_ends(lengths)]
        self.rows("LOWER")[:], self.rows("UPPER")[:] = block_bounds(qp, lengths)

    def solve(self, qp: StageQp, start: Ints | None = None) -> StageSolution:
        """Solve `qp`; `start` (N, rows) is a working set as in `StageSolution`, None for the previous
        answer's.
        """
        self.load(qp)
        return self.run(start)

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:
        """Solve the problem in the workspace; the arguments are those of
        `otolith.qp.engines.StageEngine.run`.
        """
        if start is not None:
            self.rows("SET")[:] = start
        if hint is None:
            self.kernels.solve(self.vector)
        else:
            self._solve_with(hint)
        return self.solution()

    def _solve_with(self, hint: OnRequest) -> None:
        """Solve, and request the hint only if the kernel asks for it."""
        self._offered[0] = _ON_REQUEST
        if self.kernels.solve(self.vector) != _ASKING:
            return
        self.offer(hint())
        self.kernels.solve(self.vector)

    def offer(self, hint: Ints | None) -> None:
        """Write the hint (N, rows) that `solve` asked for, or that there is none."""
        if hint is not None:
            self._hint[:] = hint
        self._offered[0] = _REFUSED if hint is None else _GIVEN

    def solution(self) -> StageSolution:
        """Read the answer of the last solve from the workspace; if it failed, U is still the last
        certified plan.
        """
        info, U, X, y = self._answer
        code, residual, changes, factorisations, _, iterations, hinted = info.tolist()
        return StageSolution(
            _STATUS[int(code)],
            U.copy(),
            X.copy(),
            y.copy(),
            int(changes),
            int(factorisations),
            int(iterations),
            residual if code == _OPTIMAL else np.inf,
            hinted == 1.0,
        )

    def _write_constants(self) -> None:
        problem, s = self.problem, self.structure
        A, B = powers(problem.A, problem.B, max(s.lengths, default=1))
        steps = s.packing.packed(A, B)  # (longest, numbers of [B A])
        self.part("DYNAMICS")[:] = steps[np.asarray(s.lengths) - 1] if s.lengths else steps[0]
        self.part("POWERS")[:] = steps[: len(self.part("POWERS"))]
        self.part("CONSTANT")[:] = values(s.C, problem.C)
        self.part("CONTROL_WEIGHT")[:] = problem.control_weight
        self.part("LOWER")[:], self.part("UPPER")[:] = (
            -1.0,
            1.0,
        )  # bounds of the padding, which is never active
        self.part("SOFT")[:], self.part("RHO")[:] = _HARD, 1.0
        lengths = s.lengths or (1,) * s.N
        self.rows("SOFT")[:] = np.minimum(problem.penalty[block_ends(lengths)], _HARD)
        self.rows("RHO")[:] = _STIFFNESS / compliance(problem, lengths)
        given = (self.settings.tolerance, self.settings.exchange_limit, self.settings.polish_limit)
        self.part("SETTING")[: len(SETTINGS)] = (*given, self.settings.iteration_limit)


def compliance(problem: StageProblem, lengths: Lengths) -> Vec:
    """How far each row moves per unit of its multiplier (rows,): max_k c_r Γ_k R⁻¹ Γ_kᵀ c_rᵀ, or R⁻¹ for
    inputs.

    Γ_k is the effect of the blocks' inputs on the state at the end of block k, R their weights.
    """
    _, Gamma = condense(problem.A, problem.B, problem.horizon)  # (N, nx, N·nu)
    at_ends = Gamma[block_ends(lengths)] @ hold(lengths, problem.inputs)  # (blocks, nx, blocks·nu)
    on_states = np.vstack([problem.C, problem.varying.astype(np.float64)]) @ at_ends
    weight = np.outer(lengths, problem.control_weight).ravel()
    of_states = np.max(on_states**2 @ (1.0 / weight), axis=0)
    return np.concatenate([np.maximum(of_states, 1e-12), 1.0 / (max(lengths) * problem.control_weight)])
