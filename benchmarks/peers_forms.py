"""The forms in which QP solvers take a recorded problem: sparse, stage by stage, and condensed.

Both are written as min ½ zᵀ P z + gᵀ z  s.t.  A z = b, low ≤ G z ≤ high, below ≤ z ≤ above.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.qp.stage import by_rows
from peers import Recording


@dataclass(frozen=True, slots=True)
class Data:
    """One problem; a side without a bound is infinite."""

    P: Any  # (n, n)
    g: Vec
    A: Any  # None in the condensed form, which has no equalities
    b: Any
    G: Any  # (m, n)
    low: Vec  # (m,)
    high: Vec
    below: Vec  # (n,)
    above: Vec

    def stacked(self, box: Ints) -> tuple[Any, Vec, Vec]:
        """Return rows and their sides with those on z itself, at the places `box`, as the last rows."""
        one = sparse.eye(len(self.g), format="csr")[box]
        sparse_rows = sparse.vstack([self.G, one], format="csc")
        sides = (np.concatenate(pair) for pair in ((self.low, self.below[box]), (self.high, self.above[box])))
        return sparse_rows if sparse.issparse(self.G) else sparse_rows.toarray(), *sides

    @property
    def boxed(self) -> Ints:
        """Places of z that have a side."""
        return np.flatnonzero(np.isfinite(self.below) | np.isfinite(self.above))


class Stages:
    """The sparse form, on z = (u_0, x_1, u_1, …, x_N); every matrix keeps its structural non-zeros."""

    def __init__(self, recording: Recording) -> None:
        self.recording, (self.rows, _) = recording, recording.bounded
        p = self.p = recording.problem.structure
        N, nx, nu, width = p.horizon, p.states, p.inputs, p.states + p.inputs
        places = np.arange(N * width).reshape(N, width)
        cost = np.zeros((width, width), dtype=np.bool_)
        cost[nu:, nu:] = (p.output[:, :, None] & p.output[:, None, :]).any(axis=0)
        cost[range(nu), range(nu)] = True
        cost[[nu + i for i in p.weighted], [nu + i for i in p.weighted]] = True
        self.cost = Pattern(cost, places, places)
        varying = np.vstack([p.C != 0.0, p.varying])[self.rows]
        of_rows = np.arange(N * len(self.rows)).reshape(N, -1)
        self.limits = Pattern(
            np.hstack([np.zeros((len(varying), nu), dtype=np.bool_), varying]), of_rows, places
        )
        from_last = np.hstack([np.zeros((nx, nu)), -p.A])
        self.A = sparse.kron(sparse.eye(N), np.hstack([-p.B, np.eye(nx)]), format="csc")
        self.A = self.A + sparse.kron(sparse.eye(N, k=-1), from_last, format="csc")
        self.box = places[:, :nu].ravel()  # places of the inputs

    def data(self, i: int) -> Data:
        """Write problem i."""
        qp, p = self.recording.qps[i], self.p
        N, nu, nr, weighted = p.horizon, p.inputs, p.rows - p.inputs, list(p.weighted)
        P, g = np.zeros((N, nu + p.states, nu + p.states)), np.zeros((N, nu + p.states))
        P[:, range(nu), range(nu)] = p.control_weight
        P[:, nu:, nu:] = np.einsum("kyi,kyj->kij", qp.output, qp.output)
        P[:, [nu + j for j in weighted], [nu + j for j in weighted]] += qp.state_weight
        g[:, :nu], g[:, nu:] = qp.input_linear, np.einsum("kyi,ky->ki", qp.output, qp.error)
        g[:, [nu + j for j in weighted]] += qp.state_linear
        C = np.concatenate([np.broadcast_to(p.C, (N, *p.C.shape)), qp.varying], axis=1)[:, self.rows]
        b = np.zeros((N, p.states))
        b[0] = p.A @ qp.x0
        sides = []
        for sign, side in ((-1.0, qp.lower), (1.0, qp.upper)):
            box = np.full((N, nu + p.states), sign * np.inf)
            box[:, :nu] = side[:, nr:]
            sides.append((side[:, self.rows].ravel(), box.ravel()))
        (low, below), (high, above) = sides
        G = self.limits.matrix(np.concatenate([np.zeros((N, len(self.rows), nu)), C], axis=2))
        return Data(self.cost.matrix(P), g.ravel(), self.A, b.ravel(), G, low, high, below, above)

    def answer(self, z: Vec, of_rows: Vec, of_box: Vec) -> tuple[Mat, Mat]:
        """Return inputs and signed multipliers as `stage_residual` takes them."""
        p = self.p
        y = np.zeros((p.horizon, p.rows))
        y[:, self.rows] = of_rows.reshape(p.horizon, -1)
        y[:, p.rows - p.inputs :] = of_box[self.box].reshape(p.horizon, -1)
        return z[self.box].reshape(p.horizon, -1), y


class Pattern:
    """Blocks with the same structural non-zeros, one per stage, as a sparse matrix that keeps them."""

    def __init__(self, mask: Bools, rows: Ints, columns: Ints) -> None:
        i, j = np.nonzero(mask)
        r, c = rows[:, i].ravel(), columns[:, j].ravel()
        self.mask, self.order = mask, np.lexsort((r, c))
        self.indices = r[self.order]
        self.shape = (rows.size, columns.size)
        self.starts = np.searchsorted(c[self.order], np.arange(columns.size + 1))

    def matrix(self, blocks: Mat) -> sparse.csc_matrix:
        """Return the matrix with these blocks (N, rows, columns)."""
        return sparse.csc_matrix(
            (blocks[:, self.mask].ravel()[self.order], self.indices, self.starts), shape=self.shape
        )


class Condensed:
    """The dense form, in the inputs alone."""

    def __init__(self, recording: Recording) -> None:
        p = self.p = recording.problem.structure
        self.recording = recording
        self.rows = np.flatnonzero(
            np.tile(np.isin(np.arange(p.rows - p.inputs), recording.bounded[0]), p.horizon)
        )

    def data(self, i: int) -> Data:
        """Write problem i."""
        qp = self.recording.condensed(i)
        n, of = len(qp.g), len(qp.g) + self.rows
        sides = qp.lower[of], qp.upper[of], qp.lower[:n], qp.upper[:n]
        return Data(qp.H, qp.g, None, None, np.ascontiguousarray(qp.A[self.rows]), *sides)

    def answer(self, z: Vec, of_rows: Vec, of_box: Vec) -> tuple[Mat, Mat]:
        """Return inputs and signed multipliers as `stage_residual` takes them."""
        p = self.p
        y = np.zeros(p.horizon * p.rows)
        y[: len(z)] = of_box
        y[len(z) + self.rows] = of_rows
        return z.reshape(p.horizon, -1), by_rows(y, p)
