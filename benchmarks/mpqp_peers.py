"""Enumeration times of otolith and PPOPT on the same problems, in one run.

    python benchmarks/mpqp_peers.py [horizons, default 3 4 5]

The problems are the move-blocked explicit MPCs of the thesis (Ts = 0.1 s, u1 = ... = u(N-1)). Seconds
are CPU time of the whole process and wall time. Ours is the best of three runs after the kernels are
compiled; PPOPT runs once per algorithm.

PPOPT names gurobipy, whose free licence is restricted and ends, as a dependency; it runs without, on the
free solvers that are named below:
`pip install cvxopt pathos && pip install --no-deps ppopt`.
"""

import importlib.util
import sys
import time
from collections.abc import Callable, Sized
from functools import partial

import numpy as np

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_problem
from otolith.mpqp import ParametricQp, enumerate_regions
from otolith.platforms import load

ALGORITHMS = ("graph", "combinatorial", "geometric")


def blocked(horizon: int) -> ParametricQp:
    platform = load("thesis")
    settings = ExplicitSettings(horizon=horizon)
    return explicit_problem(SURGE_PITCH, platform.limits(SURGE_PITCH), platform.braking, settings)


def by_ppopt(problem: ParametricQp, algorithm: str) -> Sized:
    """PPOPT's critical regions; it writes min ½ x'Qx + θ'H'x + c'x with A x ≤ b + F θ, A_t θ ≤ b_t."""
    from ppopt import critical_region
    from ppopt.mp_solvers.solve_mpqp import mpqp_algorithm, solve_mpqp
    from ppopt.mpqp_program import MPQP_Program
    from ppopt.solver import Solver
    from ppopt.utils.chebyshev_ball import chebyshev_ball

    p = len(problem.lower)
    box = np.vstack([np.eye(p), -np.eye(p)])
    b, c, level = (v.reshape(-1, 1) for v in (problem.w, problem.f, np.r_[problem.upper, -problem.lower]))
    free = Solver({"lp": "glpk", "qp": "daqp"})
    ball = partial(chebyshev_ball, deterministic_solver="glpk")
    critical_region.chebyshev_ball = ball  # which takes gurobi, whatever one names
    data = (np.array(problem.G), b, c, np.array(problem.F), np.array(problem.H), box, level)
    program = MPQP_Program(*data, np.array(problem.S), solver=free)
    regions: list[object] = solve_mpqp(program, mpqp_algorithm[algorithm]).critical_regions
    return regions


def timed(run: Callable[[], Sized]) -> tuple[int, float, float]:
    """How many regions, CPU and wall seconds."""
    cpu, wall = time.process_time(), time.perf_counter()
    regions = run()
    return len(regions), time.process_time() - cpu, time.perf_counter() - wall


def main(horizons: list[int]) -> None:
    present = all(importlib.util.find_spec(name) for name in ("cvxopt", "pathos", "ppopt"))
    if not present:
        print("cvxopt, pathos and PPOPT are not all installed: only our times follow")
    enumerate_regions(blocked(2))  # compile
    print(f"{'problem':<12}{'solver':<22}{'regions':>8}{'CPU s':>10}{'wall s':>10}{'ratio of CPU':>14}")
    for horizon in horizons:
        problem, name = blocked(horizon), f"blocked N={horizon}"
        runs = [timed(partial(enumerate_regions, problem)) for _ in range(3)]
        ours = min(runs, key=lambda run: run[1])
        print(f"{name:<12}{'otolith':<22}{ours[0]:>8}{ours[1]:>10.3f}{ours[2]:>10.3f}{1:>14}", flush=True)
        for algorithm in ALGORITHMS if present else ():
            label = f"PPOPT {algorithm}"
            try:
                count, cpu, wall = timed(partial(by_ppopt, problem, algorithm))
            except np.linalg.LinAlgError as error:
                print(f"{name:<12}{label:<22}  failed: {error}", flush=True)
                continue
            print(
                f"{name:<12}{label:<22}{count:>8}{cpu:>10.3f}{wall:>10.3f}{cpu / ours[1]:>14.0f}", flush=True
            )


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [3, 4, 5])
