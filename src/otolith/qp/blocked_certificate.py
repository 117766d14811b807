"""The certificate of a blocked problem, compiled: from the memory of an engine and the answer alone.

It is `otolith.qp.stage.stage_residual` with inputs held over blocks: the states follow from the inputs step
by step, the gradient by costates backwards. Nothing is shared with an engine that eliminates the states. A
test checks that both find the same. The arithmetic is strict, and every test is written to accept, so that a
NaN never passes.
"""

from typing import Final, NamedTuple, Self

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec, firsts
from otolith.core.jit import jit_inner, kernel
from otolith.qp.blocked import Lengths, block_ends
from otolith.qp.engines import StageMemory
from otolith.qp.stage import StageProblem

HUGE: Final = 1e300  # larger than any number that is judged


class Sparse(NamedTuple):
    """A matrix by its non-zero entries, row after row."""

    first: Ints  # (rows + 1,) number of entries before each row
    columns: Ints  # (entries,)
    values: Vec  # (entries,)

    @classmethod
    def of(cls, matrix: Mat) -> Self:
        """Return the entries of a matrix."""
        there = matrix != 0.0
        return cls(firsts(there), np.argwhere(there)[:, 1], np.array(matrix[there]))


class Judged(NamedTuple):
    """The constant part of a problem: N steps, M blocks, nx states, nu inputs."""

    A: Sparse  # an axis moves by itself, so most entries are zero
    back: Sparse  # Aᵀ
    B: Sparse
    into: Sparse  # Bᵀ
    C: Sparse
    states: int  # nx
    first_output: Ints  # (ny + 1,) number of non-zeros of `output` before each of its rows …
    outputs: Ints  # … and their states
    first_varying: Ints  # the same of `varying`
    varying: Ints
    weighted: Ints  # states that have a weight
    control_weight: Mat  # (M, nu), summed over the steps of a block
    penalty: Mat  # (M, rows)
    ends: Ints  # (M,) last step of every block

    @classmethod
    def of(cls, problem: StageProblem, lengths: Lengths) -> Self:
        """Return the numbers of one problem."""
        return cls(
            A=Sparse.of(problem.A),
            back=Sparse.of(problem.A.T),
            B=Sparse.of(problem.B),
            into=Sparse.of(problem.B.T),
            C=Sparse.of(problem.C),
            states=problem.states,
            first_output=firsts(problem.output),
            outputs=np.argwhere(problem.output)[:, 1],
            first_varying=firsts(problem.varying),
            varying=np.argwhere(problem.varying)[:, 1],
            weighted=np.array(problem.weighted, dtype=np.int64),
            control_weight=np.outer(lengths, problem.control_weight),
            penalty=problem.penalty[block_ends(lengths)],
            ends=block_ends(lengths),
        )


@jit_inner
def _product(first: Ints, columns: Ints, values: Vec, row: int, x: Vec) -> float:
    """Return the product of a sparse row with x. A sum in a register takes half the time of one in memory."""
    total = 0.0
    for s in range(first[row], first[row + 1]):
        total += values[s] * x[columns[s]]
    return total


@jit_inner
def _times(matrix: Sparse, x: Vec, out: Vec) -> None:
    """Write the product of a matrix with x."""
    for row in range(len(out)):
        out[row] = _product(matrix.first, matrix.columns, matrix.values, row, x)


@jit_inner
def _add_times(matrix: Sparse, x: Vec, out: Vec) -> None:
    """Add the product of a matrix with x."""
    for row in range(len(out)):
        out[row] += _product(matrix.first, matrix.columns, matrix.values, row, x)


@jit_inner
def _add_sizes(matrix: Sparse, sizes: Vec, out: Vec) -> None:
    """Add the product of a matrix's absolute values with sizes."""
    for row in range(len(out)):
        total = 0.0
        for s in range(matrix.first[row], matrix.first[row + 1]):
            total += abs(matrix.values[s]) * sizes[matrix.columns[s]]
        out[row] += total


@jit_inner
def _roll_out(of: Judged, start: Vec, U: Mat, pushed: Vec, X: Mat) -> None:
    """Write the states X (N, nx) after every step; `pushed` is memory (nx,) for what a block's inputs add."""
    k = 0
    for m in range(len(of.ends)):
        _times(of.B, U[m], pushed)
        while k <= of.ends[m]:
            _times(of.A, start if k == 0 else X[k - 1], X[k])
            for i in range(len(pushed)):
                X[k, i] += pushed[i]
            k += 1


@jit_inner
def _rows_of(of: Judged, memory: StageMemory, X: Mat, U: Mat, r: Mat) -> None:
    """Write the values r (M, rows) of all rows."""
    nc, nv, nu = len(of.C.first) - 1, len(of.first_varying) - 1, U.shape[1]
    for m in range(len(of.ends)):
        x = X[of.ends[m]]
        _times(of.C, x, r[m, :nc])
        for v in range(nv):
            r[m, nc + v] = _product(of.first_varying, of.varying, memory.varying[m], v, x)
        for j in range(nu):
            r[m, nc + nv + j] = U[m, j]


@jit_inner
def _by_state(of: Judged, memory: StageMemory, k: int, x: Vec, slope: Vec, terms: Vec) -> None:
    """Write the derivative of one step's cost by its state (nx,), and the sum of its terms' sizes."""
    slope[:] = 0.0
    terms[:] = 0.0
    D = memory.output[k]
    for c in range(len(of.first_output) - 1):
        error = memory.error[k, c] + _product(of.first_output, of.outputs, D, c, x)
        for s in range(of.first_output[c], of.first_output[c + 1]):
            value = D[s] * error
            slope[of.outputs[s]] += value
            terms[of.outputs[s]] += abs(value)
    for w in range(len(of.weighted)):
        i = of.weighted[w]
        value, linear = memory.state_weight[k, w] * x[i], memory.state_linear[k, w]
        slope[i] += value + linear
        terms[i] += abs(value) + abs(linear)


@jit_inner
def _add_row(first: Ints, columns: Ints, values: Vec, row: int, y: float, slope: Vec, terms: Vec) -> None:
    """Add what the multiplier of one row contributes."""
    if y == 0.0:  # as most are; a NaN is not
        return
    for s in range(first[row], first[row + 1]):
        value = y * values[s]
        slope[columns[s]] += value
        terms[columns[s]] += abs(value)


@jit_inner
def _add_rows(of: Judged, memory: StageMemory, m: int, y: Mat, slope: Vec, terms: Vec) -> None:
    """Add what the multipliers of a block's rows contribute."""
    C, nc = of.C, len(of.C.first) - 1
    for c in range(nc):
        _add_row(C.first, C.columns, C.values, c, y[m, c], slope, terms)
    for v in range(len(of.first_varying) - 1):
        _add_row(of.first_varying, of.varying, memory.varying[m], v, y[m, nc + v], slope, terms)


@jit_inner
def _gradient(
    of: Judged, memory: StageMemory, X: Mat, U: Mat, y: Mat, work: Mat, total: Mat, sizes: Mat
) -> None:
    """Write the gradient of the Lagrangian by the inputs (M, nu), and the sums of its terms' sizes.

    An input acts alike on all steps of its block, so their costates are summed before B takes them over.
    `work` is memory (6, nx).
    """
    nx, nu = X.shape[1], U.shape[1]
    first_input = y.shape[1] - nu
    slope, terms, s, after, of_block, size_of_block = work[0], work[1], work[2], work[3], work[4], work[5]
    s[:] = 0.0
    for m in range(len(U) - 1, -1, -1):
        of_block[:] = 0.0
        size_of_block[:] = 0.0
        for k in range(of.ends[m], of.ends[m - 1] if m > 0 else -1, -1):
            _by_state(of, memory, k, X[k], slope, terms)
            if k == of.ends[m]:
                _add_rows(of, memory, m, y, slope, terms)
            for i in range(nx):
                size_of_block[i] += terms[i] + abs(s[i])
                after[i] = s[i] + slope[i]
                of_block[i] += after[i]
            _times(of.back, after, s)
        for j in range(nu):
            own, linear = of.control_weight[m, j] * U[m, j], memory.input_linear[m, j]
            row = y[m, first_input + j]
            total[m, j] = own + linear + row
            sizes[m, j] = abs(own) + abs(linear) + abs(row)
        _add_times(of.into, of_block, total[m])
        _add_sizes(of.into, size_of_block, sizes[m])


@jit_inner
def _row_error(r: float, low: float, high: float, w: float, y: float, reach: float, whole: float) -> float:
    """Return the error of one row, as `otolith.qp.relative.row_residual`."""
    above, below = r - high, low - r
    violation = max(above, below)
    size = reach + (abs(high) if above > below else abs(low))
    violation = violation / size if violation > 0.0 else 0.0
    idle = 0.0
    if y != 0.0:
        if not abs(high if y > 0.0 else low) < np.inf:  # a multiplier on a side without a bound
            return np.inf
        size = reach + (abs(high) if y > 0.0 else abs(low))
        gap = max(-above if y > 0.0 else -below, 0.0)
        idle = min(gap / size if gap > 0.0 else 0.0, abs(y) * size / whole)
    if w == np.inf:
        return max(idle, violation)
    unpaid = min(violation, abs(w - (y if above > 0.0 else -y)) / w)
    return max(idle, max(unpaid, (abs(y) - w) / w))


@kernel
def blocked_residual(of: Judged, memory: StageMemory, U: Mat, y: Mat) -> float:
    """Return how far an answer (M, nu), (M, rows) is from optimal; infinite if a number is not finite."""
    X, r = np.empty((len(memory.error), of.states)), np.empty(y.shape)
    total, sizes, worst, accepted = np.empty(U.shape), np.empty(U.shape), 0.0, 0
    work = np.empty((6, of.states))
    _roll_out(of, memory.start, U, work[0], X)
    _rows_of(of, memory, X, U, r)
    _gradient(of, memory, X, U, y, work, total, sizes)
    whole = 0.0
    for j in range(U.shape[1]):
        largest, moved = 0.0, 0.0
        for m in range(len(U)):
            largest, moved = max(largest, sizes[m, j]), max(moved, abs(U[m, j]))
        whole += largest * moved
        for m in range(len(U)):
            error = abs(total[m, j]) / largest if total[m, j] != 0.0 else 0.0
            accepted += error < HUGE
            worst = max(worst, error)
    for i in range(y.shape[1]):
        reach = 0.0
        for m in range(len(U)):
            reach = max(reach, abs(r[m, i]))
        for m in range(len(U)):
            low, high = memory.lower[m, i], memory.upper[m, i]
            error = _row_error(r[m, i], low, high, of.penalty[m, i], y[m, i], reach, whole)
            accepted += error < HUGE and abs(r[m, i]) < HUGE and abs(y[m, i]) < HUGE
            worst = max(worst, error)
    return worst if accepted == U.size + y.size else np.inf
