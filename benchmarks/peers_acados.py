"""Step times of ours and of acados's QP solvers on the same recorded problems, with certificates, in one run.

    python benchmarks/peers_acados.py [--acados PATH] [--json FILE]

PATH is an installation of acados, with `lib/libacados.so` in it; without it ACADOS_SOURCE_DIR says where. Its
C interface for QPs is called directly, so nothing is generated. x_0 is eliminated beforehand, input bounds
are bounds, other rows general constraints, rows without bounds are left out. Settings are HPIPM on so many
blocks (partial condensing) or condensed to the end, and DAQP and qpOASES, condensed, where acados was built
with them. "Warm" HPIPM keeps its multipliers; since acados sets the primal point to zero before every solve,
such a problem is written in deviations from the last answer, as its SQP does, outside the clock.
"""

import ctypes
import os
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Mat
from otolith.qp.stage import rollout
from peers import Answer, Makers, Recording, arguments, compare

LIBRARIES: Final = ("blasfeo", "hpipm", "qpOASES_e", "daqp", "acados")  # in the order of their needs
TIGHT: Final = 1e-14  # of complementarity, at which HPIPM's answers pass our certificate; 1e-8 is usual
HUGE: Final = 1e8  # for sides without a bound, where an engine takes no masks


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One way to use acados; the fields that are None do not apply."""

    solver: str = "PARTIAL_CONDENSING_HPIPM"
    blocks: int | None = None  # N2, the horizon after partial condensing
    mode: str | None = None  # of HPIPM
    warm: int = 0
    gap: float = TIGHT  # tolerance of complementarity
    masks: bool = True  # the solver knows sides without a bound


def _hpipm(blocks: int, mode: str = "SPEED", warm: int = 2, *, gap: float = TIGHT) -> Setting:
    return Setting(blocks=blocks, mode=mode, warm=warm, gap=gap)


SETTINGS: Final[dict[str, Setting]] = {
    "HPIPM, 50 blocks, warm": _hpipm(50),
    "HPIPM, 25 blocks, warm": _hpipm(25),
    "HPIPM, 10 blocks, warm": _hpipm(10),
    "HPIPM, 5 blocks, warm": _hpipm(5),
    "HPIPM, 10 blocks": _hpipm(10, warm=0),
    "HPIPM, 10 blocks, balance": _hpipm(10, "BALANCE", warm=0),
    "HPIPM, 10 blocks, warm, gap 1e-8": _hpipm(10, gap=1e-8),
    "HPIPM, condensed": Setting(solver="FULL_CONDENSING_HPIPM", mode="SPEED"),
    "DAQP, condensed, warm": Setting(solver="FULL_CONDENSING_DAQP", warm=1),
    "qpOASES, condensed, warm": Setting(solver="FULL_CONDENSING_QPOASES", warm=1, masks=False),
}
NEEDS: Final = {"FULL_CONDENSING_DAQP": "daqp", "FULL_CONDENSING_QPOASES": "qpOASES_e"}


def opened(root: Path) -> dict[str, ctypes.CDLL]:
    """Load the libraries of an installation, those that are there; what they need is loaded before them."""
    found = {}
    for name in LIBRARIES:
        file = root / "lib" / f"lib{name}.so"
        if file.exists():
            found[name] = ctypes.CDLL(str(file))
    return found


class Acados:
    """One solver of acados behind `Engine`; its data go stage by stage into acados's own memory."""

    hands_over = False

    def __init__(self, recording: Recording, *, lib: ctypes.CDLL, setting: Setting) -> None:
        self.recording, self.setting, self.lib = recording, setting, lib
        p = recording.problem.structure
        self.nr, self.rows, self.inputs = p.rows - p.inputs, *recording.bounded
        self.U, self.X = np.zeros((p.horizon, p.inputs)), np.zeros((p.horizon, p.states))
        self.status, self.qp = 1, recording.qps[0]
        call = partial(_called, lib)
        self.config = call("ocp_qp_xcond_solver_config_create_from_name", setting.solver.encode())
        self.dims = call("ocp_qp_xcond_solver_dims_create", self.config, p.horizon)
        for k in range(p.horizon + 1):
            self._size(k, nx=p.states if k else 0, ng=len(self.rows) if k else 0)
            last = k == p.horizon
            self._size(k, nu=0 if last else p.inputs, nbu=0 if last else len(self.inputs))
        self.options = call("ocp_qp_xcond_solver_opts_create", self.config, self.dims)
        self._set_options()
        self.solver = call("ocp_qp_create", self.config, self.dims, self.options)
        self.into = call("ocp_qp_in_create_from_xcond_dims", self.dims)
        self.out = call("ocp_qp_out_create_from_xcond_dims", self.dims)
        self._write_constants()
        self.run = lib.ocp_qp_solve  # returns an int, as ctypes supposes

    def _size(self, k: int, **sizes: int) -> None:
        for name, value in sizes.items():
            _called(
                self.lib,
                "ocp_qp_xcond_solver_dims_set",
                self.config,
                self.dims,
                k,
                name.encode(),
                ctypes.byref(ctypes.c_int(value)),
            )

    def _set_options(self) -> None:
        setting = self.setting
        options: dict[str, object] = {} if setting.mode is None else {"hpipm_mode": setting.mode.encode()}
        options |= {f"tol_{name}": ctypes.c_double(1e-8) for name in ("stat", "eq", "ineq")}
        options["tol_comp"] = ctypes.c_double(setting.gap)
        if setting.blocks is not None:
            options["cond_N"] = ctypes.c_int(setting.blocks)
        most = 100 if setting.mode else 10_000  # iterations of an interior point, changes of an active set
        options |= {"iter_max": ctypes.c_int(most), "warm_start": ctypes.c_int(setting.warm)}
        for name, value in options.items():
            place = value if isinstance(value, bytes) else ctypes.byref(value)  # type: ignore[arg-type]
            _called(self.lib, "ocp_qp_xcond_solver_opts_set", self.config, self.options, name.encode(), place)

    def _put(self, k: int, name: str, value: NDArray[np.generic], dtype: type = np.float64) -> None:
        flat: NDArray[np.generic] = np.asarray(value, dtype=dtype).ravel(order="F")
        place = ctypes.c_void_p(flat.ctypes.data)
        _called(self.lib, "ocp_qp_in_set", self.config, self.into, k, name.encode(), place)

    def _write_constants(self) -> None:
        p = self.recording.problem.structure
        for k in range(p.horizon):
            if k:
                self._put(k, "A", p.A)
            self._put(k, "B", p.B)
            self._put(k, "R", np.diag(p.control_weight))
            self._put(k, "S", np.zeros((p.inputs, p.states if k else 0)))
            self._put(k, "idxb", self.inputs, np.int32)
            if k:
                self._put(k, "D", np.zeros((len(self.rows), p.inputs)))

    def prepare(self, i: int) -> None:
        """Write problem i, in deviations from the last answer where the setting starts warm."""
        self.qp = qp = self.recording.qps[i]
        p = qp.problem
        if not (self.setting.warm and self.setting.mode):
            self.U, self.X = np.zeros_like(self.U), np.zeros_like(self.X)
        before = np.vstack([qp.x0, self.X[:-1]])
        gaps = before @ p.A.T + self.U @ p.B.T - self.X
        force = np.einsum("kyi,ki->ky", qp.output, self.X) + qp.error
        weighted = list(p.weighted)
        gradient = np.einsum("kyi,ky->ki", qp.output, force)
        gradient[:, weighted] += qp.state_weight * self.X[:, weighted] + qp.state_linear
        own = p.control_weight * self.U + qp.input_linear
        for k in range(p.horizon):
            Q = qp.output[k].T @ qp.output[k]
            Q[weighted, weighted] += qp.state_weight[k]
            C = np.vstack([p.C, qp.varying[k]])[self.rows]
            self._put(k, "b", gaps[k])
            self._put(k, "r", own[k])
            self._put(k + 1, "Q", Q)
            self._put(k + 1, "q", gradient[k])
            self._put(k + 1, "C", C)
            self._sides(k + 1, "g", k, self.rows, C @ self.X[k])
            self._sides(k, "bu", k, self.nr + self.inputs, self.U[k, self.inputs])

    def _sides(self, at: int, name: str, k: int, rows: NDArray[np.int64], about: Mat) -> None:
        for letter, side in (("l", self.qp.lower), ("u", self.qp.upper)):
            values = side[k, rows]
            there = np.isfinite(values)
            field_ = f"{letter}{name}" if name == "g" else f"{letter}b{name[1:]}"
            self._put(at, field_, np.where(there, values - about, np.sign(values) * HUGE))
            if self.setting.masks:
                self._put(at, f"{field_}_mask", there)

    def update(self) -> None:
        """Do nothing: acados's memory is its interface, and `prepare` has written it."""

    def solve(self) -> None:
        """Condense, solve and expand; acados returns 0 when it calls the problem solved."""
        self.status = self.run(self.solver, self.into, self.out)

    def answer(self) -> Answer:
        """Read the answer, and remember it for the next problem."""
        p = self.qp.problem
        y = np.zeros((p.horizon, p.rows))
        for k in range(p.horizon + 1):
            nb, ng = (0 if k == p.horizon else len(self.inputs)), (len(self.rows) if k else 0)
            lower, upper = np.split(self._get(k, "lam", 2 * (nb + ng)), 2)
            if nb:
                y[k, self.nr + self.inputs] = (upper - lower)[:nb]
            if ng:
                y[k - 1, self.rows] = (upper - lower)[nb:]
        self.U = self.U + np.array([self._get(k, "u", p.inputs) for k in range(p.horizon)])
        self.X = rollout(self.qp, self.U)
        return Answer(self.U, y, self.status == 0)

    def _get(self, k: int, name: str, size: int) -> NDArray[np.float64]:
        values = np.zeros(size)
        _called(self.lib, "ocp_qp_out_get", self.out, k, name.encode(), ctypes.c_void_p(values.ctypes.data))
        return values


def _called(lib: ctypes.CDLL, name: str, *arguments: object) -> ctypes.c_void_p:
    """Call a function of acados's interface that returns a pointer, or nothing."""
    function = getattr(lib, name)
    function.restype = ctypes.c_void_p
    return ctypes.c_void_p(function(*arguments))


def makers_of(root: Path) -> tuple[Makers, dict[str, str]]:
    """Return a maker for each setting, and the version, of an installation.

    Raises
    ------
    FileNotFoundError : there is no acados.
    """
    libraries = opened(root)
    if "acados" not in libraries:
        raise FileNotFoundError(f"acados is not found: {root} has no lib/libacados.so")
    makers = {
        f"acados, {name}": partial(Acados, lib=libraries["acados"], setting=setting)
        for name, setting in SETTINGS.items()
        if NEEDS.get(setting.solver, "acados") in libraries
    }
    mark = root / "lib" / "git_commit_hash"
    return makers, {"acados": mark.read_text().strip() if mark.exists() else "unknown"}


def main() -> int:
    parser = arguments(__doc__ or "")
    parser.add_argument("--acados", type=Path, default=os.environ.get("ACADOS_SOURCE_DIR"), metavar="PATH")
    chosen = parser.parse_args()
    try:
        if not chosen.acados:
            raise FileNotFoundError(
                "acados is not found: neither --acados nor ACADOS_SOURCE_DIR names an installation"
            )
        makers, versions = makers_of(Path(chosen.acados))
    except FileNotFoundError as absent:
        print(absent, file=sys.stderr)
        return 2
    compare(makers, versions, chosen)
    return 0


if __name__ == "__main__":
    sys.exit(main())
