"""Discrete filters beside scipy.signal's, which shares no code with `otolith.core.lti`."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import integrate, signal

from otolith.core.arrays import Vec
from otolith.cueing.washout.filters import Bank, at_period_ends, one_period_late, rotation, tilt, translation
from otolith.cueing.washout.tuning import SecondOrder, ThirdOrder

T = 0.01
SECOND = SecondOrder(natural_radps=3.0, damping=0.7)
THIRD = ThirdOrder(natural_radps=2.5, damping=1.0, washout_radps=0.25)
DEN2 = [1.0, 2 * 0.7 * 3.0, 9.0]
DEN3 = np.polymul([1.0, 2 * 2.5, 2.5**2], [1.0, 0.25])


def scipys(numerator: list[float], denominator: list[float], u: Vec) -> Vec:
    """Output at every period's end, before the next input counts, by scipy's zero-order hold."""
    discrete = signal.cont2discrete(signal.tf2ss(numerator, denominator), T, method="zoh")
    feedthrough = discrete[3].item()
    held_on = np.append(u, u[-1])  # no jump at the last end
    _, at_samples, _ = signal.dlsim(discrete, held_on)
    return at_samples[1:, 0] - feedthrough * np.diff(held_on)


@pytest.mark.parametrize(
    ("system", "numerators", "denominator"),
    [
        (translation(THIRD), [[1.0, 0.0, 0.0]], DEN3),
        (rotation(SECOND), [[1.0, 0.0, 0.0]], DEN2),
        (tilt(SECOND), [[9.0], [9.0, 0.0]], DEN2),
    ],
    ids=["translation", "rotation", "tilt"],
)
def test_every_filter_equals_scipys(system, numerators, denominator) -> None:
    u = np.cumsum(np.random.default_rng(1).normal(size=500))
    bank = Bank.of([at_period_ends(system, T)])
    ours = np.array([bank.step(np.array([value])) for value in u])
    theirs = np.column_stack([scipys(numerator, denominator, u) for numerator in numerators])
    assert_allclose(ours, theirs, atol=1e-10 * np.abs(theirs).max())


def test_the_rotation_filter_equals_scipys_first_order_hold() -> None:
    u = np.cumsum(np.random.default_rng(1).normal(size=500))
    bank = Bank.of([one_period_late(rotation(SECOND), T)])
    ours = np.array([bank.step(np.array([value]))[0] for value in u])
    discrete = signal.cont2discrete(signal.tf2ss([1.0, 0.0, 0.0], DEN2), T, method="foh")
    _, theirs, _ = signal.dlsim(discrete, u)
    assert_allclose(ours, theirs[:, 0], atol=1e-10 * np.abs(theirs).max())


def test_filters_of_a_bank_do_not_touch_each_other() -> None:
    systems = [at_period_ends(s, T) for s in (translation(THIRD), tilt(SECOND), rotation(SECOND))]
    u = np.random.default_rng(2).normal(size=(50, 3))
    together, apart = Bank.of(systems), [Bank.of([system]) for system in systems]
    for row in u:
        alone = np.concatenate([one.step(row[i : i + 1]) for i, one in enumerate(apart)])
        assert_allclose(together.step(row), alone, atol=1e-14)


def velocity(_: float, x: Vec, of: ThirdOrder, wanted: float) -> Vec:
    """v' = u − c₁ v − c₂ p − c₃ ∫p: the denominator of H, divided by s²; x is v, p, ∫p."""
    second = [1.0, 2 * of.damping * of.natural_radps, of.natural_radps**2]
    c = np.polymul(second, [1.0, of.washout_radps])
    return np.array([wanted - c[1:] @ x, x[0], x[1]])


def angle(_: float, x: Vec, of: SecondOrder, wanted: float) -> Vec:
    """θ'' = ω² (u − θ) − 2ζω θ'; x is θ, θ'."""
    w = of.natural_radps
    return np.array([x[1], w**2 * (wanted - x[0]) - 2 * of.damping * w * x[1]])


@pytest.mark.parametrize(
    ("make", "of", "slope", "seen"), [(translation, THIRD, velocity, 1), (tilt, SECOND, angle, 2)]
)
def test_a_filter_whose_corners_change_goes_on_from_what_it_has_reached(make, of, slope, seen) -> None:
    """The differential equations of velocity and travel, and of a tilt; coefficients change midway."""
    then = of.model_copy(update={"natural_radps": 1.7 * of.natural_radps})
    u = np.random.default_rng(3).normal(size=200)
    bank = Bank.of([at_period_ends(make(of), T)])
    x, ours, theirs = np.zeros(seen + 2 * (seen == 1)), [], []
    for k, value in enumerate(u):
        if k == 100:
            bank.take([at_period_ends(make(then), T)])
        ours.append(bank.step(np.array([value])))
        given = (of if k < 100 else then, value)
        x = integrate.solve_ivp(slope, (0.0, T), x, args=given, rtol=1e-10, atol=1e-12).y[:, -1]
        theirs.append(x[:seen])
    assert_allclose(ours, theirs, atol=1e-8)


def test_the_printed_numerators_would_be_low_passes() -> None:
    """Eqs. 2.2 and 2.4: ω_n² over the denominator has gain one at rest; the filters here have none."""
    w, printed = signal.freqs([SECOND.natural_radps**2], DEN2, worN=[1e-3])
    assert abs(printed[0]) == pytest.approx(1.0, abs=1e-3)
    assert abs(rotation(SECOND).frequency_response(w)[0, 0, 0]) < 1e-6
    assert abs(translation(THIRD).frequency_response(w)[0, 0, 0]) < 1e-6


def test_travel_returns_to_zero_under_a_constant_acceleration() -> None:
    """H/s² at s = 0 is zero: three zeros against two integrations."""
    travel = translation(THIRD).frequency_response(np.array([1e-4]))[0, 0, 0] / 1e-4j
    assert abs(travel) < 1e-3
