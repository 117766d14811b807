"""A blocked problem in its inputs alone, made in one compiled pass; constants are prepared once.

Inside a block the states are linear in those at its start and in its own input, x_k = F_l (x_s, u_m) after l
steps, with few non-zeros where every axis moves by itself. So the cost of a block is a quadratic in these few
*local* variables, summed step by step, and only this sum is carried over to the inputs of all blocks. That
takes a fifth of the products that every step by all inputs would.

Notation: N steps, M blocks, nx states, nu inputs, n = M·nu; L = nx + nu local variables; D_k, e_k outputs and
errors as in `otolith.qp.stage`. The cost of block m is ½ ξᵀ W ξ + wᵀ ξ, with ξ = (x_s, u_m), W = Σ F_lᵀ
(D_kᵀ D_k + diag W_k) F_l and w = Σ F_lᵀ (D_kᵀ e_k + p_k). With x_s = f_s + Γ_s U, where f_s is the state
without inputs, the Hessian is Σ_m Γ̃ᵀ W Γ̃, Γ̃ = (Γ_s, own input).
"""

from typing import NamedTuple, Self

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.jit import jit_fused
from otolith.qp.blocked import Lengths
from otolith.qp.engines import StageMemory
from otolith.qp.stage import StageProblem


class Dynamics(NamedTuple):
    """What inputs and states do to later states; constant."""

    lengths: Ints  # (M,) steps of every block
    counts: Ints  # (nx,) number of local variables on which a state depends …
    columns: Ints  # (nx, c) and which
    gain: Mat  # (longest block, nx, c) their coefficients: the non-zeros of F_1, F_2, …
    moved: Ints  # (n,) number of states that an input moves …
    states: Ints  # (n, s) and which
    response: Mat  # (M + 1, n, s) by how much, Γ_s, at the start of every block and at the horizon's end

    @classmethod
    def of(cls, problem: StageProblem, lengths: Lengths) -> Self:
        """Return the dynamics of a problem with blocks of these lengths."""
        nx, nu = problem.B.shape
        local = np.zeros((max(lengths), nx, nx + nu))
        after = np.eye(nx, nx + nu)
        for step in range(max(lengths)):
            after = problem.A @ after
            after[:, nx:] += problem.B
            local[step] = after
        response = np.zeros((len(lengths) + 1, nx, len(lengths) * nu))
        for m, length in enumerate(lengths):
            whole = local[length - 1]
            response[m + 1] = whole[:, :nx] @ response[m]
            response[m + 1, :, m * nu : (m + 1) * nu] = whole[:, nx:]
        counts, columns = _listed(np.abs(local).max(axis=0) > 0.0)
        gain = np.take_along_axis(local, np.broadcast_to(columns, (len(local), *columns.shape)), axis=2)
        by_input = response.transpose(0, 2, 1)
        moved, states = _listed(np.abs(by_input).max(axis=0) > 0.0)
        response = np.take_along_axis(by_input, np.broadcast_to(states, (len(response), *states.shape)), 2)
        response *= np.arange(states.shape[1]) < moved[:, None]
        return cls(np.array(lengths), counts, columns, np.ascontiguousarray(gain), moved, states, response)

    def dense(self, nx: int) -> Mat:
        """Return Γ_s (M + 1, nx, n) with its zeros."""
        found = np.zeros((len(self.response), len(self.moved), nx))
        for column, (number, states) in enumerate(zip(self.moved, self.states, strict=True)):
            found[:, column, states[:number]] = self.response[:, column, :number]
        return found.transpose(0, 2, 1)


def _listed(structure: "np.typing.NDArray[np.bool_]") -> tuple[Ints, Ints]:
    """Return for each row the number of its true entries, and where they are, padded with zeros."""
    counts = structure.sum(axis=1).astype(np.int64)
    places = np.zeros((len(structure), max(1, int(counts.max(initial=0)))), dtype=np.int64)
    for row, found in zip(places, structure, strict=True):
        where = np.flatnonzero(found)
        row[: len(where)] = where
    return counts, places


class Layout(NamedTuple):
    """Where the numbers of a memory belong, and the constant rows."""

    outputs: Ints  # (non-zeros, 2) output and state of the numbers in `memory.output`
    felt: Ints  # (f,) local variables on which outputs depend …
    slot: Ints  # (L,) and for each local variable its place among these
    varying: Ints  # (non-zeros, 2) row and state of the numbers in `memory.varying`
    first_varying: int  # number of constant rows, in front of the varying ones
    constant: Ints  # (non-zeros of C, 2) row and state
    coefficients: Vec  # (non-zeros of C,)
    weighted: Ints  # states that have a weight
    control: Vec  # (n,) weights of the inputs, summed over the steps of a block


class Condensed(NamedTuple):
    """The problem in the inputs alone, and working memory."""

    H: Mat  # (n, n)
    g: Vec  # (n,)
    R: Mat  # (M·rows, n)
    lower: Vec  # (M·rows,)
    upper: Vec  # (M·rows,)
    weights: Mat  # (N, weighted) weights on states for which `base` was made; NaN at first
    base: Mat  # (M, L, L) what they contribute to W
    W: Mat  # (L, L)
    w: Vec  # (L,)
    D: Mat  # (f, ny·longest block) outputs of a block's steps by the local variables that they depend on
    P: Mat  # (n, L) Γ̃ᵀ W
    row: Vec  # (nx,) of the states
    free: Mat  # (M + 1, nx) states without inputs at the start of every block, and at the end


def layout_of(problem: StageProblem, lengths: Lengths, dynamics: Dynamics) -> Layout:
    """Return the layout of a problem's memory."""
    constant, nx = np.argwhere(problem.C != 0.0), problem.states
    felt = np.zeros(nx + problem.inputs, dtype=bool)
    for state in np.flatnonzero(problem.output.any(axis=0)):
        felt[dynamics.columns[state, : dynamics.counts[state]]] = True
    return Layout(
        outputs=np.argwhere(problem.output),
        felt=np.flatnonzero(felt),
        slot=np.cumsum(felt) - 1,
        varying=np.argwhere(problem.varying),
        first_varying=len(problem.C),
        constant=constant,
        coefficients=np.array(problem.C[problem.C != 0.0]),
        weighted=np.array(problem.weighted, dtype=np.int64),
        control=np.outer(lengths, problem.control_weight).ravel(),
    )


def empty_condensed(problem: StageProblem, dynamics: Dynamics) -> Condensed:
    """Allocate the condensed problem, with the rows that do not change."""
    M, (nx, nu), nc = len(dynamics.lengths), problem.B.shape, len(problem.C)
    n, L, rows = M * nu, nx + nu, problem.rows
    R = np.zeros((M, rows, n))
    R[:, :nc] = problem.C @ dynamics.dense(nx)[1:]
    R[:, rows - nu :] = np.eye(n).reshape(M, nu, n)
    return Condensed(
        H=np.zeros((n, n)),
        g=np.zeros(n),
        R=R.reshape(M * rows, n),
        lower=np.zeros(M * rows),
        upper=np.zeros(M * rows),
        weights=np.full((problem.horizon, len(problem.weighted)), np.nan),
        base=np.zeros((M, L, L)),
        W=np.zeros((L, L)),
        w=np.zeros(L),
        D=np.zeros((L, len(problem.output) * int(dynamics.lengths.max()))),
        P=np.zeros((n, L)),
        row=np.zeros(nx),
        free=np.zeros((M + 1, nx)),
    )


@jit_fused
def _weigh(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed) -> None:
    """Write what the weights on states contribute to W, if these have changed."""
    same = True
    for k in range(len(to.weights)):
        for s in range(len(layout.weighted)):
            same = same and memory.state_weight[k, s] == to.weights[k, s]
    if same:
        return
    to.base[:] = 0.0
    k = 0
    for m in range(len(of.lengths)):
        for step in range(of.lengths[m]):
            for s in range(len(layout.weighted)):
                i, weight = layout.weighted[s], memory.state_weight[k, s]
                to.weights[k, s] = weight
                for a in range(of.counts[i]):
                    value = weight * of.gain[step, i, a]
                    for b in range(of.counts[i]):
                        to.base[m, of.columns[i, a], of.columns[i, b]] += value * of.gain[step, i, b]
            k += 1


@jit_fused
def _dot(a: Vec, b: Vec, n: int) -> float:
    total = 0.0
    for i in range(n):
        total += a[i] * b[i]
    return total


@jit_fused
def _dot_from(a: Vec, b: Vec, first: int, n: int) -> float:
    total = 0.0
    for i in range(n):
        total += a[i] * b[first + i]
    return total


@jit_fused
def _add_steps(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed, m: int, first: int) -> None:
    """Add what the steps of block m, from the `first` on, contribute to W and w."""
    D, ny = to.D, memory.error.shape[1]
    number, length = len(layout.felt), of.lengths[m] * ny
    for a in range(number):
        for c in range(length):
            D[a, c] = 0.0
    for step in range(of.lengths[m]):
        for s in range(len(layout.outputs)):
            i, value, at = (
                layout.outputs[s, 1],
                memory.output[first + step, s],
                step * ny + layout.outputs[s, 0],
            )
            for a in range(of.counts[i]):
                D[layout.slot[of.columns[i, a]], at] += value * of.gain[step, i, a]
    errors = memory.error.reshape(-1)
    for a in range(number):
        i = layout.felt[a]
        to.w[i] += _dot_from(D[a], errors, first * ny, length)
        for b in range(a + 1):
            j, value = layout.felt[b], _dot(D[a], D[b], length)
            to.W[i, j] += value
            if j != i:
                to.W[j, i] += value


@jit_fused
def _add_linear(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed, m: int, first: int) -> None:
    """Add what the linear terms of the weighted states contribute to w."""
    for step in range(of.lengths[m]):
        for s in range(len(layout.weighted)):
            i, linear = layout.weighted[s], memory.state_linear[first + step, s]
            if linear != 0.0:
                for a in range(of.counts[i]):
                    to.w[of.columns[i, a]] += linear * of.gain[step, i, a]


@jit_fused
def _carry_over(of: Dynamics, to: Condensed, m: int) -> None:
    """Add the cost of block m, in its local variables, to that in the inputs of all blocks."""
    nx, L = to.free.shape[1], len(to.w)
    nu, before = L - nx, m * (L - nx)
    P, G = to.P, of.response[m]
    for a in range(L):
        to.w[a] += _dot(to.W[a], to.free[m], nx)
    for column in range(before):
        for a in range(L):
            P[column, a] = 0.0
        for t in range(of.moved[column]):
            i, value = of.states[column, t], G[column, t]
            to.g[column] += value * to.w[i]
            for a in range(L):
                P[column, a] += value * to.W[i, a]
    for j in range(nu):
        to.g[before + j] += to.w[nx + j]
        for a in range(L):
            P[before + j, a] = to.W[nx + j, a]
    for column in range(before + nu):
        for other in range(min(column + 1, before)):
            to.H[column, other] += _by_input(of, G, other, P[column])
        for j in range(column + 1 - before):
            to.H[column, before + j] += P[column, nx + j]


@jit_fused
def _by_input(of: Dynamics, G: Mat, column: int, row: Vec) -> float:
    """Return how a row (nx,) of the states changes with an input, given how that moves the states (n, s)."""
    total = 0.0
    for t in range(of.moved[column]):
        total += row[of.states[column, t]] * G[column, t]
    return total


@jit_fused
def _move_free(of: Dynamics, to: Condensed, m: int) -> None:
    """Write the states without inputs at the end of block m."""
    nx, last = to.free.shape[1], of.lengths[m] - 1
    for i in range(nx):
        total = 0.0
        for a in range(of.counts[i]):
            if of.columns[i, a] < nx:
                total += of.gain[last, i, a] * to.free[m, of.columns[i, a]]
        to.free[m + 1, i] = total


@jit_fused
def _rows(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed, m: int) -> None:
    """Write the rows at the end of block m and their bounds."""
    rows, nu = memory.lower.shape[1], len(to.w) - to.free.shape[1]
    first, G, x = m * rows, of.response[m + 1], to.free[m + 1]
    for r in range(rows):
        to.lower[first + r], to.upper[first + r] = memory.lower[m, r], memory.upper[m, r]
    for s in range(len(layout.constant)):
        r, value = first + layout.constant[s, 0], layout.coefficients[s] * x[layout.constant[s, 1]]
        to.lower[r] -= value
        to.upper[r] -= value
    s, behind = 0, len(layout.varying)
    while s < behind:
        r = first + layout.first_varying + layout.varying[s, 0]
        to.row[:] = 0.0
        while True:
            i = layout.varying[s, 1]
            to.row[i] = memory.varying[m, s]
            s += 1
            if s == behind or layout.varying[s, 0] != layout.varying[s - 1, 0]:
                break
        value = _dot(to.row, x, len(x))
        to.lower[r] -= value
        to.upper[r] -= value
        for column in range((m + 1) * nu):
            to.R[r, column] = _by_input(of, G, column, to.row)


@jit_fused
def condense(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed) -> None:
    """Write the problem in memory as one in the inputs alone."""
    _weigh(of, layout, memory, to)
    nu = memory.input_linear.shape[1]
    to.H[:] = 0.0
    for m in range(len(of.lengths)):
        for j in range(nu):
            to.g[m * nu + j] = memory.input_linear[m, j]
            to.H[m * nu + j, m * nu + j] = layout.control[m * nu + j]
    for i in range(len(memory.start)):
        to.free[0, i] = memory.start[i]
    k = 0
    for m in range(len(of.lengths)):
        for i in range(len(to.W)):
            copy_to(to.W[i], to.base[m, i])
        to.w[:] = 0.0
        _add_steps(of, layout, memory, to, m, k)
        _add_linear(of, layout, memory, to, m, k)
        k += of.lengths[m]
        _carry_over(of, to, m)
        _move_free(of, to, m)
        _rows(of, layout, memory, to, m)
    for i in range(len(to.g)):
        for j in range(i):
            to.H[j, i] = to.H[i, j]
