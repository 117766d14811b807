#!/bin/sh
# proxsuite 0.8.0: started from its last answer, ProxQP now and then calls a wrong point solved.
#
# Strictly convex problems with the same matrices (10 variables, 20 rows with two sides, random numbers of size 1), where
# only the linear cost changes from one to the next. With `initial_guess = WARM_START_WITH_PREVIOUS_RESULT`, tolerances
# of 1e-9 and the duality gap checked at 1e-8, a few answers in a thousand are called PROXQP_SOLVED though a row lies at
# one of its sides and its multiplier has the sign of the other: the gradient vanishes, the point is feasible, and the
# gap that ProxQP reports is below its tolerance, but the point is not the minimum. From a cold start the same
# problems are solved rightly, and their cost is lower. The sparse interface does it, too. Who starts ProxQP warm has
# to check the signs of its multipliers.
#
# Run by hand. Exits 0 while this holds, 1 once it does not.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet "proxsuite==0.8.0" "numpy==2.4.6" "scipy==1.17.1"
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import sys

import numpy as np
import proxsuite

qp, n, m = proxsuite.proxqp, 10, 20
SOLVED = qp.QPSolverOutput.PROXQP_SOLVED


def solver(warm):
    made = qp.dense.QP(n, 0, m)
    s = made.settings
    s.eps_abs, s.eps_rel, s.check_duality_gap = 1e-9, 0.0, True
    s.eps_duality_gap_abs, s.eps_duality_gap_rel = 1e-8, 0.0
    if warm:
        s.initial_guess = qp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
    return made


def broken(found, C, u):
    """Largest product of a multiplier and the row's distance to the side that the multiplier's sign names."""
    values, z = C @ found.x, np.array(found.z)
    return float(np.maximum(np.maximum(z, 0) * (u - values), np.maximum(-z, 0) * (values + u)).max())


solved, wrong, agree = 0, 0, True
for seed in range(60):
    rng = np.random.default_rng(seed)
    L = rng.normal(size=(n, n))
    H, C, u = L @ L.T + 0.1 * np.eye(n), rng.normal(size=(m, n)), rng.uniform(0.05, 0.5, size=m)
    warm = solver(True)
    for k in range(40):
        g = rng.normal(size=n) * rng.choice([0.03, 0.3, 3.0])
        if k == 0:
            warm.init(H, g, None, None, C, -u, u)
        else:
            warm.update(g=g)
        warm.solve()
        solved += warm.results.info.status == SOLVED
        if warm.results.info.status != SOLVED or broken(warm.results, C, u) < 1e-5:
            continue
        cold = solver(False)
        cold.init(H, g, None, None, C, -u, u)
        cold.solve()
        x, y = np.array(warm.results.x), np.array(cold.results.x)
        gradient = np.abs(H @ x + g + C.T @ warm.results.z).max()
        more = 0.5 * (x @ H @ x - y @ H @ y) + g @ (x - y)
        wrong += 1
        agree &= cold.results.info.status == SOLVED and broken(cold.results, C, u) < 1e-7 and more > 0.0
        print(
            f"sequence {seed}, problem {k}: complementarity {broken(warm.results, C, u):.0e} (cold"
            f" {broken(cold.results, C, u):.0e}), gradient {gradient:.0e}, own gap {warm.results.info.duality_gap:.0e};"
            f" cost {more:.0e} above the cold one's, variables {np.abs(x - y).max():.0e} off"
        )
print(f"proxsuite {proxsuite.__version__}: {wrong} of {solved} answers called solved are not minima")
sys.exit(0 if wrong and agree else 1)
PYTHON
