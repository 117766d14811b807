"""Random states and references, mild to absurd, at the structured engine; every answer is judged afresh.

Counts what came back, and anything that must not: a non-finite answer, or one called solved that the
readable certificate of `otolith.qp.stage` does not confirm. Run: python benchmarks/hostile.py [problems]
"""

import sys
import time

import numpy as np

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import load
from otolith.qp import Status
from otolith.qp.engines import StructuredEngine, expand
from otolith.qp.stage import stage_residual

TOLERANCE = 1e-6


def hostile(pairs, problems: int, seed: int, platform: str = "thesis") -> dict[str, float]:  # type: ignore[no-untyped-def]
    """Counts over `problems` random problems of one set of pairs."""
    rng = np.random.default_rng(seed)
    settings = MpcSettings()
    formulation = Problem(load(platform), pairs, settings)
    engine = StructuredEngine(formulation.structure, tolerance=TOLERANCE)
    formulation.begin(engine.memory)
    P, N = len(pairs), settings.horizon
    scale = np.tile([0.05, 0.5, 1.0, 0.5, 3.0, 3.0], P)
    counts = {status.value: 0 for status in Status} | {"not finite": 0, "wrongly called solved": 0}
    slowest = 0.0
    for _ in range(problems):
        x = scale * rng.normal(size=6 * P) * rng.choice([0.01, 0.1, 1.0, 10.0])
        wanted = np.tile(rng.normal(size=P) * rng.choice([0.1, 1.0, 10.0, 1e3]), (N, 1))
        if rng.random() < 0.02:
            x[rng.integers(6 * P)] = rng.choice([np.nan, np.inf, -np.inf, 1e12])
        plan = rng.normal(size=(N, 2 * P)) * rng.choice([0.0, 1.0, 5.0])
        formulation.write(engine.memory, x, plan, wanted, None)
        started = time.thread_time()
        solution = engine.run()
        slowest = max(slowest, time.thread_time() - started)
        counts[solution.status.value] += 1
        counts["not finite"] += not np.isfinite(solution.U).all()
        if solution.status is Status.OPTIMAL:
            residual = stage_residual(expand(formulation.structure, engine.memory), solution.U, solution.y)
            counts["wrongly called solved"] += not residual < 2 * TOLERANCE
    return {**counts, "handed to daqp": engine.undecided, "slowest_ms": round(1e3 * slowest, 2)}


if __name__ == "__main__":
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    for chosen in ((SURGE_PITCH,), (SURGE_PITCH, SWAY_ROLL)):
        print(", ".join(pair.name for pair in chosen), hostile(chosen, n, seed=1))
