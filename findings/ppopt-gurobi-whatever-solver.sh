#!/bin/sh
# PPOPT 1.6.12: explicit laws call Gurobi whatever solver is named, and end in a NameError where it is not installed.
#
# PPOPT's `Solver({"lp": "glpk", "qp": "quadprog"})` names free solvers, and `import ppopt` works without gurobipy,
# whose free licence is restricted and ends. But `CriticalRegion.is_full_dimension` calls `chebyshev_ball` without a
# solver, and the default there is "gurobi": `solve_mpqp` ends in "name 'gp' is not defined" on any problem. Who wants
# free solvers only has to replace that default (second part), and then gets the law; with gurobipy installed
# the licence is used unseen.
#
# Run by hand. Exits 0 while this holds, 1 once it does not.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet numpy scipy numba "cvxopt==1.3.2" "quadprog==0.1.14" "pathos==0.3.4"
"$folder/venv/bin/pip" install --quiet --no-deps "ppopt==1.6.12"  # it names gurobipy as needed
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import sys
from functools import partial
from importlib.util import find_spec

import numpy as np
from ppopt import critical_region
from ppopt.mp_solvers.solve_mpqp import mpqp_algorithm, solve_mpqp
from ppopt.mpqp_program import MPQP_Program
from ppopt.solver import Solver


def regions() -> int:
    """min (x - theta)^2 / 2 over -1 <= x <= 1 for -2 <= theta <= 2: three regions, by hand."""
    one = np.array([[1.0]])
    bounds, box = np.array([[1.0], [-1.0]]), np.array([[2.0], [2.0]])
    program = MPQP_Program(
        bounds, np.ones((2, 1)), np.zeros((1, 1)), -one, one, bounds, box, np.zeros((2, 1)),
        solver=Solver({"lp": "glpk", "qp": "quadprog"}),
    )  # fmt: skip
    return len(solve_mpqp(program, mpqp_algorithm.graph).critical_regions)


print("gurobipy is", "installed" if find_spec("gurobipy") else "absent")
try:
    said = f"{regions()} regions"
except NameError as error:
    said = f"NameError: {error}"
print("solvers named are glpk and quadprog:", said)
critical_region.chebyshev_ball = partial(critical_region.chebyshev_ball, deterministic_solver="glpk")
found = regions()
print("the default of chebyshev_ball replaced by glpk:", found, "regions")
sys.exit(0 if said == "NameError: name 'gp' is not defined" and found == 3 else 1)
PYTHON
