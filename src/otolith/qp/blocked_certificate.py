"""The certificate of a blocked problem, compiled: from the memory of an engine and the answer alone.

It is `otolith.qp.stage.stage_residual` with inputs held over blocks: the states follow from the inputs step
by step, the gradient by costates backwards. Nothing is shared with an engine that eliminates the states. A
test checks that both find the same. The arithmetic is strict, and every test is written to accept, so that a
NaN never passes.
"""

from typing import Final, NamedTuple, Self

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import kernel
from otolith.qp.blocked import Lengths, block_ends
from otolith.qp.engines import StageMemory
from otolith.qp.stage import StageProblem

HUGE: Final = 1e300  # larger than any number that is judged


class Entries(NamedTuple):
    """The non-zero entries of a matrix."""

    at: Ints  # (entries, 2) row and column
    values: Vec  # (entries,)

    @classmethod
    def of(cls, matrix: Mat) -> Self:
        """Return those of a matrix."""
        return cls(np.argwhere(matrix != 0.0), np.array(matrix[matrix != 0.0]))


class Judged(NamedTuple):
    """The constant part of a problem: N steps, M blocks, nx states, nu inputs."""

    A: Entries  # an axis moves by itself, so most are zero
    B: Entries
    C: Entries
    states: int  # nx
    constant: int  # nc, number of rows of C
    outputs: Ints  # (non-zeros, 2) output and state of the numbers in a memory's `output`
    varying: Ints  # (non-zeros, 2) row and state of the numbers in its `varying`
    weighted: Ints  # states that have a weight
    control_weight: Mat  # (M, nu), summed over the steps of a block
    penalty: Mat  # (M, rows)
    ends: Ints  # (M,) last step of every block

    @classmethod
    def of(cls, problem: StageProblem, lengths: Lengths) -> Self:
        """Return the numbers of one problem."""
        return cls(
            A=Entries.of(problem.A),
            B=Entries.of(problem.B),
            C=Entries.of(problem.C),
            states=problem.states,
            constant=len(problem.C),
            outputs=np.argwhere(problem.output),
            varying=np.argwhere(problem.varying),
            weighted=np.array(problem.weighted, dtype=np.int64),
            control_weight=np.outer(lengths, problem.control_weight),
            penalty=problem.penalty[block_ends(lengths)],
            ends=block_ends(lengths),
        )


@kernel
def _roll_out(of: Judged, start: Vec, U: Mat, X: Mat) -> None:
    """Write the states X (N, nx) after every step."""
    block = 0
    for k in range(len(X)):
        block += k > of.ends[block]
        before = start if k == 0 else X[k - 1]
        X[k, :] = 0.0
        for s in range(len(of.A.values)):
            i, j, value = of.A.at[s, 0], of.A.at[s, 1], of.A.values[s]
            X[k, i] += value * before[j]
        for s in range(len(of.B.values)):
            i, j, value = of.B.at[s, 0], of.B.at[s, 1], of.B.values[s]
            X[k, i] += value * U[block, j]


@kernel
def _rows_of(of: Judged, memory: StageMemory, X: Mat, U: Mat, r: Mat) -> None:
    """Write the values r (M, rows) of all rows."""
    nc, nu = of.constant, U.shape[1]
    for m in range(len(of.ends)):
        x = X[of.ends[m]]
        r[m, :] = 0.0
        for s in range(len(of.C.values)):
            c, i, value = of.C.at[s, 0], of.C.at[s, 1], of.C.values[s]
            r[m, c] += value * x[i]
        for s in range(len(of.varying)):
            r[m, nc + of.varying[s, 0]] += memory.varying[m, s] * x[of.varying[s, 1]]
        for j in range(nu):
            r[m, r.shape[1] - nu + j] = U[m, j]


@kernel
def _by_state(of: Judged, memory: StageMemory, k: int, x: Vec, error: Vec, slope: Vec, terms: Vec) -> None:
    """Write the derivative of one step's cost by its state (nx,), and the sum of its terms' sizes.

    `error` (ny,) is working memory.
    """
    ny = memory.error.shape[1]
    slope[:], terms[:] = 0.0, 0.0
    for c in range(ny):
        error[c] = memory.error[k, c]
    for s in range(len(of.outputs)):
        error[of.outputs[s, 0]] += memory.output[k, s] * x[of.outputs[s, 1]]
    for s in range(len(of.outputs)):
        value = memory.output[k, s] * error[of.outputs[s, 0]]
        slope[of.outputs[s, 1]] += value
        terms[of.outputs[s, 1]] += abs(value)
    for w in range(len(of.weighted)):
        i = of.weighted[w]
        value, linear = memory.state_weight[k, w] * x[i], memory.state_linear[k, w]
        slope[i] += value + linear
        terms[i] += abs(value) + abs(linear)


@kernel
def _add_rows(of: Judged, memory: StageMemory, m: int, y: Mat, slope: Vec, terms: Vec) -> None:
    """Add what the multipliers of a block's rows contribute."""
    nc = of.constant
    for s in range(len(of.C.values)):
        c, i, entry = of.C.at[s, 0], of.C.at[s, 1], of.C.values[s]
        value = y[m, c] * entry
        slope[i] += value
        terms[i] += abs(value)
    for s in range(len(of.varying)):
        value = y[m, nc + of.varying[s, 0]] * memory.varying[m, s]
        slope[of.varying[s, 1]] += value
        terms[of.varying[s, 1]] += abs(value)


@kernel
def _gradient(of: Judged, memory: StageMemory, X: Mat, U: Mat, y: Mat, total: Mat, sizes: Mat) -> None:
    """Write the gradient of the Lagrangian by the inputs (M, nu), and the sums of its terms' sizes."""
    nx, nu = X.shape[1], U.shape[1]
    first_input = y.shape[1] - nu
    for m in range(len(U)):
        for j in range(nu):
            own, linear = of.control_weight[m, j] * U[m, j], memory.input_linear[m, j]
            row = y[m, first_input + j]
            total[m, j] = own + linear + row
            sizes[m, j] = abs(own) + abs(linear) + abs(row)
    s, after, slope, terms, m = np.zeros(nx), np.empty(nx), np.empty(nx), np.empty(nx), len(U) - 1
    error = np.empty(memory.error.shape[1])
    for k in range(len(X) - 1, -1, -1):
        _by_state(of, memory, k, X[k], error, slope, terms)
        if k == of.ends[m]:
            _add_rows(of, memory, m, y, slope, terms)
        for e in range(len(of.B.values)):
            i, j, value = of.B.at[e, 0], of.B.at[e, 1], of.B.values[e]
            sizes[m, j] += abs(value) * (terms[i] + abs(s[i]))
        for i in range(nx):
            s[i] += slope[i]
            after[i] = 0.0
        for e in range(len(of.B.values)):
            i, j, value = of.B.at[e, 0], of.B.at[e, 1], of.B.values[e]
            total[m, j] += value * s[i]
        for e in range(len(of.A.values)):
            i, j, value = of.A.at[e, 0], of.A.at[e, 1], of.A.values[e]
            after[j] += value * s[i]
        for i in range(nx):
            s[i] = after[i]
        if m > 0 and k == of.ends[m - 1] + 1:
            m -= 1


@kernel
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
    _roll_out(of, memory.start, U, X)
    _rows_of(of, memory, X, U, r)
    _gradient(of, memory, X, U, y, total, sizes)
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
