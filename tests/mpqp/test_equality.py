"""Equality constraints are eliminated without changing the solution."""

import daqp
import numpy as np
import pytest

from otolith.mpqp import InvalidProblem, NoRegions, enumerate_regions
from otolith.mpqp.equality import eliminate
from tests.mpqp.models import random_problem


def data(seed: int, rows: int) -> dict[str, np.ndarray]:
    problem, rng = random_problem(seed, 4, 6, 2), np.random.default_rng(seed)
    fields = {
        name: np.array(getattr(problem, name)) for name in ("H", "F", "f", "G", "w", "S", "lower", "upper")
    }
    return fields | {
        "A": rng.standard_normal((rows, 4)), "b": np.zeros(rows), "B": 0.1 * rng.standard_normal((rows, 2))
    }  # fmt: skip


@pytest.mark.parametrize("repeat", [False, True])
def test_law_with_equalities_equals_an_independent_qp(repeat: bool) -> None:
    d = data(0, 2)
    if repeat:  # a dependent row
        for name in ("A", "b", "B"):
            d[name] = np.concatenate([d[name], d[name][:1] * 2])
    reduced = eliminate(**d)
    law = enumerate_regions(reduced.problem)
    G, kinds = np.vstack([d["G"], d["A"]]), np.array([0] * 6 + [5] * len(d["A"]), dtype=np.int32)
    for theta in np.random.default_rng(1).uniform(d["lower"], d["upper"], (200, 2)):
        right = d["b"] + d["B"] @ theta
        above, below = np.append(d["w"] + d["S"] @ theta, right), np.append(np.full(6, -1e30), right)
        z, _, flag, _ = daqp.solve(d["H"], d["f"] + d["F"] @ theta, G, above, below, kinds, primal_tol=1e-11)
        answer = law.evaluate(theta)
        assert answer.found == (flag >= 1)
        if answer.found:
            np.testing.assert_allclose(reduced.lift(answer.z, theta), z, atol=1e-7)


def test_contradicting_equalities_are_refused() -> None:
    d = data(0, 1)
    d |= {"A": np.vstack([d["A"], d["A"]]), "b": np.array([0.0, 1.0]), "B": np.zeros((2, 2))}
    with pytest.raises(NoRegions, match="contradict"):
        eliminate(**d)


def test_equalities_that_fix_everything_are_refused() -> None:
    with pytest.raises(InvalidProblem, match="fix all 4"):
        eliminate(**data(0, 4))
