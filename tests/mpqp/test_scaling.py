"""A law, its membership and its proof are the same in whatever units the problem is written.

Measured in the problem's own units, tolerances would be met by wrong answers in one unit and missed by
right ones in another.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.mpqp import InvalidProblem, Law, ParametricQp, enumerate_regions, separate, verify
from otolith.mpqp.equality import eliminate
from otolith.mpqp.problem import NoRegions
from tests.mpqp.models import random_problem

KINDS = ("z", "each z", "row", "each row", "cost", "theta", "each theta")
EXPONENTS = st.one_of(st.floats(-9.0, -6.0), st.floats(6.0, 9.0))


def in_other_units(problem: ParametricQp, kind: str, exponent: float) -> ParametricQp:
    """The same problem with z, rows, cost or θ multiplied by 10^exponent, or each by its own part of it."""
    n, m, p = len(problem.f), len(problem.w), len(problem.lower)

    def factors(what: str, size: int) -> np.ndarray:
        spread = {f"{what}": np.ones(size), f"each {what}": np.linspace(0.0, 1.0, size)}
        return np.asarray(10.0 ** (exponent * spread.get(kind, np.zeros(size))))

    z, rows, theta, cost = factors("z", n), factors("row", m), factors("theta", p), factors("cost", 1)
    return ParametricQp(
        H=cost * problem.H * np.outer(z, z), F=cost * problem.F * np.outer(z, theta), f=cost * problem.f * z,
        G=problem.G * np.outer(rows, z), w=problem.w * rows, S=problem.S * np.outer(rows, theta),
        lower=problem.lower / theta, upper=problem.upper / theta,
    )  # fmt: skip


def half_infeasible(seed: int) -> ParametricQp:
    """A random problem with a wide box, of which only a part is feasible."""
    problem = random_problem(seed, 3, 9, 2)
    return replace(problem, lower=3 * problem.lower, upper=3 * problem.upper)


def regions(law: Law) -> set[tuple[int, ...]]:
    return {tuple(law.active(r).tolist()) for r in range(len(law))}


LAWS = {seed: enumerate_regions(half_infeasible(seed)) for seed in (0, 2)}


@settings(deadline=None, max_examples=25, derandomize=True)
@given(seed=st.sampled_from(sorted(LAWS)), kind=st.sampled_from(KINDS), exponent=EXPONENTS)
def test_units_change_neither_law_nor_membership_nor_verdict(seed: int, kind: str, exponent: float) -> None:
    law = LAWS[seed]
    problem = in_other_units(law.problem, kind, exponent)
    other = enumerate_regions(problem)
    assert regions(other) == regions(law)
    at = np.random.default_rng(seed).uniform(-1.0, 1.0, (400, 2))
    ours, theirs = (one.evaluate_many(one.form.centre + one.form.half * at) for one in (law, other))
    assert 0 < ours.found.sum() < len(at)
    np.testing.assert_array_equal(ours.found, theirs.found)
    assert verify(other, 100, np.random.default_rng(seed)).passed


def vertices(curvature: float) -> ParametricQp:
    """A linear program in two variables with a little curvature: its answers are vertices (H = 1e-6 I)."""
    return ParametricQp(
        H=curvature * np.eye(2), F=np.zeros((2, 2)), f=np.array([-2.0, -1.0]),
        G=np.array([[1.0, 3.0], [2.0, 1.0], [1.0, 0.0], [-1.0, 0.0], [0.0, -1.0]]),
        w=np.array([9.0, 8.0, 4.0, 0.0, 0.0]),
        S=np.array([[-2.0, 1.0], [1.0, -2.0], [1.0, 1.0], [0.0, 0.0], [0.0, 0.0]]),
        lower=np.full(2, -10.0), upper=np.full(2, 10.0),
    )  # fmt: skip


@pytest.mark.parametrize("curvature", [1e-2, 1e-6, 1e-7])
def test_little_curvature_makes_no_parameter_feasible_that_is_not(curvature: float) -> None:
    """The law of the linear program has five regions, its feasible set θ1 + θ2 ≥ -4 and three more sides."""
    law = enumerate_regions(vertices(curvature))
    assert len(law) == 5
    assert verify(law, 1000, np.random.default_rng(0)).passed
    for beyond, feasible in ((1e-6, True), (-1e-6, False)):
        assert law.evaluate(np.array([-3.7, -0.3 + beyond])).found == feasible


@pytest.mark.parametrize("curvature", [1e-9, 1e-10, 1e-12])
def test_so_little_that_rounding_would_decide_is_refused(curvature: float) -> None:
    with pytest.raises(InvalidProblem, match="too little curvature for its slope"):
        enumerate_regions(vertices(curvature))


@pytest.mark.parametrize("bound", [1e6, 1e10, 1e15])
def test_rows_that_stand_for_no_bound_at_all_change_nothing(bound: float) -> None:
    law = LAWS[0]
    problem, n = law.problem, len(law.problem.f)
    far = replace(
        problem,
        G=np.vstack([problem.G, np.eye(n), -np.eye(n)]),
        w=np.append(problem.w, np.full(2 * n, bound)),
        S=np.vstack([problem.S, np.zeros((2 * n, 2))]),
    )
    other = enumerate_regions(far)
    assert regions(other) == regions(law)
    assert verify(other, 200, np.random.default_rng(0)).passed


def test_a_variable_in_a_small_unit_is_curved_all_the_same() -> None:
    unit = np.array([1.0, 1e-9])
    problem = random_problem(0, 2, 4, 1)
    replace(problem, H=problem.H * np.outer(unit, unit))
    with pytest.raises(InvalidProblem, match="positive definite"):
        replace(problem, H=np.outer(unit, unit))


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_equalities_contradict_each_other_in_any_unit(scale: float) -> None:
    problem = random_problem(0, 3, 4, 1)
    fields = {n: np.array(getattr(problem, n)) for n in ("H", "F", "f", "G", "w", "S", "lower", "upper")}
    row, B = np.array([[1.0, 2.0, 3.0]]), np.zeros((2, 1))
    rows = scale * np.vstack([row, row])
    with pytest.raises(NoRegions, match="contradict"):
        eliminate(**fields, A=rows, b=scale * np.array([0.0, 1e-6]), B=B)
    assert eliminate(**fields, A=rows, b=scale * np.array([0.1, 0.1]), B=B).Y.shape == (3, 2)


def test_parts_are_found_whatever_a_row_is_multiplied_by() -> None:
    """Two problems side by side; the only row that joins them is 1e-13 times as large as the others."""
    one, two = random_problem(0, 2, 3, 1), random_problem(1, 2, 3, 1)
    H, G, S, F = np.zeros((4, 4)), np.zeros((7, 4)), np.zeros((7, 2)), np.zeros((4, 2))
    for k, part in enumerate((one, two)):
        z, rows = slice(2 * k, 2 * k + 2), slice(3 * k, 3 * k + 3)
        H[z, z], F[z, k], G[rows, z], S[rows, k] = part.H, part.F[:, 0], part.G, part.S[:, 0]
    G[6] = 1e-13
    w = np.concatenate([one.w, two.w, [1e-13]])
    joined = ParametricQp(
        H=H, F=F, f=np.concatenate([one.f, two.f]), G=G, w=w, S=S, lower=-np.ones(2), upper=np.ones(2)
    )
    assert len(separate(joined)) == 1
    assert len(separate(replace(joined, G=G[:6], w=w[:6], S=S[:6]))) == 2
