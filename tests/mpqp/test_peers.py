"""PPOPT 1.6.12 as an oracle: another implementation of explicit MPC gives the same law.

Its count is not compared. On blocked N = 5 it reports 1049 to 1055 regions, depending on the run, where
ours are 953 (radius 1e-7): it counts thinner ones, and some of its regions overlap. The laws agree.
It takes a minute or two.

PPOPT names gurobipy, whose free licence is restricted and ends, as a dependency; it runs without, on the
free solvers that are named below:
`pip install cvxopt pathos && pip install --no-deps ppopt`.
"""

from functools import partial

import numpy as np
import pytest

from otolith.mpqp import Law

for name in ("cvxopt", "pathos", "ppopt"):
    pytest.importorskip(name, reason=f"{name} is not installed, see the docstring")


@pytest.mark.filterwarnings("ignore")
def test_ppopt_finds_the_same_law_on_blocked_horizon_five(
    blocked: Law, monkeypatch: pytest.MonkeyPatch
) -> None:
    from ppopt import critical_region
    from ppopt.mp_solvers.solve_mpqp import mpqp_algorithm, solve_mpqp
    from ppopt.mpqp_program import MPQP_Program
    from ppopt.solver import Solver

    P, p = blocked.problem, 5
    box = np.vstack([np.eye(p), -np.eye(p)])
    b, c, level = (v.reshape(-1, 1) for v in (P.w, P.f, np.r_[P.upper, -P.lower]))
    free = Solver({"lp": "glpk", "qp": "daqp"})
    ball = partial(critical_region.chebyshev_ball, deterministic_solver="glpk")  # gurobi, whatever one names
    monkeypatch.setattr(critical_region, "chebyshev_ball", ball)
    program = MPQP_Program(
        np.array(P.G), b, c, np.array(P.F), np.array(P.H), box, level, np.array(P.S), solver=free
    )
    theirs = solve_mpqp(program, mpqp_algorithm.graph)
    assert len(theirs.critical_regions) >= len(blocked)

    thetas = np.random.default_rng(0).uniform(P.lower, P.upper, (2000, p))
    ours = blocked.locate_many(thetas)
    E = np.vstack([region.E for region in theirs.critical_regions])
    f = np.vstack([region.f for region in theirs.critical_regions]).ravel()
    start = np.cumsum([0] + [len(region.E) for region in theirs.critical_regions])
    compared = 0
    for theta, z, found in zip(thetas, ours.z, ours.found, strict=True):
        holds = np.maximum.reduceat(E @ theta - f, start[:-1]) <= 0.0
        assert found or not holds.any()
        for r in np.flatnonzero(holds):
            region = theirs.critical_regions[r]
            np.testing.assert_allclose(region.A @ theta + region.b.ravel(), z, rtol=0.0, atol=1e-6)
            compared += 1
    assert compared > 0.95 * ours.found.sum()
