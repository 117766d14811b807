"""The dense engine on a folder of problem files, beside Clarabel where it is installed.

A file holds P, q, A, l, u of  min ½ xᵀ P x + qᵀ x,  l ≤ A x ≤ u,  as .mat (the form in which the
Maros-Meszaros test set is distributed, with the variables' bounds as the last rows of A) or as .npz with
dense matrices. Sides of 1e20 and more count as absent. An answer is wrong when its cost is above the peer's
by more than 1e-6 of the sum of its absolute terms.

Run: python benchmarks/problem_files.py FOLDER [most variables] [most rows]
"""

import importlib.util
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse
from scipy.io import loadmat

from otolith.core.arrays import Vec
from otolith.qp import DenseSolver, Qp, kkt_residual

ABSENT = 1e20


def read(path: Path, variables: int, rows: int) -> Qp | None:
    """The problem of one file; None when it is larger than asked for."""
    data: Any = loadmat(path) if path.suffix == ".mat" else np.load(path)
    stored, q = sparse.csr_array(data["A"]), np.ravel(data["q"]).astype(float)
    n = len(q)
    if n > variables or stored.shape[0] > rows + n:
        return None
    lower, upper = np.ravel(data["l"]).astype(float), np.ravel(data["u"]).astype(float)
    lower[lower <= -ABSENT], upper[upper >= ABSENT] = -np.inf, np.inf
    A, P = stored.toarray(), sparse.csr_array(data["P"]).toarray()
    if len(A) < n or not np.array_equal(A[-n:], np.eye(n)):
        return Qp(P, q, A, lower, upper)
    first = [np.concatenate([side[-n:], side[:-n]]) for side in (lower, upper)]  # simple bounds come first
    return Qp(P, q, A[:-n], *first)


def clarabel_answer(qp: Qp) -> tuple[Vec, Vec]:
    """Point and multipliers of Clarabel (Goulart & Chen, 2024)."""
    import clarabel

    R = np.vstack([np.eye(qp.bounds, len(qp.g)), qp.A])
    equal = qp.lower == qp.upper
    above, below = np.isfinite(qp.upper) & ~equal, np.isfinite(qp.lower) & ~equal
    rows = sparse.csc_matrix(np.vstack([R[equal], R[above], -R[below]]))
    sides = np.concatenate([qp.upper[equal], qp.upper[above], -qp.lower[below]])
    cones = [clarabel.ZeroConeT(int(equal.sum())), clarabel.NonnegativeConeT(int(above.sum() + below.sum()))]
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    P = sparse.triu(sparse.csc_matrix(qp.H)).tocsc()
    found = clarabel.DefaultSolver(P, qp.g, rows, sides, cones, settings).solve()
    y, dual = np.zeros(len(R)), np.split(np.array(found.z), np.cumsum([equal.sum(), above.sum()]))
    y[equal], y[above] = dual[0], dual[1]
    y[below] -= dual[2]
    return np.array(found.x), y


def main(folder: Path, variables: int, rows: int) -> None:
    peer = importlib.util.find_spec("clarabel") is not None
    counts: dict[str, int] = {}
    for path in sorted([*folder.glob("*.mat"), *folder.glob("*.npz")]):
        qp = read(path, variables, rows)
        if qp is None:
            continue
        started = time.process_time()
        found = DenseSolver(iteration_limit=20_000).solve(qp)
        taken = time.process_time() - started
        verdict, value = found.status.value, 0.5 * found.z @ qp.H @ found.z + qp.g @ found.z
        line = f"{path.stem:10s} {len(qp.g):5d} {len(qp.A):5d} {found.residual:8.1e} {taken:7.2f} s"
        line += f" {value:16.9g}"
        if peer:
            z, y = clarabel_answer(qp)
            best = 0.5 * z @ qp.H @ z + qp.g @ z
            terms = np.abs(z) @ (np.abs(qp.H) @ np.abs(z) + np.abs(qp.g))
            if verdict == "optimal" and value > best + 1e-6 * terms:
                verdict = "WRONG"
            line += f"   Clarabel {best:16.9g}, certificate {kkt_residual(qp, z, y):8.1e}"
        counts[verdict] = counts.get(verdict, 0) + 1
        print(f"{line}   {verdict} {found.why}", flush=True)
    print(counts)


if __name__ == "__main__":
    limits = [int(text) for text in sys.argv[2:4]]
    main(Path(sys.argv[1]), *(limits + [400, 1000][len(limits) :]))
