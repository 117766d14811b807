"""Random convex QPs whose answer is known by construction, in any units; a helper of the tests."""

from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Vec
from otolith.qp import Qp

KINDS = ("plain", "equalities", "degenerate", "ill-conditioned", "weak")


@dataclass(frozen=True, slots=True)
class Known:
    """A problem with its answer."""

    qp: Qp
    z: Vec  # (n,)
    y: Vec  # (b + m,)


def known_qp(rng: np.random.Generator, kind: str) -> Known:
    """A problem built around its answer: rows, multipliers and point are drawn first, then bounds and g
    follow.

    In degenerate ones more rows than variables meet at the point, some of them with no multiplier; weak
    ones have a singular H, so that the multipliers must hold the point.
    """
    n, m, b = map(int, (rng.integers(2, 10), rng.integers(1, 15), rng.integers(0, 3)))
    root = rng.standard_normal((n, n))
    if kind == "ill-conditioned":
        root = root @ np.diag(10.0 ** rng.uniform(-4, 0, n))
    if kind == "weak":
        root = root[:, : max(1, n // 2)]
    H, A, z = root @ root.T, rng.standard_normal((m, n)), rng.standard_normal(n)
    R = np.vstack([np.eye(b, n), A])
    active = rng.random(b + m) < (1.0 if kind == "degenerate" else min(1.0, 0.5 * n / (b + m)))
    side = rng.choice([-1.0, 1.0], b + m)
    y = np.where(active, side * rng.uniform(0.1, 3.0, b + m), 0.0)
    if kind == "degenerate":
        y[rng.random(b + m) < 0.5] = 0.0
    r, room = R @ z, rng.uniform(0.05, 2.0, (2, b + m))
    lower = np.where(active & (side < 0), r, r - room[0])
    upper = np.where(active & (side > 0), r, r + room[1])
    if kind == "equalities":
        lower[active], upper[active] = r[active], r[active]
    away = rng.random((2, b + m)) < 0.2
    lower[away[0] & ~(active & ((side < 0) | (lower == upper)))] = -np.inf
    upper[away[1] & ~(active & ((side > 0) | (lower == upper)))] = np.inf
    return Known(Qp(H, -(H @ z + R.T @ y), A, lower, upper), z, y)


def in_units(known: Known, of_variables: Vec, of_rows: Vec, of_cost: float) -> Known:
    """The same problem with z = d z', the rows of A times e and the cost times c."""
    qp, d = known.qp, of_variables
    E = np.concatenate([1.0 / d[: qp.bounds], of_rows])
    scaled = Qp(
        of_cost * d[:, None] * qp.H * d,
        of_cost * d * qp.g,
        of_rows[:, None] * qp.A * d,
        E * qp.lower,
        E * qp.upper,
    )
    return Known(scaled, known.z / d, of_cost * known.y / E)


def twelve_units(rng: np.random.Generator, known: Known) -> list[Known]:
    """Variables, rows and cost times 1e±9, apart and together, and each of them by its own factor."""
    n, m, big = len(known.z), len(known.qp.A), 1e9
    one, rows = np.ones(n), np.ones(m)
    plain = [(big, 1, 1), (1 / big, 1, 1), (1, big, 1), (1, 1 / big, 1), (1, 1, big), (1, 1, 1 / big)]
    plain += [(big, 1 / big, big), (1 / big, big, 1 / big), (big, big, 1 / big)]
    chosen = [in_units(known, d * one, e * rows, c) for d, e, c in plain]
    for _ in range(3):
        of_variables, of_rows = 10.0 ** rng.uniform(-9, 9, n), 10.0 ** rng.uniform(-9, 9, m)
        chosen.append(in_units(known, of_variables, of_rows, 10.0 ** rng.uniform(-9, 9)))
    return chosen
