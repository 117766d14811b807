"""Refusal of data that are not a strictly convex parametric QP."""

from dataclasses import fields, replace

import numpy as np
import pytest

from otolith.mpqp import InvalidProblem, NoRegions, ParametricQp, enumerate_regions
from tests.mpqp.models import random_problem, saturated_line


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"H": np.zeros((1, 1))}, "must be positive definite"),
        ({"H": -np.ones((1, 1))}, "must be positive definite"),
        ({"H": np.ones((1, 2))}, "H has shape"),
        ({"F": np.full((1, 1), np.nan)}, "F holds a value that is not finite"),
        ({"w": np.array([np.inf, 1.0])}, "w holds a value that is not finite"),
        ({"S": np.zeros((3, 1))}, "S has shape"),
        ({"upper": np.array([-2.0])}, "must be a proper interval"),
        ({"f": np.zeros((1, 1))}, "must be vectors"),
    ],
)
def test_wrong_data_are_refused(change: dict[str, np.ndarray], words: str) -> None:
    with pytest.raises(InvalidProblem, match=words):
        replace(saturated_line(), **change)


def test_an_asymmetric_hessian_is_refused() -> None:
    problem = random_problem(0, 2, 3, 1)
    with pytest.raises(InvalidProblem, match="transpose"):
        replace(problem, H=problem.H + np.array([[0.0, 1.0], [0.0, 0.0]]))


def test_at_gives_the_ordinary_qp() -> None:
    problem = random_problem(1, 2, 3, 2)
    g, b = problem.at(np.array([1.0, -2.0]))
    np.testing.assert_allclose(g, problem.f + problem.F[:, 0] - 2 * problem.F[:, 1])
    np.testing.assert_allclose(b, problem.w + problem.S[:, 0] - 2 * problem.S[:, 1])


def test_arrays_cannot_be_written_to() -> None:
    problem = saturated_line()
    for field in fields(ParametricQp):
        assert not getattr(problem, field.name).flags.writeable


def test_digest_is_that_of_the_data() -> None:
    assert saturated_line().digest == saturated_line().digest
    assert saturated_line().digest != replace(saturated_line(), w=np.array([1.0, 2.0])).digest


def test_an_infeasible_problem_is_refused() -> None:
    with pytest.raises(NoRegions, match="no parameter in the box is feasible"):
        enumerate_regions(replace(saturated_line(), w=np.array([-1.0, -1.0])))


def test_a_constraint_on_nothing_that_fails_is_refused() -> None:
    problem = saturated_line()
    with pytest.raises(NoRegions, match="holds no variable and no parameter"):
        enumerate_regions(replace(problem, G=np.array([[1.0], [0.0]]), w=np.array([1.0, -1.0])))


def test_a_flat_feasible_set_is_refused_by_name() -> None:
    """z ≤ 0 and z ≥ 0, z = θ: only θ = 0 is feasible."""
    problem = replace(
        saturated_line(), w=np.zeros(2), S=np.array([[1.0], [-1.0]]), G=np.array([[0.0], [0.0]])
    )
    with pytest.raises(NoRegions, match="parameter 0"):
        enumerate_regions(problem)
