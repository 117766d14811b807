"""Time of one lookup in an explicit law, along trajectories and at random parameters.

    .venv/bin/python benchmarks/mpqp_lookup.py [blocked-5 5 blocked-20 10]

Microseconds of thread CPU time per query. Every query is repeated and the best of three runs taken,
so that the tail shows expensive parameters, not a busy machine. "kernel": compiled code, as a loop in
compiled code or the C export sees it, minimiser, multipliers and optimality check included; "Python":
`Law.evaluate`. Walks start from the last answer's region; for the kernel the time is the mean of going
there and back. "cold" has no region to start from: the QP is solved.
"""

import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import SURGE_PITCH
from otolith.core.lti import zero_order_hold
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_problem
from otolith.cueing.mpc.motion import explicit_dynamics
from otolith.files import read_platform
from otolith.mpqp import Law, enumerate_regions

PERIOD = 0.1
CASES = {"blocked-5": (5, 2), "5": (5, None), "blocked-20": (20, 2), "10": (10, None)}
REPEATS, CALLS, POINTS = 100, 30, 2000


def law_of(case: str) -> Law:
    horizon, block_from = CASES[case]
    settings = ExplicitSettings(horizon=horizon, period=PERIOD, block_from=block_from)
    thesis = read_platform("thesis")
    problem = explicit_problem(SURGE_PITCH, thesis.limits(SURGE_PITCH), thesis.braking, settings)
    return enumerate_regions(problem)


def trajectory(law: Law, steps: int, seed: int) -> Mat:
    """Closed loop under sums of six sines, a new one every minute: parameters (steps, 5)."""
    A, B = zero_order_hold(*explicit_dynamics(SURGE_PITCH), PERIOD)
    low, high = law.problem.lower[:4], law.problem.upper[:4]
    rng, x, region, thetas = np.random.default_rng(seed), np.zeros(4), -1, []
    for t in range(steps):
        if t % 600 == 0:
            rate, phase = rng.uniform(0.03, 1.0, 6), rng.uniform(0.0, 2 * np.pi, 6)
            size = rng.uniform(0.1, 1.2, 6) * rng.uniform(0.2, 1.0)
        theta = np.append(x, (size * np.sin(2 * np.pi * rate * PERIOD * t + phase)).sum())
        answer = law.evaluate(theta, region)
        region = answer.region
        x = np.clip(A @ x + B @ answer.z[:2], low, high) if answer.found else np.zeros(4)
        thetas.append(theta)
    return np.array(thetas)


def feasible(law: Law, count: int, seed: int) -> Mat:
    """Random parameters that have an answer, whole box."""
    problem = law.problem
    thetas = np.random.default_rng(seed).uniform(
        problem.lower, problem.upper, (3 * count, len(problem.lower))
    )
    found: Mat = thetas[law.evaluate_many(thetas).found][:count]
    return found


def best(run: Callable[[], object]) -> float:
    """Least thread CPU time of three runs [us]."""
    taken = []
    for _ in range(3):
        start = time.thread_time_ns()
        run()
        taken.append(time.thread_time_ns() - start)
    return min(taken) / 1e3


def in_kernel(law: Law, thetas: Mat) -> Vec:
    """Microseconds per query of consecutive pairs, the cost of the call itself taken off."""
    call = best(lambda: law.evaluate_many(thetas[:0]))
    times = []
    for i in range(1, len(thetas), max(1, len(thetas) // POINTS)):
        many, first = np.tile(thetas[i - 1 : i + 1], (REPEATS, 1)), law.evaluate(thetas[i]).region
        taken = best(partial(law.evaluate_many, many, first))
        times.append((taken - call) / len(many))
    return np.array(times)


def queries(law: Law, theta: Vec, start: int) -> None:
    """The same query many times: one alone is too short for the clock."""
    for _ in range(CALLS):
        law.evaluate(theta, start)


def in_python(law: Law, thetas: Mat, walking: bool) -> Vec:
    times = []
    for i in range(1, len(thetas), max(1, len(thetas) // POINTS)):
        theta, start = thetas[i], law.evaluate(thetas[i - 1]).region if walking else -1
        times.append(best(partial(queries, law, theta, start)) / CALLS)
    return np.array(times)


def main(cases: list[str]) -> None:
    heads = "".join(f"{head:>8}" for head in ("median", "p99", "p99.9", "max"))
    print(f"{'law':<11}{'regions':>8}  {'parameters':<12}{'where':<8}{heads}")
    for case in cases or list(CASES):
        law = law_of(case)
        along, anywhere = trajectory(law, 6000, 0), feasible(law, 4000, 1)
        rows = (
            ("trajectory", "kernel", in_kernel(law, along)),
            ("trajectory", "Python", in_python(law, along, True)),
            ("random", "kernel", in_kernel(law, anywhere)),
            ("random", "Python", in_python(law, anywhere, True)),
            ("random, cold", "Python", in_python(law, anywhere, False)),
        )
        for name, where, times in rows:
            cells = "".join(f"{value:8.2f}" for value in np.percentile(times, (50, 99, 99.9, 100)))
            print(f"{case:<11}{len(law):>8}  {name:<12}{where:<8}{cells}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
