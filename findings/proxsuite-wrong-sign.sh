#!/bin/sh
# proxsuite 0.8.0: started from its last answer, sparse ProxQP calls points solved whose multipliers have the wrong sign.
#
# A double integrator is steered to changing targets over 10 steps (30 variables, bounds on position, speed and input,
# strictly convex in what matters). With `initial_guess = WARM_START_WITH_PREVIOUS_RESULT`, and primal, dual and gap
# tolerances of 1e-9, 1e-9 and 1e-8, a few answers in a thousand are called PROXQP_SOLVED, within an iteration or two,
# though a variable is at one bound and its multiplier has the sign of the other: the gradient condition holds, the point
# is not optimal, and the gap that ProxQP reports is below its tolerance while complementarity is off by 1e-3 or more.
# The first input is then off by as much as shown. The same problems from a cold start are solved rightly.
# A controller that starts warm has to check signs itself.
#
# Run by hand; takes half a minute. Exits 0 while this holds, 1 once it does not.
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
import scipy.sparse as sp

qp = proxsuite.proxqp
N, h, weight, R = 10, 0.1, 10.0, 0.1
A, B = np.array([[1.0, h], [0.0, 1.0]]), np.array([[h * h / 2], [h]])
H = sp.diags(np.tile([R, weight, 1e-3], N)).tocsc()  # of (u_0, x_1, u_1, ... x_N)
now, last = np.hstack([-B, np.eye(2)]), np.hstack([np.zeros((2, 1)), -A])
E = (sp.kron(sp.eye(N), now) + sp.kron(sp.eye(N, k=-1), last)).tocsc()
C, bound = sp.eye(3 * N, format="csc"), np.tile([1.0, 0.5, 0.4], N)


def solver(warm):
    made = qp.sparse.QP(3 * N, 2 * N, 3 * N)
    s = made.settings
    s.eps_abs, s.eps_rel, s.check_duality_gap = 1e-9, 0.0, True
    s.eps_duality_gap_abs, s.eps_duality_gap_rel = 1e-8, 0.0
    if warm:
        s.initial_guess = qp.InitialGuess.WARM_START_WITH_PREVIOUS_RESULT
    return made


def broken(found):
    """Largest product of a multiplier and the distance to the bound that its sign names; None unless called solved."""
    if found.info.status != qp.QPSolverOutput.PROXQP_SOLVED:
        return None
    x, z = np.array(found.x), np.array(found.z)
    return float(np.maximum(np.maximum(z, 0) * (bound - x), np.maximum(-z, 0) * (bound + x)).max())


solved = [0, 0]
wrong, gap, off, cold_worst = 0, 0.0, 0.0, 0.0
for seed in range(6):
    rng, x0, target = np.random.default_rng(seed), np.zeros(2), 0.0
    warm = solver(True)
    for k in range(200):
        if k % 20 == 0:
            target = rng.uniform(-0.6, 0.6)
        g, b = np.tile([0.0, -weight * target, 0.0], N), np.zeros(2 * N)
        b[:2] = A @ x0
        warm.init(H, g, E, b, C, -bound, bound) if k == 0 else warm.update(g=g, b=b)
        warm.solve()
        amount = broken(warm.results)
        x = np.array(warm.results.x)
        solved[0] += amount is not None
        if amount is not None and amount > 1e-5:
            cold = solver(False)
            cold.init(H, g, E, b, C, -bound, bound)
            cold.solve()
            right = broken(cold.results)
            if right is None:
                continue
            wrong, gap = wrong + 1, max(gap, amount)
            cold_worst, off = max(cold_worst, right), max(off, abs(x[0] - cold.results.x[0]))
            print(f"seed {seed}, problem {k}: {warm.results.info.iter} iterations, own gap {warm.results.info.duality_gap:.0e},"
                  f" complementarity {amount:.1e}; cold {right:.0e}; first inputs {x[0]:.4f} and {cold.results.x[0]:.4f}")
        x0 = x[1:3]
print(f"proxsuite {proxsuite.__version__}: of {solved[0]} answers called solved, {wrong} break complementarity by up to {gap:.1e}")
print(f"cold, these {wrong} problems break it by {cold_worst:.0e} at most; first inputs differ by up to {off:.2g} of 1")
sys.exit(0 if wrong and gap > 1e-4 and cold_worst < 1e-7 else 1)
PYTHON
