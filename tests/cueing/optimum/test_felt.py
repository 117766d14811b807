"""What is felt and its derivatives, against the definition in world and against the plant's own sensing."""

import sys

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.frames import BASES, DOFS
from otolith.core.rotation import felt_along, rate_along
from otolith.cueing.optimum.definition import felt
from otolith.cueing.optimum.optimum import _Felt
from otolith.scenarios import Scenario

STEP = 1e-30  # of a complex step
HEADS = pytest.mark.parametrize("head", [None, (0.0, 0.0, 0.0), (0.3, -0.2, 1.0)], ids=["none", "zero", "up"])


def moving(n: int) -> np.ndarray:
    """Large motions (3, n, 6), so that no term is too small to be seen."""
    return np.random.default_rng(7).normal(size=(3, n, 6)) * np.array([0.6, 1.0, 2.0])[:, None, None]


def test_the_definition_is_what_the_plants_sense() -> None:
    place, speed, acceleration = moving(40)
    head, force, rate = np.array([0.3, -0.2, 1.0]), np.empty((40, 3)), np.empty((40, 3))
    felt_along(head, place, speed, acceleration, force)
    rate_along(place, speed, rate)
    assert_allclose(felt(place, speed, acceleration, head), np.hstack([force, rate[:, 2:]]), atol=1e-12)


def of_all(wanted: Scenario, head: tuple[float, float, float] | None) -> _Felt:
    """The cost along six axes, and three of a base that carries them with a lag of its own."""
    dofs, lags = tuple(DOFS.values()), [0.01] * 6 + [0.08] * 3
    moved = (*dofs, *BASES.values())
    return _Felt.of(wanted, dofs, moved=moved, lags=lags, head=head, plant_period=5e-3)


@HEADS
def test_the_gradient_is_that_of_the_definition(head: tuple[float, float, float] | None) -> None:
    """Of all four channels by all states and inputs of all six axes and three of a base, by complex steps."""
    wanted = Scenario(name="none", duration=0.03, specific_force=lambda t: np.ones((len(t), 3)))
    cost = of_all(wanted, head)
    rng = np.random.default_rng(3)
    X, U = rng.normal(size=(4, 27)), rng.normal(size=(3, 9))
    value, gradient, hessian = cost.expand(X, U, exact=False)
    assert value == pytest.approx(cost.costs(X[:-1], U).sum(), rel=1e-12)
    for column in range(36):
        x, u = X[:-1].astype(complex), U.astype(complex)
        (x if column < 27 else u)[:, column % 27] += 1j * STEP
        assert_allclose(gradient[:, column], cost.costs(x, u).imag / STEP, rtol=1e-9, atol=1e-9)
        errors = cost.errors(x, u)  # half the second derivative of a square is the square of the first
        slopes = errors.imag / STEP
        squares = np.sum(cost.tracked.weight * slopes**2, axis=(1, 2)) + (column >= 27) * cost.tracked.effort
        assert_allclose(hessian[:, column, column], squares, rtol=1e-9, atol=1e-9)


@HEADS
def test_the_exact_hessian_is_that_of_the_gradient(head: tuple[float, float, float] | None) -> None:
    """Errors are large here, so that what the felt force bends by is most of it."""
    wanted = Scenario(name="none", duration=0.03, specific_force=lambda t: np.full((len(t), 3), 5.0))
    cost = of_all(wanted, head)
    rng, step = np.random.default_rng(3), 1e-5
    X, U = rng.normal(size=(4, 27)), rng.normal(size=(3, 9))
    _, _, hessian = cost.expand(X, U, exact=True)
    assert_allclose(hessian, hessian.transpose(0, 2, 1), rtol=1e-9, atol=1e-9)
    for column in range(36):
        ends = []
        for sign in (-1.0, 1.0):
            x, u = X.copy(), U.copy()
            (x if column < 27 else u)[:, column % 27] += sign * step
            ends.append(cost.expand(x, u, exact=False).gradient)
        assert_allclose(hessian[:, column], (ends[1] - ends[0]) / (2.0 * step), rtol=1e-4, atol=2e-2)


def test_errors_do_not_depend_on_the_blocks_they_are_computed_in(monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = Scenario(name="none", duration=0.07, specific_force=lambda t: np.ones((len(t), 3)))
    cost = of_all(wanted, (0.3, 0.0, 1.0))
    rng = np.random.default_rng(5)
    X, U = rng.normal(size=(7, 27)), rng.normal(size=(7, 9))
    whole = cost.errors(X, U)
    assert whole.shape == (7, 2, 4)
    monkeypatch.setattr(sys.modules[_Felt.__module__], "BLOCK", 3)
    assert_allclose(cost.errors(X, U), whole, rtol=1e-13)
