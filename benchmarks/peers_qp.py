"""Step times of ours and of QP solvers on PyPI on the same recorded problems, with certificates, in one run.

    python -m venv peers && peers/bin/pip install -e . piqp clarabel proxsuite osqp
    peers/bin/python benchmarks/peers_qp.py [--json FILE]

PIQP, Clarabel, ProxQP, OSQP and daqp are asked, those of them that are installed. The sparse form has all
inputs and states, stage by stage (u_0, x_1, u_1, … x_N), with the dynamics as equalities; the condensed form
has the inputs alone. Where a solver has both, both are shown. ProxQP, OSQP and daqp start from their last
answer; interior points do not. Tolerances are those at which the answers come nearest to our certificate;
OSQP polishes.
"""

from functools import partial
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Final

import numpy as np
from scipy import sparse

from otolith.core.arrays import Vec
from peers import Answer, Recording, arguments, compare
from peers_forms import Condensed, Stages

TIGHT: Final = 1e-12  # tolerance of the interior points
PACKAGES: Final = ("piqp", "clarabel", "proxsuite", "osqp", "daqp")


class Peer:
    """What the engines of other projects share: a form of the problem, and the data of the one in turn."""

    hands_over = True

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
        settings.eps_abs, settings.eps_rel = TIGHT, 0.0
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = TIGHT, 0.0
        self.solver.setup(d.P, d.g, d.A, d.b, d.G, d.low, d.high, d.below, d.above)

    def update(self) -> None:
        d = self.data
        self.solver.update(d.P, d.g, d.A, d.b, d.G, d.low, d.high, d.below, d.above)

    def solve(self) -> None:
        self.status = self.solver.solve()

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        r = self.solver.result
        return r.x, r.z_u - r.z_l, r.z_bu - r.z_bl, self.status == self.package.PIQP_SOLVED


class Stacked(Peer):
    """A solver that takes the sides of z itself as rows, after all others."""

    def prepare(self, i: int) -> None:
        """Form the data of problem i, with rows C and their sides."""
        super().prepare(i)
        self.box = self.data.boxed
        self.C, self.low, self.high = self.data.stacked(self.box)

    def split(self, y: Vec) -> tuple[Vec, Vec]:
        """Return the multipliers of rows, and those of z's own sides."""
        of_box = np.zeros(len(self.data.g))
        of_box[self.box] = y[len(self.data.low) :]
        return y[: len(self.data.low)], of_box


class Clarabel(Stacked):
    """Clarabel (Goulart & Chen, 2024), a homogeneous interior point; it starts cold."""

    def prepare(self, i: int) -> None:
        """Form rows A z + s = b with s in a cone: zero, then not negative for upper and lower sides."""
        super().prepare(i)
        d = self.data
        self.sides = [np.flatnonzero(np.isfinite(side)) for side in (self.high, self.low)]
        upper, lower = self.sides
        rows = self.C.tocsr()
        self.A = sparse.vstack([d.A, rows[upper], -rows[lower]], format="csc")
        self.b = np.concatenate([d.b, self.high[upper], -self.low[lower]])
        self.P = sparse.triu(d.P, format="csc")

    def begin(self) -> None:
        import clarabel

        self.package, equalities = clarabel, len(self.data.b)
        settings = clarabel.DefaultSettings()
        settings.verbose = settings.presolve_enable = False
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TIGHT
        cones = [clarabel.ZeroConeT(equalities), clarabel.NonnegativeConeT(len(self.b) - equalities)]
        self.solver = clarabel.DefaultSolver(self.P, self.data.g, self.A, self.b, cones, settings)

    def update(self) -> None:
        self.solver.update(P=self.P.data, q=self.data.g, A=self.A.data, b=self.b)

    def solve(self) -> None:
        self.found = self.solver.solve()

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        (upper, lower), y = self.sides, np.zeros(len(self.low))
        _, above, below = np.split(self.found.z, np.cumsum([len(self.data.b), len(upper)]))
        y[upper] += above
        y[lower] -= below
        return np.array(self.found.x), *self.split(y), self.found.status == self.package.SolverStatus.Solved


class Osqp(Stacked):
    """OSQP (Stellato et al., 2020), operator splitting; it starts from its last answer."""

    def prepare(self, i: int) -> None:
        """Form the data of problem i, with the equalities as the first rows."""
        super().prepare(i)
        d = self.data
        self.P, self.A = sparse.triu(d.P, format="csc"), sparse.vstack([d.A, self.C], format="csc")
        self.sides = np.concatenate([d.b, self.low]), np.concatenate([d.b, self.high])

    def begin(self) -> None:
        import osqp

        self.solver = osqp.OSQP()
        settings = {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 20_000, "polishing": True}
        self.solver.setup(self.P, self.data.g, self.A, *self.sides, verbose=False, **settings)

    def update(self) -> None:
        low, high = self.sides
        self.solver.update(Px=self.P.data, Ax=self.A.data, q=self.data.g, l=low, u=high)

    def solve(self) -> None:
        self.found = self.solver.solve(raise_error=False)

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        y = self.found.y[len(self.data.b) :]
        return self.found.x, *self.split(y), self.found.info.status == "solved"


class Proxqp(Stacked):
    """ProxQP (Bambade et al., 2022), an augmented Lagrangian; it starts from its last answer."""

    def begin(self) -> None:
        import proxsuite

        self.package, d = proxsuite.proxqp, self.data
        equalities = 0 if d.b is None else len(d.b)
        of = self.package.dense if d.A is None else self.package.sparse
        self.solver = of.QP(len(d.g), equalities, len(self.low))
        settings = self.solver.settings
        settings.eps_abs, settings.eps_rel, settings.check_duality_gap = 1e-10, 0.0, True
        settings.eps_duality_gap_abs, settings.eps_duality_gap_rel = 1e-8, 0.0
        settings.initial_guess = self.package.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
        self.solver.init(d.P, d.g, d.A, d.b, self.C, self.low, self.high)

    def update(self) -> None:
        d = self.data
        self.solver.update(d.P, d.g, d.A, d.b, self.C, self.low, self.high)

    def solve(self) -> None:
        self.solver.solve()

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        found = self.solver.results
        solved = found.info.status == self.package.QPSolverOutput.PROXQP_SOLVED
        return found.x, *self.split(found.z), solved


class Daqp(Peer):
    """daqp (Arnström et al., 2022), a dual active-set method; it starts from its last working set."""

    def begin(self) -> None:
        import daqp

        self.solver, d = daqp.Model(), self.data
        self.solver.settings = {"primal_tol": 1e-9}
        self.solver.setup(d.P, d.g, d.G, np.concatenate([d.above, d.high]), np.concatenate([d.below, d.low]))

    def update(self) -> None:
        d = self.data
        above, below = np.concatenate([d.above, d.high]), np.concatenate([d.below, d.low])
        self.solver.update(H=d.P, f=d.g, A=d.G, bupper=above, blower=below)

    def solve(self) -> None:
        self.found = self.solver.solve()

    def read(self) -> tuple[Vec, Vec, Vec, bool]:
        z, _, flag, info = self.found
        n = len(self.data.g)
        return z, info["lam"][n:], info["lam"][:n], flag > 0


ENGINES: Final[dict[str, tuple[str, Any]]] = {
    "PIQP, sparse, multistage": ("piqp", partial(Piqp, form=Stages, kkt="sparse_multistage")),
    "PIQP, sparse": ("piqp", partial(Piqp, form=Stages, kkt="sparse_ldlt")),
    "PIQP, condensed": ("piqp", partial(Piqp, form=Condensed, kkt="dense_cholesky")),
    "Clarabel, sparse": ("clarabel", partial(Clarabel, form=Stages)),
    "ProxQP, sparse, warm": ("proxsuite", partial(Proxqp, form=Stages)),
    "ProxQP, condensed, warm": ("proxsuite", partial(Proxqp, form=Condensed)),
    "OSQP, sparse, warm": ("osqp", partial(Osqp, form=Stages)),
    "daqp, condensed, warm": ("daqp", partial(Daqp, form=Condensed)),
}


def installed() -> dict[str, str]:
    """Versions of those packages that are installed."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            print(f"without {name}, which is not installed")
    return found


def main() -> None:
    chosen = arguments(__doc__ or "").parse_args()
    versions = installed()
    makers = {name: make for name, (package, make) in ENGINES.items() if package in versions}
    compare(makers, versions, chosen)


if __name__ == "__main__":
    main()
