"""Singular values by rotations are those of LAPACK."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat
from otolith.core.singular_values import extreme_singular_values


def _matrices() -> list[Mat]:
    random = np.random.default_rng(0)
    plain = [random.normal(size=(6, 6)) for _ in range(50)]
    graded = [matrix * 10.0 ** random.uniform(-6, 6, 6) for matrix in plain[:20]]
    tall = [random.normal(size=(8, 3)), np.eye(6), np.diag([3.0, 1e-9, 2.0])]
    return [*plain, *graded, *tall]


def test_the_largest_and_the_smallest_are_those_of_lapack() -> None:
    for matrix in _matrices():
        sigma = np.linalg.svd(matrix, compute_uv=False)
        found = extreme_singular_values(matrix.copy())
        assert_allclose(found[0], sigma[0], rtol=1e-13)
        assert_allclose(found[1], sigma[-1], rtol=1e-10, atol=4e-16 * sigma[0])


def test_of_a_singular_matrix_the_smallest_is_zero() -> None:
    matrix = np.arange(36.0).reshape(6, 6)  # of rank 2
    largest, smallest = extreme_singular_values(matrix.copy())
    assert smallest <= 1e-14 * largest
    assert extreme_singular_values(np.zeros((6, 6))) == (0.0, 0.0)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_what_is_no_number_has_no_singular_values(bad: float) -> None:
    matrix = np.eye(6)
    matrix[2, 3] = bad
    assert np.isnan(extreme_singular_values(matrix)).all()
