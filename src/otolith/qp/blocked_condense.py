"""A blocked problem in its inputs alone, made in one compiled pass; constants are prepared once.

Inside a block the states are linear in those at its start and in its own input, x_k = F_l (x_s, u_m) after l
steps, with few non-zeros where every axis moves by itself. So the cost of a block is a quadratic in these few
*local* variables, summed step by step. From the last block backwards, what all later blocks cost is carried
as a quadratic in the states at their start, as in a Riccati recursion that does not decide.

Notation: N steps, M blocks, nx states, nu inputs, n = M·nu; L = nx + nu local variables ξ = (x_s, u_m); D_k,
e_k outputs and errors as in `otolith.qp.stage`; f_s states without inputs, x_s = f_s + Γ_s U. The cost of
block m alone is ½ ξᵀ W ξ + wᵀ ξ, with W = Σ F_lᵀ (D_kᵀ D_k + diag W_k) F_l and w = Σ F_lᵀ (D_kᵀ e_k + p_k).
With S and s, Hessian and gradient of what follows by the states at its end, W + Fᵀ S F and w + W ξ + Fᵀ s at
ξ = (f_s, 0) are those of both together. Their parts in x_s are S and s for the block before; those in u_m,
with Γ_s for x_s, are rows of the Hessian and entries of the gradient of the whole problem.
"""

from typing import Final, NamedTuple, Self

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.jit import jit_fused, jit_inner_fused
from otolith.qp.blocked import Lengths, block_ends
from otolith.qp.engines import StageMemory
from otolith.qp.stage import StageProblem
from otolith.qp.working_set import Rows, dot, empty_rows, whole_turns

TOGETHER: Final = 4  # rows by which two others are multiplied in one pass


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

    felt: Ints  # (f,) local variables on which outputs depend
    # (E, 3) for every non-zero of D_k and local variable of its state: index in `memory.output`, place of the
    # variable in `felt`, and output …
    spread: Ints
    share: Mat  # (E, longest block) … and by how much that state depends on that variable
    varying: Ints  # (non-zeros, 2) row and state of the numbers in `memory.varying`
    first_varying: int  # number of constant rows, in front of the varying ones
    constant: Ints  # (non-zeros of C, 2) row and state
    coefficients: Vec  # (non-zeros of C,)
    weighted: Ints  # states that have a weight
    control: Vec  # (n,) weights of the inputs, summed over the steps of a block


class Condensed(NamedTuple):
    """The problem in the inputs alone, and working memory."""

    H: Mat  # (n, n), of which the lower triangle is written
    g: Vec  # (n,)
    rows: Rows
    weights: Mat  # (N, weighted) weights on states for which `base` was made; NaN at first
    base: Mat  # (M, L, L) what they contribute to W
    W: Mat  # (L, L)
    w: Vec  # (L,)
    S: Mat  # (nx, nx)
    s: Vec  # (nx,)
    half: Mat  # (2, L·nx) Fᵀ S and its transpose
    outputs: Mat  # (non-zeros, longest block) a block's `memory.output`, by step
    errors: Vec  # (ny·longest block,) its errors, output after output
    D: Mat  # (≥ f, ≥ ny·longest block) their slopes by the local variables `felt`
    products: Mat  # (≥ f, ≥ f) of rows of D; those above the diagonal are not all written
    by_state: Mat  # (nx, nv) a block's varying rows
    free: Mat  # (M + 1, nx) states without inputs at the start of every block, and at the end


def layout_of(problem: StageProblem, lengths: Lengths, dynamics: Dynamics) -> Layout:
    """Return the layout of a problem's memory."""
    constant, nx = np.argwhere(problem.C != 0.0), problem.states
    felt = np.zeros(nx + problem.inputs, dtype=bool)
    for state in np.flatnonzero(problem.output.any(axis=0)):
        felt[dynamics.columns[state, : dynamics.counts[state]]] = True
    slot = np.cumsum(felt) - 1
    spread, share = [], []
    for s, (output, state) in enumerate(np.argwhere(problem.output)):
        for a in range(dynamics.counts[state]):
            spread.append((s, slot[dynamics.columns[state, a]], output))
            share.append(dynamics.gain[:, state, a])
    return Layout(
        felt=np.flatnonzero(felt),
        spread=np.array(spread, dtype=np.int64).reshape(-1, 3),
        share=np.array(share).reshape(-1, max(lengths)),
        varying=np.argwhere(problem.varying),
        first_varying=len(problem.C),
        constant=constant,
        coefficients=np.array(problem.C[problem.C != 0.0]),
        weighted=np.array(problem.weighted, dtype=np.int64),
        control=np.outer(lengths, problem.control_weight).ravel(),
    )


def empty_condensed(problem: StageProblem, lengths: Lengths, dynamics: Dynamics) -> Condensed:
    """Allocate the condensed problem, with the rows that do not change."""
    M, (nx, nu), nc = len(lengths), problem.B.shape, len(problem.C)
    n, L = M * nu, nx + nu
    width, whole = len(problem.output) * max(lengths), L + TOGETHER
    rows = empty_rows(n, problem.penalty[block_ends(lengths)])
    rows.width[:] = nu * np.arange(1, M + 1)
    rows.R[:, :, :nc] = (problem.C @ dynamics.dense(nx)[1:]).transpose(0, 2, 1)
    for j in range(n):
        rows.R[j // nu, j, problem.rows - nu + j % nu] = 1.0
    return Condensed(
        H=np.zeros((n, n)),
        g=np.zeros(n),
        rows=rows,
        weights=np.full((problem.horizon, len(problem.weighted)), np.nan),
        base=np.zeros((M, L, L)),
        W=np.zeros((L, L)),
        w=np.zeros(L),
        S=np.zeros((nx, nx)),
        s=np.zeros(nx),
        half=np.zeros((2, L * nx)),
        outputs=np.zeros((int(np.count_nonzero(problem.output)), max(lengths))),
        errors=np.zeros(width),
        D=np.zeros((whole, whole_turns(width))),
        products=np.zeros((whole, whole)),
        by_state=np.zeros((nx, len(problem.varying))),
        free=np.zeros((M + 1, nx)),
    )


@jit_inner_fused
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


@jit_inner_fused
def _multiply(D: Mat, a: int, b: int, n: int, to: Mat) -> None:
    """Write the products of rows a, a + 1 with b, …, b + 3; one by one they would take twice the time."""
    p, q, r, s, t, u, v, w = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        one, other = D[a, i], D[a + 1, i]
        p += one * D[b, i]
        q += one * D[b + 1, i]
        r += one * D[b + 2, i]
        s += one * D[b + 3, i]
        t += other * D[b, i]
        u += other * D[b + 1, i]
        v += other * D[b + 2, i]
        w += other * D[b + 3, i]
    to[a, b], to[a, b + 1], to[a, b + 2], to[a, b + 3] = p, q, r, s
    to[a + 1, b], to[a + 1, b + 1], to[a + 1, b + 2], to[a + 1, b + 3] = t, u, v, w


@jit_inner_fused
def _spread(layout: Layout, memory: StageMemory, to: Condensed, first: int, length: int) -> None:
    """Write slopes and errors of a block's steps, output after output, so that steps lie side by side."""
    D, ny = to.D, memory.error.shape[1]
    for a in range(len(layout.felt)):
        for c in range(whole_turns(length * ny)):
            D[a, c] = 0.0
    for step in range(length):
        for s in range(len(to.outputs)):
            to.outputs[s, step] = memory.output[first + step, s]
        for c in range(ny):
            to.errors[c * length + step] = memory.error[first + step, c]
    for e in range(len(layout.spread)):
        s, a, c = layout.spread[e]
        for step in range(length):
            D[a, c * length + step] += to.outputs[s, step] * layout.share[e, step]


@jit_inner_fused
def _add_steps(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed, m: int, first: int) -> None:
    """Add what the steps of block m, from the `first` on, contribute to W and w."""
    felt, length = layout.felt, of.lengths[m]
    _spread(layout, memory, to, first, length)
    length *= memory.error.shape[1]
    for a in range(0, len(felt), 2):
        for b in range(0, a + 2, TOGETHER):
            _multiply(to.D, a, b, whole_turns(length), to.products)
    for a in range(len(felt)):
        i = felt[a]
        to.w[i] += dot(to.D[a], to.errors, length)
        to.W[i, i] += to.products[a, a]
        for b in range(a):
            j, value = felt[b], to.products[a, b]
            to.W[i, j] += value
            to.W[j, i] += value


@jit_inner_fused
def _add_linear(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed, m: int, first: int) -> None:
    """Add what the linear terms of the weighted states contribute to w."""
    for step in range(of.lengths[m]):
        for s in range(len(layout.weighted)):
            i, linear = layout.weighted[s], memory.state_linear[first + step, s]
            if linear != 0.0:
                for a in range(of.counts[i]):
                    to.w[of.columns[i, a]] += linear * of.gain[step, i, a]


@jit_inner_fused
def _add_later(of: Dynamics, to: Condensed, m: int) -> None:
    """Add what later blocks cost, in the states at the end of block m, to its own cost: Fᵀ S F and Fᵀ s."""
    nx, L, last = len(to.s), len(to.w), of.lengths[m] - 1
    half, turned = to.half[0].reshape(L, nx), to.half[1].reshape(nx, L)
    half[:] = 0.0
    for i in range(nx):
        for a in range(of.counts[i]):
            column, value = of.columns[i, a], of.gain[last, i, a]
            to.w[column] += value * to.s[i]
            for j in range(nx):
                half[column, j] += value * to.S[i, j]
    for i in range(nx):
        for j in range(L):
            turned[i, j] = half[j, i]
    for i in range(nx):
        for a in range(of.counts[i]):
            column, value = of.columns[i, a], of.gain[last, i, a]
            for j in range(L):
                to.W[column, j] += value * turned[i, j]


@jit_inner_fused
def _take_over(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed, m: int) -> None:
    """Take the cost from block m on, in its local variables, over into that in the inputs of all blocks."""
    nx, nu, G = len(to.s), memory.input_linear.shape[1], of.response[m]
    for j in range(nu):
        row = m * nu + j
        to.g[row] = memory.input_linear[m, j] + to.w[nx + j]
        for column in range(m * nu):
            to.H[row, column] = _by_input(of, G, column, to.W[nx + j])
        for k in range(j + 1):
            to.H[row, m * nu + k] = to.W[nx + j, nx + k]
        to.H[row, row] += layout.control[row]
    for i in range(nx):
        to.s[i] = to.w[i]
        for j in range(nx):
            to.S[i, j] = to.W[i, j]


@jit_inner_fused
def _by_input(of: Dynamics, G: Mat, column: int, row: Vec) -> float:
    """Return how a row (nx,) of the states changes with an input, given how that moves the states (n, s)."""
    total = 0.0
    for t in range(of.moved[column]):
        total += row[of.states[column, t]] * G[column, t]
    return total


@jit_inner_fused
def _move_free(of: Dynamics, to: Condensed, m: int) -> None:
    """Write the states without inputs at the end of block m."""
    nx, last = to.free.shape[1], of.lengths[m] - 1
    for i in range(nx):
        total = 0.0
        for a in range(of.counts[i]):
            if of.columns[i, a] < nx:
                total += of.gain[last, i, a] * to.free[m, of.columns[i, a]]
        to.free[m + 1, i] = total


@jit_inner_fused
def _rows(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed, m: int) -> None:
    """Write the rows at the end of block m and their bounds."""
    rows, lower, upper = memory.lower.shape[1], to.rows.lower, to.rows.upper
    first, x = m * rows, to.free[m + 1]
    for r in range(rows):
        lower[first + r], upper[first + r] = memory.lower[m, r], memory.upper[m, r]
    for s in range(len(layout.constant)):
        r, value = first + layout.constant[s, 0], layout.coefficients[s] * x[layout.constant[s, 1]]
        lower[r] -= value
        upper[r] -= value
    for s in range(len(layout.varying)):
        to.by_state[layout.varying[s, 1], layout.varying[s, 0]] = memory.varying[m, s]
    nv, first = to.by_state.shape[1], first + layout.first_varying
    for i in range(len(x)):
        for r in range(nv):
            value = to.by_state[i, r] * x[i]
            lower[first + r] -= value
            upper[first + r] -= value
    if nv == 0:
        return
    for column in range(to.rows.width[m]):
        row = to.rows.R[m, column, layout.first_varying :]
        for r in range(nv):
            row[r] = 0.0
        for t in range(of.moved[column]):
            i, value = of.states[column, t], of.response[m + 1, column, t]
            for r in range(nv):
                row[r] += value * to.by_state[i, r]


@jit_fused
def condense(of: Dynamics, layout: Layout, memory: StageMemory, to: Condensed) -> None:
    """Write the problem in memory as one in the inputs alone."""
    _weigh(of, layout, memory, to)
    for i in range(len(memory.start)):
        to.free[0, i] = memory.start[i]
    for m in range(len(of.lengths)):
        _move_free(of, to, m)
        _rows(of, layout, memory, to, m)
    to.S[:] = 0.0
    to.s[:] = 0.0
    nx, k = len(to.s), len(memory.error)
    for m in range(len(of.lengths) - 1, -1, -1):
        k -= of.lengths[m]
        for i in range(len(to.W)):
            copy_to(to.W[i], to.base[m, i])
        to.w[:] = 0.0
        _add_steps(of, layout, memory, to, m, k)
        _add_linear(of, layout, memory, to, m, k)
        for a in range(len(to.w)):
            to.w[a] += dot(to.W[a], to.free[m], nx)
        _add_later(of, to, m)
        _take_over(of, layout, memory, to, m)
