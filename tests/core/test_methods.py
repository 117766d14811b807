"""Kernels that are called by address: the same as called by name, on data that both sides see."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from numba.core.errors import TypingError
from numpy.testing import assert_array_equal

from otolith.core.arrays import Mat, Vec
from otolith.core.jit import kernel
from otolith.core.methods import INTEGER, MATRIX, VECTOR, Method, Role, address_of, call_at

ROLE = Role(INTEGER, (VECTOR, MATRIX))
_call = ROLE.call
_call_alone = call_at(INTEGER, VECTOR)


class Data(NamedTuple):
    total: Vec  # (1,)
    weights: Mat
    scale: float


@kernel
def add(data: Any, x: Vec, y: Mat) -> int:
    if len(x) == 0:
        raise ValueError("nothing to add")
    data.total[0] += data.scale * np.sum(data.weights) * x[0] + y[0, 0]
    return len(x)


@kernel
def subtract(data: Any, x: Vec, y: Mat) -> int:
    data.total[0] -= x[0]
    return -1


@kernel
def length(x: Vec) -> int:
    return len(x)


@kernel
def through(method: Method, x: Vec, y: Mat) -> int:
    of: int = _call(method, (x, y))
    return of


@kernel
def with_a_number(method: Method, x: Vec) -> int:
    of: int = _call(method, (x, 1.0))
    return of


@kernel
def through_address(address: int, x: Vec) -> int:
    of: int = _call_alone(address, (x,))
    return of


def data() -> Data:
    return Data(np.zeros(1), np.full((2, 2), 0.5), 3.0)


def test_one_caller_calls_any_method_of_a_role_and_works_on_the_data_of_each() -> None:
    x, y, one, other = np.array([2.0, 0.0]), np.array([[1.0]]), data(), data()
    adds, subtracts = ROLE.bind(add, one), ROLE.bind(subtract, other)
    assert through(adds.method, x, y) == 2
    assert through(subtracts.method, x, y) == -1
    assert through(adds.method, x, y) == 2
    assert_array_equal([one.total[0], other.total[0]], [2 * (3.0 * 2.0 * 2.0 + 1.0), -2.0])
    assert len(through.signatures) == 1  # type: ignore[attr-defined]  # compiled once for all methods


def test_the_handle_and_the_method_reach_the_same_data() -> None:
    x, y, given = np.array([1.0]), np.array([[0.0]]), data()
    bound = ROLE.bind(add, given)
    add(bound.held, x, y)
    through(bound.method, x, y)
    assert given.total[0] == 12.0


def test_what_a_method_raises_reaches_python() -> None:
    bound = ROLE.bind(add, data())
    with pytest.raises(ValueError, match="nothing to add"):
        through(bound.method, np.empty(0), np.array([[0.0]]))


def test_arguments_of_other_types_than_the_role_s_are_refused_when_compiled() -> None:
    bound = ROLE.bind(add, data())
    with pytest.raises(TypingError):
        with_a_number(bound.method, np.ones(1))


def test_a_kernel_without_data_is_called_by_its_address_alone() -> None:
    assert through_address(address_of(length, VECTOR), np.zeros(7)) == 7
