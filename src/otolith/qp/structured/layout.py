"""The workspace: one flat vector holds the problem, iterates and answer of a structured engine.

A single vector with compile-time offsets shows the compiler that no two parts overlap, which enables
vectorisation. Each part starts on a cache line. The shapes are those of `otolith.qp.stage`; a sparse matrix
is stored as its non-zeros, row by row, without those that are structurally one; what the factorisation reads
or writes is packed, see `packing`.
"""

from dataclasses import dataclass
from math import prod

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec
from otolith.qp.stage import StageProblem
from otolith.qp.structured.algebra import Matrix, named
from otolith.qp.structured.packing import Packing, packing_of

LANES = 16  # rows are padded to a multiple of this; sums and maxima use this many accumulators
_LINE = 8  # doubles per cache line


@dataclass(frozen=True, slots=True)
class Structure:
    """Sizes and sparsity: everything that the generated code depends on. Matrices hold names, see
    `algebra`.
    """

    N: int
    nx: int
    nu: int
    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix
    V: Matrix
    ny: int
    nc: int
    nv: int
    weighted: tuple[int, ...]
    groups: tuple[int, ...]  # group of each row of a stage, as `StageProblem.groups`
    lengths: tuple[int, ...] = ()  # steps of each block if stages are blocks; N then counts the blocks

    def __hash__(self) -> int:
        """Return a number that equal structures share; that of sizes, since matrices are dictionaries."""
        return hash((self.N, self.nx, self.nu, self.ny, self.nc, self.nv, self.groups, self.lengths))

    @classmethod
    def of(cls, problem: StageProblem, lengths: tuple[int, ...] = ()) -> "Structure":
        """Derive the structure of a problem with blocks of `lengths` steps; entries of D and V always
        count as data.
        """
        A, B = problem.A, problem.B
        if lengths:
            A, B = (_over_all(steps) for steps in powers(A, B, max(lengths)))
        return cls(
            N=len(lengths) or problem.horizon,
            nx=problem.states,
            nu=problem.inputs,
            A=named(A, "A"),
            B=named(B, "B"),
            C=named(problem.C, "C"),
            D=named(_as_data(problem.output), "D"),
            V=named(_as_data(problem.varying), "V"),
            ny=len(problem.output),
            nc=len(problem.C),
            nv=len(problem.varying),
            weighted=problem.weighted,
            groups=tuple(problem.groups.tolist()),
            lengths=lengths,
        )

    @property
    def rows(self) -> int:
        """Number of rows of one stage."""
        return self.nc + self.nv + self.nu

    @property
    def total(self) -> int:
        """Number of rows over the whole horizon, padded."""
        return -(-self.N * self.rows // LANES) * LANES

    @property
    def steps(self) -> int:
        """Number of steps of the whole horizon."""
        return sum(self.lengths) or self.N

    @property
    def packing(self) -> Packing:
        """How matrices over (u_k, x_k) are packed in registers."""
        inputs, states = frozenset(self.B), frozenset((i, self.nu + j) for i, j in self.A)
        return packing_of(self.nu, self.nx, inputs | states)

    @property
    def pivots(self) -> dict[int, int]:
        """For each input, the first constant row that this input alone moves within a step, if there is
        one.
        """
        moved = [{j for state, j in self.B if (row, state) in self.C} for row in range(self.nc)]
        return {j: moved.index({j}) for j in range(self.nu) if {j} in moved}

    def gain(self, j: int, a: int) -> int:
        """Place in GAIN of the gain of input j on variable a, of [B A]."""
        return j * self.packing.width + self.packing.column[a]

    def feed_forward(self, j: int) -> int:
        """Place in GAIN of the feed-forward of input j."""
        return self.nu * self.packing.width + j

    def pivot(self, j: int) -> int:
        """Place in GAIN of the reciprocal of the pivot of input j."""
        return self.feed_forward(self.nu) + j

    @property
    def gains(self) -> int:
        """Count the numbers stored when one stage's inputs are eliminated."""
        return self.pivot(self.nu)


def _over_all(steps: Mat) -> Mat:
    """Make one matrix with the zeros and ones common to all steps (n, rows, columns), and 2 elsewhere."""
    same = (steps == steps[0]).all(axis=0) & np.isin(steps[0], (0.0, 1.0))
    return np.where(same, steps[0], 2.0)


def powers(A: Mat, B: Mat, steps: int) -> tuple[Mat, Mat]:
    """Powers A^j (steps, nx, nx) and B_j = Σ_{i<j} A^i B (steps, nx, nu) for j = 1 … steps."""
    of_A, of_B = [A], [B]
    for _ in range(steps - 1):
        of_A.append(A @ of_A[-1])
        of_B.append(A @ of_B[-1] + B)
    return np.array(of_A), np.array(of_B)


def _as_data(pattern: Bools) -> Mat:
    """Make a matrix whose entries are neither zero nor one where the pattern is true."""
    return np.where(pattern, 2.0, 0.0)


def data(M: Matrix) -> list[tuple[int, int]]:
    """Places of the non-zeros of M that are run-time data, in the order in which they are stored."""
    return sorted(position for position, symbol in M.items() if symbol)


def values(M: Matrix, numbers: Mat) -> Vec:
    """Pick the run-time data of a sparse matrix, (…, number of data), from numbers (…, rows, columns)."""
    positions = data(M)
    i, j = [p[0] for p in positions], [p[1] for p in positions]
    return np.asarray(numbers[..., i, j])


def parts(s: Structure) -> dict[str, tuple[int, ...]]:
    """Shape of every part, in order. The parts up to VARYING are the problem's numbers that must be
    finite.
    """
    N, nx, nu, total, weighted = s.N, s.nx, s.nu, s.total, len(s.weighted)
    longest, packing = max(s.lengths, default=0), s.packing
    dynamics = packing.dynamics_size
    problem = {
        "START": (nx,),  # x_0
        "DYNAMICS": (N, dynamics) if s.lengths else (dynamics,),  # [B A] packed, of each block
        "POWERS": (longest, dynamics),  # [B_j A^j] packed, within a block
        "CONSTANT": (len(data(s.C)),),
        "CONTROL_WEIGHT": (nu,),
        "OUTPUT": (s.steps, len(s.D)),
        "ERROR": (s.steps, s.ny),
        "STATE_WEIGHT": (s.steps, weighted),
        "STATE_LINEAR": (s.steps, weighted),
        "INPUT_LINEAR": (N, nu),
        "VARYING": (N, len(s.V)),
    }
    of_rows = (
        "LOWER UPPER SOFT "  # bounds as given; penalty w
        "LO HI RHO "  # bounds as used (finite); weight of the augmented Lagrangian
        "VALUE MULTIPLIER SET "  # r, y and σ: 0 free, ±1 active, ±2 saturated (soft, |y| = w)
        "HINT OTHER_SET OTHER_MULTIPLIER "  # a second guess, and the first while the second is tried
        "DIAGONAL GRADIENT "  # what the rows add to the stages' Hessian and gradient
        "EXCESS PULL MARK "  # how far free rows are outside; pulls at the ends of arcs; which rows change
        "REACH"  # the largest value of each row over all stages
    )
    of_sides = (
        "DISTANCE T LAMBDA SIGMA NU INV_LAMBDA INV_NU DELTA E1 E2 SCRATCH"  # interior point: 2 sides a row
    )
    own = {
        "BLOCK_HESSIAN": (N * bool(s.lengths), packing.symmetric_size()),
        "BLOCK_GRADIENT": (N * bool(s.lengths), packing.width),
        "U": (N, nu),
        "X": (N, nx),
        "STEP_STATE": (s.steps * bool(s.lengths), nx),  # states of all steps of the plan
        "PLAN": (N, nu),  # last certified inputs
        "INSIDE": (N, nu),  # inputs of the interior point
        "GAIN": (N, s.gains),
        "COST_TO_GO": (N + 1, packing.symmetric_size(nu)),  # P of x_0 … x_N; the last remains zero
        "COSTATE": (nx,),
        "ACCUMULATOR": (2 * LANES,),
        "OFFERED": (1,),  # what is known about a hint: `OFFERS` of `generate`
        "DOUBTED": (s.rows,),  # for each group of rows, how many rows the current set changes in it
        "NEEDED": (1,),  # changes that the current set needs
        "SETTING": (8,),
        "INFO": (7,),  # `INFO` of `generate`
    }
    rows = dict.fromkeys(of_rows.split(), (total,))
    sides = dict.fromkeys(of_sides.split(), (2 * total,))
    return problem | rows | own | sides


def offsets(s: Structure) -> tuple[dict[str, int], int]:
    """Offset of every part in the workspace, and the workspace's length."""
    at, end = {}, 0
    for name, shape in parts(s).items():
        at[name] = end
        end += -(-prod(shape) // _LINE) * _LINE
    return at, end


class Workspace:
    """The vector itself, aligned to a cache line, with a view of every part."""

    def __init__(self, structure: Structure) -> None:
        at, size = offsets(structure)
        room = np.zeros(size + _LINE)
        shift = (-room.ctypes.data // room.itemsize) % _LINE
        self.vector: Vec = room[shift : shift + size]
        shapes = parts(structure)
        self._views = {
            name: self.vector[at[name] : at[name] + prod(shape)].reshape(shape)
            for name, shape in shapes.items()
        }
        N, rows = structure.N, structure.rows
        self._rows = {
            name: self._views[name][: N * rows].reshape(N, rows)
            for name, shape in shapes.items()
            if shape == (structure.total,)
        }

    def __getitem__(self, part: str) -> Mat:
        """View of a part in its own shape."""
        return self._views[part]

    def rows(self, part: str) -> Mat:
        """View (N, rows) of a part with one number per row, without its padding."""
        return self._rows[part]
