"""Predictions: what they say, that they know no future, and that a wrong one turns itself off."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.cueing.prediction import (
    PREDICTIONS,
    Adaptive,
    Decay,
    Hold,
    Oracle,
    Road,
    parse_prediction,
    prediction_named,
)
from otolith.cueing.prediction.adaptive import AdaptivePredictor
from otolith.cueing.prediction.named import prediction_to_record
from otolith.cueing.prediction.perceived import Perceived
from otolith.interfaces import Predictor, Reference
from otolith.perception import Vestibular

DT = 0.01


def reference(force: float, preview: Mat | None = None) -> Reference:
    return Reference(
        specific_force=np.array([force, -2.0 * force, 0.5]),
        angular_rate=np.array([0.1, 0.2, 0.3]),
        preview=preview,
    )


def fed(predictor: Predictor, forces: Vec, n: int = 40) -> Mat:
    """What a predictor says after a series of forces."""
    for force in forces:
        predicted = predictor.ahead(reference(force), DT, n)
    return predicted


@pytest.mark.parametrize("kind", PREDICTIONS.values(), ids=list(PREDICTIONS))
@settings(max_examples=20, deadline=None)  # the first one compiles
@given(seed=st.integers(0, 1000), now=st.integers(1, 80))
def test_another_future_changes_nothing(kind: type, seed: int, now: int) -> None:
    """Two references that agree until now are predicted alike; the oracle is given no future here."""
    rng = np.random.default_rng(seed)
    past, one, other = rng.normal(size=now), rng.normal(size=30), 100.0 * rng.normal(size=30)
    predictors = kind().begin(), kind().begin()
    predicted = [
        np.array([predictor.ahead(reference(force), DT, 20) for force in np.concatenate([past, coming])])
        for predictor, coming in zip(predictors, (one, other), strict=True)
    ]
    assert_array_equal(predicted[0][:now], predicted[1][:now])


@pytest.mark.parametrize("kind", PREDICTIONS.values(), ids=list(PREDICTIONS))
def test_rates_are_held_and_the_past_is_forgotten(kind: type) -> None:
    predictor = kind().begin()
    first = [predictor.ahead(reference(force), DT, 30) for force in (1.0, 0.5, 2.0)]
    assert_allclose(first[-1][:, 3:], np.tile([0.1, 0.2, 0.3], (30, 1)))
    predictor.reset()
    again = [predictor.ahead(reference(force), DT, 30) for force in (1.0, 0.5, 2.0)]
    assert_array_equal(first, again)


def test_a_decay_has_fallen_to_37_percent_after_its_time() -> None:
    predicted = Decay(time=0.2).begin().ahead(reference(3.0), DT, 20)
    assert_allclose(predicted[19, :2], [3.0 / np.e, -6.0 / np.e])


def test_the_oracle_uses_what_it_is_given_up_to_its_time_and_holds_its_end() -> None:
    preview = np.outer(np.arange(1.0, 5.0), [1.0, 2.0, 3.0])
    assert_array_equal(Oracle().begin().ahead(reference(9.0, preview), DT, 6)[:, 0], [1, 2, 3, 4, 4, 4])
    assert_array_equal(Oracle(time=0.02).begin().ahead(reference(9.0, preview), DT, 4)[:, 1], [2, 4, 4, 4])


def test_the_first_value_has_no_slope_and_dies_away_sooner_when_it_is_large() -> None:
    p = Adaptive()
    small, large, strong = (
        Adaptive().begin().ahead(reference(force), DT, 100)[99, 0] for force in (1e-6, 3.0, 7.0)
    )
    assert small == pytest.approx(1e-6 * np.exp(-1.0 / p.near), rel=1e-3)
    assert large == pytest.approx(3.0 * np.exp(-1.0 / p.far), rel=1e-9)
    assert strong == pytest.approx(
        7.0 * np.exp(-(2.0**2) / p.far), rel=1e-9
    )  # twice r_strong: a quarter of T


def trust_after(forces: Vec) -> float:
    predictor = Adaptive().begin()
    fed(predictor, forces)
    assert isinstance(predictor, AdaptivePredictor)
    return float(predictor.trust[0])


def test_the_slope_of_a_slow_sine_is_trusted_and_that_of_noise_is_not() -> None:
    t = np.arange(0.0, 20.0, DT)
    assert trust_after(np.sin(2.0 * np.pi * 0.2 * t)) > 0.8
    noise = np.random.default_rng(5).normal(size=len(t))
    assert trust_after(noise) < 0.1


def test_trust_is_the_least_squares_solution() -> None:
    """Against a regression over the whole history at once, with the same weights and ridge."""
    p, rng = Adaptive(), np.random.default_rng(8)
    f = np.cumsum(rng.normal(size=600)) * 0.02
    slope, slopes = 0.0, []
    for k in range(len(f)):
        rise = 0.0 if k == 0 else np.clip((f[k] - f[k - 1]) / DT, -8.0, 8.0)
        slope += DT / (p.smooth + DT) * (rise - slope)
        slopes.append(slope)
    h = round(p.lead / DT)
    x = p.slope * (1.0 - np.exp(-p.lead / p.slope)) * np.array(slopes[:-h])
    y = f[h:] - f[:-h]
    weight = DT * np.exp(-DT / p.memory * np.arange(len(x))[::-1])
    expected = np.clip(p.gain * (weight @ (x * y)) / (weight @ (x * x) + p.ridge), 0.0, p.most)
    assert trust_after(f) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e7])
def test_what_is_no_number_of_this_world_is_passed_on_and_poisons_nothing(value: float) -> None:
    predictor, undisturbed = Adaptive().begin(), Adaptive().begin()
    forces = np.sin(np.arange(60) * 0.1)
    fed(predictor, forces)
    fed(undisturbed, forces)
    predicted = predictor.ahead(
        Reference(specific_force=np.array([value, 1.0, 0.5]), angular_rate=np.zeros(3)), DT, 5
    )
    assert_array_equal(predicted[:, 0], value)
    assert np.isfinite(predicted[:, 1:]).all()
    assert_array_equal(
        predictor.ahead(reference(0.2), DT, 5)[:, 0], undisturbed.ahead(reference(0.2), DT, 5)[:, 0]
    )


def test_a_prediction_is_read_from_text_and_survives_a_record() -> None:
    for text, value in (
        ("hold", Hold()),
        ("decay:time=0.5", Decay(time=0.5)),
        ("adaptive:near=2,ridge=1", Adaptive(near=2.0, ridge=1.0)),
        ("oracle:time=3", Oracle(time=3.0)),
        ("road:time=4,memory=10", Road(time=4.0, memory=10.0)),
    ):
        assert parse_prediction(text) == value
        assert prediction_named(prediction_to_record(value)) == value


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("holds", "--prediction is 'holds', must be one of hold, decay, adaptive, road, oracle"),
        ("decay:time=-1", "time of the decay is -1.0 s, must be greater than 0"),
        ("decay:tim=1", "parameter of decay is 'tim'"),
        ("adaptive:near=0", "near of the adaptive prediction is 0.0, must be greater than 0"),
        ("road:ridge=-1", "ridge of the road is -1.0 m²/s³, must be greater than 0"),
        ("road:lead=6", "lead of the road is 6.0 s, must be at most its time, 5 s"),
        ("oracle:time=0", "time of the oracle is 0.0 s, must be greater than 0"),
    ],
)
def test_a_wrong_prediction_is_refused_in_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_prediction(text)
    assert str(refused.value).startswith(sentence)


def test_what_is_perceived_passes_the_organs_and_what_is_no_number_leaves_them_alone() -> None:
    rng, organs = np.random.default_rng(4), Vestibular()
    force, rate, known = rng.normal(size=(30, 3)), rng.normal(size=(30, 3)), rng.normal(size=(10, 3))
    predictor = Perceived(of=Oracle()).begin()

    def predicted(k: int, preview: Mat | None = None) -> Mat:
        now = Reference(specific_force=force[k], angular_rate=rate[k], preview=preview)
        return predictor.ahead(now, DT, 10)

    for k in range(29):
        assert_allclose(predicted(k)[:, :3], np.tile(organs.force(force[: k + 1], DT)[-1], (10, 1)))
        assert np.isnan(predictor.ahead(reference(np.nan), DT, 2)[:, 0]).all()
    last = predicted(29, known)
    assert_allclose(last[:, :3], organs.force(np.vstack([force, known]), DT)[30:], atol=1e-12)
    assert_allclose(last[:, 3:], np.tile(organs.rate(rate, DT)[-1], (10, 1)), atol=1e-12)
    predictor.reset()
    assert_allclose(predicted(0)[0, :3], organs.force(force[:1], DT)[0])
