"""Step times of ours and of QP solvers on PyPI on the same recorded problems, with certificates, in one run.

    python -m venv peers && peers/bin/pip install -e . piqp clarabel proxsuite osqp
    peers/bin/python benchmarks/peers_qp.py [--json FILE]

PIQP, Clarabel, ProxQP, OSQP and daqp, those of them that are installed. The sparse form has all inputs and states, stage
by stage (u_0, x_1, u_1, … x_N), with the dynamics as equalities; the condensed form has the inputs alone. Where
a solver has both, both are shown. ProxQP, OSQP and daqp start from their last answer; interior points do not.
Tolerances are those at which the answers come nearest to our certificate; OSQP polishes.
"""

import importlib
import importlib.metadata
import sys
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import ModuleType
from typing import Any, Final

import numpy as np
import scipy.sparse as sparse

sys.path.insert(0, str(Path(__file__).parent.parent))
from benchmarks.peers import Answer, Engine, Makers, Recording, arguments, compare

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.qp.stage import StageQp, by_rows

PACKAGES: Final = ("piqp", "clarabel", "proxsuite", "osqp", "daqp")


@dataclass(frozen=True, slots=True)
class Data:
    """min ½ zᵀ P z + gᵀ z  s.t.  A z = b, l ≤ G z ≤ u, below ≤ z ≤ above; sides are infinite where there is none."""

    P: Any  # (n, n)
    g: Vec
    A: Any | None  # no equalities in the condensed form
    b: Vec | None
    G: Any  # (m, n)
    l: Vec  # noqa: E741 (the field's letter)
    u: Vec
    below: Vec  # (n,)
    above: Vec


class Stages:
    """The sparse form, on z = (u_0, x_1, u_1, …, x_N); every matrix keeps its structural non-zeros."""

    def __init__(self, recording: Recording) -> None:
        self.recording, self.rows = recording, recording.bounded_rows
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
        self.limits = Pattern(np.hstack([np.zeros((len(varying), nu), dtype=np.bool_), varying]), of_rows, places)
        one = np.hstack([-p.B, np.eye(nx)])
        self.A = sparse.kron(sparse.eye(N), one, format="csc")
        self.A += sparse.kron(sparse.eye(N, k=-1), np.hstack([np.zeros((nx, nu)), -p.A]), format="csc")
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
        return sparse.csc_matrix((blocks[:, self.mask].ravel()[self.order], self.indices, self.starts), shape=self.shape)


class Condensed:
    """The dense form, in the inputs alone."""

    def __init__(self, recording: Recording) -> None:
        p = self.p = recording.problem.structure
        self.recording = recording
        self.rows = np.flatnonzero(np.tile(np.isin(np.arange(p.rows - p.inputs), recording.bounded_rows), p.horizon))

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


class Peer:
    """What the engines of other projects share: a form of the problem, and the data of the one in turn."""

    def __init__(self, recording: Recording, *, form: type[Stages] | type[Condensed]) -> None:
        self.form = form(recording)
        self.prepare(0)
        self.begin()

    def prepare(self, i: int) -> None:
        """Form the data of problem i."""
        self.data = self.form.data(i)

    def answer(self) -> Answer:
        """Read the answer."""
        z, of_rows, of_box, solved = self.read()
        return Answer(*self.form.answer(np.asarray(z), np.asarray(of_rows), np.asarray(of_box)), solved)

    def begin(self) -> None:
        """Make the solver, and let it allocate its memory."""
        raise NotImplementedError

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        """Return z, the signed multipliers of rows and of z's own sides, and the solver's word."""
        raise NotImplementedError


class Piqp(Peer):
    """PIQP (Schwan et al., 2023), a proximal interior point; it starts cold."""

    def __init__(self, recording: Recording, *, form: type[Stages] | type[Condensed], kkt: str) -> None:
        self.kkt = kkt
        super().__init__(recording, form=form)

    def begin(self) -> None:
        import piqp

        d, self.package = self.data, piqp
        self.solver = piqp.DenseSolver() if self.kkt == "dense_cholesky" else piqp.SparseSolver()
        settings = self.solver.settings
        settings.kkt_solver = piqp.KKTSolver.__members__[self.kkt]
        settings.eps_abs, settings.eps_rel, settings.check_duality_gap = TIGHT, 0.0, False
        self.solver.setup(d.P, d.g, d.A, d.b, d.G, d.l, d.u, d.below, d.above)

    def update(self) -> None:
        d = self.data
        self.solver.update(d.P, d.g, d.A, d.b, d.G, d.l, d.u, d.below, d.above)

    def solve(self) -> None:
        self.status = self.solver.solve()

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        r = self.solver.result
        return r.x, r.z_u - r.z_l, r.z_bu - r.z_bl, self.status == self.package.PIQP_SOLVED


class Clarabel(Peer):
    """Clarabel (Goulart & Chen, 2024), a homogeneous interior point; it starts cold."""

    def begin(self) -> None:
        import clarabel

        d, self.package = self.data, clarabel
        self.sides = [np.flatnonzero(np.isfinite(side)) for side in (d.u, d.l, d.above, d.below)]
        settings = clarabel.DefaultSettings()
        settings.verbose = settings.presolve_enable = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TIGHT
        A, b = self._cone()
        equalities = 0 if d.b is None else len(d.b)
        cones = [clarabel.ZeroConeT(equalities), clarabel.NonnegativeConeT(len(b) - equalities)]
        self.solver = clarabel.DefaultSolver(sparse.triu(d.P, format="csc"), d.g, A, b, cones, settings)

    def _cone(self) -> tuple[sparse.csc_matrix, Vec]:
        d, (u, low, above, below) = self.data, self.sides
        eye = sparse.eye(len(d.g), format="csr")
        G = sparse.csr_matrix(d.G)
        A = sparse.vstack([d.A, G[u], -G[low], eye[above], -eye[below]], format="csc")
        return A, np.concatenate([d.b, d.u[u], -d.l[low], d.above[above], -d.below[below]])

    def prepare(self, i: int) -> None:
        super().prepare(i)
        if hasattr(self, "solver"):
            self.A, self.b = self._cone()
            self.P = sparse.triu(self.data.P, format="csc").data

    def update(self) -> None:
        self.solver.update(P=self.P, q=self.data.g, A=self.A.data, b=self.b)

    def solve(self) -> None:
        self.found = self.solver.solve()

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        d = self.data
        y = np.split(np.array(self.found.z), np.cumsum([len(d.b), *(len(side) for side in self.sides)]))
        of_rows, of_box = np.zeros(len(d.l)), np.zeros(len(d.g))
        for into, sign, side, values in zip(
            (of_rows, of_rows, of_box, of_box), (1.0, -1.0, 1.0, -1.0), self.sides, y[1:], strict=False
        ):
            into[side] += sign * values
        return np.array(self.found.x), of_rows, of_box, self.found.status == self.package.SolverStatus.Solved


class Osqp(Peer):
    """OSQP (Stellato et al., 2020), operator splitting; it starts from its last answer."""

    def begin(self) -> None:
        import osqp

        self.solver, self.package = osqp.OSQP(), osqp
        self._stack()
        self.solver.setup(
            self.P,
            self.data.g,
            self.A,
            self.l,
            self.u,
            eps_abs=1e-8,
            eps_rel=1e-8,
            max_iter=20_000,
            polishing=True,
            verbose=False,
        )

    def _stack(self) -> None:
        d, box = self.data, np.flatnonzero(np.isfinite(self.data.below) | np.isfinite(self.data.above))
        self.box = box
        self.P = sparse.triu(d.P, format="csc")
        self.A = sparse.vstack([d.A, d.G, sparse.eye(len(d.g), format="csr")[box]], format="csc")
        self.l, self.u = (np.concatenate([d.b, one, two[box]]) for one, two in ((d.l, d.below), (d.u, d.above)))

    def prepare(self, i: int) -> None:
        super().prepare(i)
        if hasattr(self, "solver"):
            self._stack()

    def update(self) -> None:
        self.solver.update(Px=self.P.data, Ax=self.A.data, q=self.data.g, l=self.l, u=self.u)

    def solve(self) -> None:
        self.found = self.solver.solve(raise_error=False)

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        d = self.data
        _, of_rows, y = np.split(self.found.y, np.cumsum([len(d.b), len(d.l)]))
        of_box = np.zeros(len(d.g))
        of_box[self.box] = y
        return self.found.x, of_rows, of_box, self.found.info.status == "solved"


class Proxqp(Peer):
    """ProxQP (Bambade et al., 2022), an augmented Lagrangian on the condensed form; it starts from its last answer."""

    def begin(self) -> None:
        import proxsuite

        d, self.package = self.data, proxsuite.proxqp
        self.solver = self.package.dense.QP(len(d.g), 0, len(d.l), True)
        self._settings()
        self.solver.init(d.P, d.g, None, None, d.G, d.l, d.u, d.below, d.above)

    def _settings(self) -> None:
        settings = self.solver.settings
        settings.eps_abs, settings.eps_rel = 1e-9, 0.0
        settings.initial_guess = self.package.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT

    def update(self) -> None:
        d = self.data
        self.solver.update(d.P, d.g, None, None, d.G, d.l, d.u, d.below, d.above)

    def solve(self) -> None:
        self.solver.solve()

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        found, m = self.solver.results, len(self.data.l)
        return found.x, found.z[:m], found.z[m:], self._solved()

    def _solved(self) -> bool:
        done: bool = self.solver.results.info.status == self.package.QPSolverOutput.PROXQP_SOLVED
        return done


class ProxqpSparse(Proxqp):
    """ProxQP on the sparse form, which takes the inputs' bounds as rows."""

    def begin(self) -> None:
        import proxsuite

        self.package = proxsuite.proxqp
        self._stack()
        self.solver = self.package.sparse.QP(len(self.data.g), len(self.data.b), len(self.l))
        self._settings()
        self.solver.init(self.data.P, self.data.g, self.data.A, self.data.b, self.C, self.l, self.u)

    def _stack(self) -> None:
        d, self.box = self.data, np.flatnonzero(np.isfinite(self.data.below) | np.isfinite(self.data.above))
        self.C = sparse.vstack([d.G, sparse.eye(len(d.g), format="csr")[self.box]], format="csc")
        self.l, self.u = (np.concatenate([one, two[self.box]]) for one, two in ((d.l, d.below), (d.u, d.above)))

    def prepare(self, i: int) -> None:
        super().prepare(i)
        if hasattr(self, "solver"):
            self._stack()

    def update(self) -> None:
        d = self.data
        self.solver.update(d.P, d.g, d.A, d.b, self.C, self.l, self.u)

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        found, m = self.solver.results, len(self.data.l)
        of_box = np.zeros(len(self.data.g))
        of_box[self.box] = found.z[m:]
        return found.x, found.z[:m], of_box, self._solved()


class Daqp(Peer):
    """daqp (Arnström et al., 2022), a dual active-set method on the condensed form; it starts from its last set."""

    def begin(self) -> None:
        import daqp

        self.solver, d = daqp.Model(), self.data
        self.solver.settings = {"primal_tol": 1e-9}
        self.solver.setup(d.P, d.g, d.G, np.concatenate([d.above, d.u]), np.concatenate([d.below, d.l]))

    def update(self) -> None:
        d = self.data
        above, below = np.concatenate([d.above, d.u]), np.concatenate([d.below, d.l])
        self.solver.update(H=d.P, f=d.g, A=d.G, bupper=above, blower=below)

    def solve(self) -> None:
        self.found = self.solver.solve()

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        z, _, flag, info = self.found
        n = len(self.data.g)
        return z, info["lam"][n:], info["lam"][:n], flag > 0


TIGHT: Final = 1e-10
ENGINES: Final[dict[str, tuple[str, Any]]] = {
    "PIQP, sparse, multistage": ("piqp", partial(Piqp, form=Stages, kkt="sparse_multistage")),
    "PIQP, sparse": ("piqp", partial(Piqp, form=Stages, kkt="sparse_ldlt")),
    "PIQP, condensed": ("piqp", partial(Piqp, form=Condensed, kkt="dense_cholesky")),
    "Clarabel, sparse": ("clarabel", partial(Clarabel, form=Stages)),
    "ProxQP, sparse, warm": ("proxsuite", partial(ProxqpSparse, form=Stages)),
    "ProxQP, condensed, warm": ("proxsuite", partial(Proxqp, form=Condensed)),
    "OSQP, sparse, warm": ("osqp", partial(Osqp, form=Stages)),
    "daqp, condensed, warm": ("daqp", partial(Daqp, form=Condensed)),
}
