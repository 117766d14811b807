"""Vectors of four in kernels, against numpy."""

from typing import Any

import numba
import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core import lanes as registers
from otolith.core.arrays import Vec
from otolith.core.jit import jit_fused

lanes: Any = registers  # mypy sees the typing context of an intrinsic as one more argument


@jit_fused
def combine(W: Vec, s: float) -> float:
    a, b = lanes.load4(W, 1), lanes.load4(W, 5)
    lanes.store4(W, 9, lanes.add_times4(lanes.add4(a, b), s, b))
    lanes.store4(W, 13, lanes.less_times4(lanes.times4(s, a), 2.0, lanes.unit4(3)))
    return lanes.lane4(b, 2)


def double(W: Vec, i: int) -> None:
    lanes.store4(W, i, lanes.times4(2.0, lanes.load4(W, i)))


def test_rows_of_four_are_combined_as_in_numpy() -> None:
    W = np.random.default_rng(1).standard_normal(20)
    before, a, b = W.copy(), W[1:5].copy(), W[5:9].copy()
    assert combine(W, -1.5) == b[2]
    assert_allclose(W[9:13], a + b - 1.5 * b, rtol=1e-14)
    assert_allclose(W[13:17], -1.5 * a - [0.0, 0.0, 0.0, 2.0], rtol=1e-14)
    assert_allclose(W[17:], before[17:], rtol=0)
    assert_allclose(W[:9], before[:9], rtol=0)


@pytest.mark.parametrize("i", [4, 8, -1])
def test_numbas_check_of_bounds_holds_for_rows_of_four(i: int) -> None:
    checked = numba.njit(boundscheck=True)(double)
    W = np.ones(7)
    checked(W, 7 - registers.WIDTH)
    assert W.tolist() == [1.0] * 3 + [2.0] * 4
    with pytest.raises(IndexError):
        checked(W, i)
