"""The certificate and the dense engine on random problems of known answer, each in twelve systems of units.

Right answers, off by 1e-9 of each number, must pass; wrong ones must not: zero, points beside the answer by
1e-4 to 1 of each number, multipliers changed by 1e-3, one multiplier turned round, a maximum (the problem
with its cost turned round). What the engine calls optimal must have the known value of the cost, relative
to the sum of its absolute terms. Run: python -m benchmarks.certificate [problems] [problems for the engine]
"""

import sys
from collections import Counter

import numpy as np
from tests.qp.qp_problems import KINDS, Known, known_qp, twelve_units

from otolith.core.arrays import Vec
from otolith.qp import DenseSolver, Qp, Status, kkt_residual

TOLERANCE = 1e-6


def wrong(rng: np.random.Generator, known: Known) -> dict[str, tuple[Qp, Vec, Vec]]:
    """Answers that must be refused, by kind; none that the cost cannot tell from the right one."""
    qp, z, y = known.qp, known.z, known.y
    n = len(z)
    answers = {"zero": (qp, np.zeros(n), np.zeros(len(y)))}
    beside = z * (1.0 + 10.0 ** rng.uniform(-4, 0) * rng.choice([-1.0, 1.0], n))
    moved = np.abs(qp.H @ (beside - z))
    terms = np.abs(qp.H) @ np.abs(z) + np.abs(qp.g)
    if (moved > 1e-5 * terms).any():
        answers["beside"] = (qp, beside, y)
    if (y != 0.0).any():
        answers["multipliers"] = (qp, z, y * (1.0 + 1e-3 * rng.choice([-1.0, 1.0], len(y))))
        turned = y.copy()
        turned[rng.choice(np.flatnonzero(y))] *= -1.0
        answers["turned"] = (qp, z, turned)
    answers["maximum"] = (Qp(-qp.H, -qp.g, qp.A, qp.lower, qp.upper), z, -y)
    return answers


def engine(known: Known) -> str:
    """What the engine says: optimal, wrongly optimal, or another status."""
    found = DenseSolver().solve(known.qp)
    if found.status is not Status.OPTIMAL:
        return found.status.value
    H, g = known.qp.H, known.qp.g
    terms = np.abs(known.z) @ (np.abs(H) @ np.abs(known.z) + np.abs(g))
    off = (0.5 * found.z @ H @ found.z + g @ found.z) - (0.5 * known.z @ H @ known.z + g @ known.z)
    return "optimal" if abs(off) <= 1e-6 * terms else "wrongly optimal"


def main(problems: int, solved: int) -> None:
    rng, counts, engines = np.random.default_rng(1), Counter[str](), Counter[str]()
    for number in range(problems):
        for known in twelve_units(rng, known_qp(rng, KINDS[number % len(KINDS)])):
            n = len(known.z)
            off = 1.0 + 1e-9 * rng.uniform(-1, 1, n + len(known.y))
            passed = kkt_residual(known.qp, known.z * off[:n], known.y * off[n:]) < TOLERANCE
            counts["right, passed" if passed else "right, REFUSED"] += 1
            for kind, answer in wrong(rng, known).items():
                passed = kkt_residual(*answer) < TOLERANCE
                counts[f"wrong ({kind}), {'PASSED' if passed else 'refused'}"] += 1
            if number < solved:
                engines[engine(known)] += 1
    for name, count in sorted(counts.items()):
        print(f"{count:8d} {name}")
    print("engine:", dict(engines))


if __name__ == "__main__":
    given = [int(text) for text in sys.argv[1:3]]
    main(given[0] if given else 5000, given[1] if len(given) > 1 else 500)
