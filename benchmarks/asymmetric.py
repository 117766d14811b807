"""First inputs of the structured engine against daqp on random platforms, reach 5 mm to 20 m on either side.

States lie anywhere within the limits, or at the edge of what is feasible (found by bisection, then a part of
1e-9 to 0.1 inside), references from 0.1 to 1000 m/s²; between them the loop is closed. Printed are how often
who calls a problem what, the largest differences, and what an answer is worth: the cost, the violation, and
√(2 Σ|y (r − b)| / R), beyond which the inputs cannot be from the optimum's.

Run: python benchmarks/asymmetric.py [seconds] [seed]
"""

import sys
import time
from collections import Counter

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.rows import Limits
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Platform
from otolith.qp import Status
from otolith.qp.condensed import CondensedSolver
from otolith.qp.dense import DenseSolver
from otolith.qp.engines import StructuredEngine, expand
from otolith.qp.stage import StageQp, StageSolution, cost, rollout, row_values

TOLERANCE = 1e-6
EDGE = (0.0, 1e-9, 1e-7, 1e-5, 1e-3, 0.1)  # how far inside the feasible states, as a part
STEPS = 40  # decisions on one platform
WORTH_TELLING = 1e-5  # difference of first inputs [rad/s², m/s²]


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """One of the ends as often as one in three, else anything between them on a scale of factors."""
    return float(rng.choice([low, high]) if rng.random() < 0.3 else np.exp(rng.uniform(*np.log([low, high]))))


def any_platform(rng: np.random.Generator) -> Platform:
    c_u, ratios = between(rng, 0.01, 9.9), [between(rng, 1.0001, 10.0) for _ in range(2)]
    c_v, c_w = (min(9.9, np.sqrt(2.0 * c_u) * ratio) for ratio in ratios)
    times = {"position_s": between(rng, 0.05, 20.0), "tilt_s": between(rng, 0.05, 20.0)}
    sound = min(c_v, c_w) ** 2 > 2.0 * c_u and rng.random() < 0.5
    fields = {
        "name": "random",
        "surge": {
            "position_m": [-between(rng, 0.005, 20.0), between(rng, 0.005, 20.0)],
            "velocity_mps": between(rng, 0.005, 20.0),
            "acceleration_mps2": between(rng, 0.05, 50.0),
        },
        "pitch": {
            "angle_deg": [-between(rng, 1.0, 89.0), between(rng, 1.0, 89.0)],
            "acceleration_degps2": between(rng, 5.0, 10_000.0),
        },
        "tilt_coordination": {"pitch_degps": between(rng, 0.5, 10.0)},
        "braking": {"c_u": c_u, "c_v": c_v, "c_w": c_w, **times} if sound else {},
    }
    return Platform.model_validate(fields)


def any_state(rng: np.random.Generator, limits: Limits) -> Vec:
    travel, tilt = limits
    ends = [
        rng.choice(end) * rng.random() * rng.choice([1.0, 0.1, 0.0])
        for end in (tilt.position, travel.position)
    ]
    rest = rng.uniform(-1.0, 1.0, 4) * (rng.random(4) < 0.6)
    bounds = [tilt.velocity, travel.velocity, travel.acceleration, min(tilt.acceleration, 10.0)]
    rate, speed, acceleration, turning = rest * bounds
    return np.array([rate, ends[0], speed, ends[1], acceleration, turning])


class Contest:
    """One platform, both solvers, and the problem that both are given."""

    def __init__(self, rng: np.random.Generator) -> None:
        platform = any_platform(rng)
        self.weight = between(rng, 1e-6, 1.0) if rng.random() < 0.5 else 1e-3
        self.limits = platform.limits(SURGE_PITCH)
        self.mpc = Problem(platform, (SURGE_PITCH,), MpcSettings(control_weight=self.weight))
        problem = self.mpc.structure
        self.ours = StructuredEngine(problem, tolerance=TOLERANCE)
        self.theirs = CondensedSolver(problem, DenseSolver(tolerance=TOLERANCE, primal_tolerance=1e-11))
        self.mpc.begin(self.ours.memory)

    def solve(self, x: Vec, plan: Mat, wanted: Mat) -> StageSolution:
        self.mpc.write(self.ours.memory, x, plan, wanted, None)
        return self.ours.run()

    def edge(self, x: Vec, plan: Mat, wanted: Mat) -> Vec:
        """The last multiple of x, at most x itself, that is called feasible."""
        inside, outside = 0.0, 1.0
        if self.solve(x, plan, wanted).status is Status.OPTIMAL:
            return x
        for _ in range(30):
            middle = 0.5 * (inside + outside)
            solved = self.solve(middle * x, plan, wanted).status is Status.OPTIMAL
            inside, outside = (middle, outside) if solved else (inside, middle)
        return inside * x


def worth(qp: StageQp, found: StageSolution, weight: float) -> str:
    values = row_values(qp, found.U, rollout(qp, found.U))
    side = np.where(found.y > 0.0, qp.upper, qp.lower)
    held = found.y != 0.0
    gap = float(np.abs(found.y[held] * (values - side)[held]).sum())
    violation = float(np.maximum(values - qp.upper, qp.lower - values).max())
    bound = np.sqrt(2.0 * gap / weight)
    return f"cost {cost(qp, found.U, found.X):.12g}, violation {violation:.1e}, inputs within {bound:.1e}"


def main(seconds: float, seed: int) -> None:
    rng, end, counts, largest = np.random.default_rng(seed), time.monotonic() + seconds, Counter[str](), 0.0
    while time.monotonic() < end:
        contest, plan, wanted = Contest(rng), np.zeros((50, 2)), np.zeros((50, 1))
        x = np.zeros(6)
        for _ in range(STEPS):
            if rng.random() < 0.2:
                wanted = np.full((50, 1), rng.normal() * rng.choice([0.1, 1.0, 10.0, 100.0, 1000.0]))
            if rng.random() < 0.3:
                x = contest.edge(any_state(rng, contest.limits), plan, wanted) * (1.0 - rng.choice(EDGE))
            ours = contest.solve(x, plan, wanted)
            qp = expand(contest.mpc.structure, contest.ours.memory)
            theirs = contest.theirs.solve(qp, np.zeros(ours.y.shape, dtype=np.int64))
            counts[f"{ours.status} and {theirs.status}"] += 1
            if ours.status is not Status.OPTIMAL:
                x, plan = np.zeros(6), np.zeros((50, 2))
                contest.ours.reset()
                continue
            gap = float(np.abs(ours.U[0] - theirs.U[0]).max()) if theirs.status is Status.OPTIMAL else 0.0
            largest = max(largest, gap)
            if gap > WORTH_TELLING:
                print(f"{gap:.1e}: ours {worth(qp, ours, contest.weight)}", flush=True)
                print(f"         daqp {worth(qp, theirs, contest.weight)}", flush=True)
            plan, x = ours.U, contest.mpc.predicted(x, ours.U[:1])[0]
    print(f"{counts.total()} problems; first inputs differ by {largest:.1e} at most; ours and daqp's status:")
    print(", ".join(f"{what} {count}" for what, count in counts.most_common()))


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0, int(sys.argv[2]) if len(sys.argv) > 2 else 1)
