"""Where everything lies: one flat vector holds problem, iterates and answer of a structured engine.

A single vector with compile-time offsets lets the compiler see that no two parts overlap, which is
what makes it vectorise. Each part starts on a cache line. Shapes as in `otolith.qp.stage`; the
values of a sparse matrix are its non-zeros, row by row, without those that are structurally one.
"""

from dataclasses import dataclass
from math import prod

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec
from otolith.qp.stage import StageProblem
from otolith.qp.structured.algebra import Matrix, named

LANES = 16  # rows are padded to a multiple of this, and sums and maxima run in so many lanes
_LINE = 8  # doubles per cache line


@dataclass(frozen=True, slots=True)
class Structure:
    """Sizes and sparsity: all that the generated code depends on. Matrices hold names, see `algebra`."""

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

    @classmethod
    def of(cls, problem: StageProblem) -> "Structure":
        """Structure of a problem; outputs' and varying rows' entries are always data."""
        return cls(
            N=problem.horizon,
            nx=problem.states,
            nu=problem.inputs,
            A=named(problem.A, "A"),
            B=named(problem.B, "B"),
            C=named(problem.C, "C"),
            D=named(_as_data(problem.output), "D"),
            V=named(_as_data(problem.varying), "V"),
            ny=len(problem.output),
            nc=len(problem.C),
            nv=len(problem.varying),
            weighted=problem.weighted,
        )

    @property
    def rows(self) -> int:
        """Rows of one stage."""
        return self.nc + self.nv + self.nu

    @property
    def total(self) -> int:
        """Rows of the whole horizon, padded."""
        return -(-self.N * self.rows // LANES) * LANES

    @property
    def gains(self) -> int:
        """Numbers that the elimination of one stage's inputs leaves: pivots, gains, feed-forward."""
        return sum(self.nx + self.nu - p for p in range(self.nu)) + self.nu


def _as_data(pattern: Bools) -> Mat:
    """Numbers that are neither zero nor one where the pattern is true."""
    return np.where(pattern, 2.0, 0.0)


def data(M: Matrix) -> list[tuple[int, int]]:
    """Where the non-zeros of M are that are run-time data, in the order in which they are stored."""
    return sorted(position for position, symbol in M.items() if symbol)


def values(M: Matrix, numbers: Mat) -> Vec:
    """(…, number of data) the run-time data of a sparse matrix, of numbers (…, rows, columns)."""
    positions = data(M)
    i, j = [p[0] for p in positions], [p[1] for p in positions]
    return np.asarray(numbers[..., i, j])


def parts(s: Structure) -> dict[str, tuple[int, ...]]:
    """Shape of every part, in order. Those up to VARYING are the problem's numbers that must be finite."""
    N, nx, nu, total, weighted = s.N, s.nx, s.nu, s.total, len(s.weighted)
    problem = {
        "START": (nx,),  # x_0
        "DYNAMICS": (len(data(s.A)) + len(data(s.B)),),
        "CONSTANT": (len(data(s.C)),),
        "CONTROL_WEIGHT": (nu,),
        "OUTPUT": (N, len(s.D)),
        "ERROR": (N, s.ny),
        "STATE_WEIGHT": (N, weighted),
        "STATE_LINEAR": (N, weighted),
        "INPUT_LINEAR": (N, nu),
        "VARYING": (N, len(s.V)),
    }
    of_rows = (
        "LOWER UPPER SOFT "  # bounds as given; penalty w
        "LO HI RHO "  # bounds as used (finite); weight of the augmented Lagrangian
        "VALUE MULTIPLIER SET "  # r, y and σ: 0 free, ±1 active, ±2 saturated (soft, |y| = w)
        "DIAGONAL GRADIENT MARK"  # what the rows add to the stages' Hessian and gradient; scratch
    )
    of_sides = (
        "DISTANCE T LAMBDA SIGMA NU INV_LAMBDA INV_NU DELTA E1 E2 SCRATCH"  # interior point: 2 sides a row
    )
    own = {
        "U": (N, nu),
        "X": (N, nx),
        "PLAN": (N, nu),  # last certified inputs
        "GAIN": (N, s.gains),
        "COST_TO_GO": (N, nx * (nx + 1) // 2),  # P of the stage after
        "COSTATE": (nx,),
        "ACCUMULATOR": (2 * LANES,),
        "SETTING": (8,),
        "INFO": (8,),
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
    """The vector itself, on a cache line, and a view of every part."""

    def __init__(self, structure: Structure) -> None:
        at, size = offsets(structure)
        room = np.zeros(size + _LINE)
        shift = (-room.ctypes.data // room.itemsize) % _LINE
        self.vector: Vec = room[shift : shift + size]
        self._structure = structure
        self._views = {
            name: self.vector[at[name] : at[name] + prod(shape)].reshape(shape)
            for name, shape in parts(structure).items()
        }

    def __getitem__(self, part: str) -> Mat:
        """View of a part in its own shape."""
        return self._views[part]

    def rows(self, part: str) -> Mat:
        """View (N, rows) of a part that holds one number per row, without its padding."""
        s = self._structure
        return self._views[part][: s.N * s.rows].reshape(s.N, s.rows)
