"""Half-spaces of regions in 64 bits, computed from their active sets in plain numpy, for few regions at a
time.

The notation is that of `leastdistance`. The code is independent of the compiled kernels, so each checks the
other.
"""

import numpy as np

from otolith.core.arrays import Ints, Mat
from otolith.mpqp.leastdistance import LeastDistance


def affine_multipliers(form: LeastDistance, A: Ints) -> Mat:
    """Return λ_A as an affine function of τ: (k, p + 1), the constant in the last column."""
    return np.asarray(-np.linalg.solve(form.Q[np.ix_(A, A)], form.d[:, A].T), dtype=np.float64)


def affine_slacks(form: LeastDistance, A: Ints) -> Mat:
    """Return the slack as an affine function of τ: (m, p + 1), the constant in the last column."""
    result: Mat = form.d.T + form.Q[:, A] @ affine_multipliers(form, A)
    return result


def exact_rows(form: LeastDistance, A: Ints, constraints: Ints) -> Mat:
    """Unit half-spaces a'τ ≤ b as rows (a, b) for the given constraints: λ ≥ 0 if active, else slack ≥ 0."""
    lam, slack = affine_multipliers(form, A), affine_slacks(form, A)
    place = {int(i): a for a, i in enumerate(A)}
    rows = np.array([lam[place[int(i)]] if int(i) in place else slack[i] for i in constraints])
    rows = rows.reshape(len(constraints), form.d.shape[0]) * np.append(-np.ones(len(form.half)), 1.0)
    unit: Mat = rows / np.linalg.norm(rows[:, :-1], axis=1, keepdims=True)
    return unit
