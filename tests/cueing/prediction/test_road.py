"""The prediction from what is foreseen: believed as far as it came true, and nothing beyond."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from otolith.core.arrays import Mat, Vec
from otolith.cueing.prediction import Adaptive, Road
from otolith.cueing.prediction.road import RoadPredictor
from otolith.interfaces import Reference

DT, N = 0.01, 200
HUNDRED = np.sin(np.arange(4000) * 0.02)  # what comes true, 40 s of it


def fed(predictor: RoadPredictor, foreseen: Vec, until: int) -> Mat:
    """What is predicted after `until` values of `HUNDRED`, of which `said` was foreseen."""
    for k in range(until):
        preview = np.outer(foreseen[k + 1 : k + 1 + 500], np.ones(3))
        reference = Reference(specific_force=np.full(3, HUNDRED[k]), preview=preview)
        coming = predictor.ahead(reference, DT, N)
    return coming


def test_what_comes_true_is_believed() -> None:
    predictor = Road().begin()
    coming = fed(predictor, HUNDRED, 1500)
    assert (predictor.trust > 0.99).all()
    assert_allclose(coming[:, 0], HUNDRED[1500 : 1500 + N], atol=0.02)


def test_what_never_comes_true_is_not_believed() -> None:
    noise = 2.0 * np.random.default_rng(3).normal(size=4600)
    predictor, otherwise = Road().begin(), Adaptive().begin()
    coming = fed(predictor, noise, 1500)
    for force in HUNDRED[:1500]:
        plain = otherwise.ahead(Reference(specific_force=np.full(3, force)), DT, N)
    assert (predictor.trust < 0.1).all()
    assert np.sqrt(np.mean((coming - plain) ** 2)) < 0.2  # a tenth of what was said


def test_trust_is_the_least_squares_solution() -> None:
    """Against a regression over the whole history at once, with the same weights and ridge."""
    p, lead, until = Road(), 200, 1200
    foreseen = HUNDRED + 0.5 * np.sin(np.arange(4000) * 0.013)
    predictor, otherwise = p.begin(), Adaptive().begin()
    fed(predictor, foreseen, until)
    plain = [
        otherwise.ahead(Reference(specific_force=np.full(3, force)), DT, N)[lead - 1, 0]
        for force in HUNDRED[:until]
    ]
    b = np.array(plain[: until - lead])
    more, error = foreseen[lead:until] - b, HUNDRED[lead:until] - b
    weight = DT * np.exp(-DT / p.memory * np.arange(len(b))[::-1])
    expected = (weight @ (more * error) + p.ridge) / (weight @ (more * more) + p.ridge)
    assert 0.2 < expected < 0.95
    assert predictor.trust[0] == pytest.approx(expected, rel=1e-9)


def test_where_nothing_is_foreseen_it_is_the_adaptive_prediction() -> None:
    predictor, otherwise = Road().begin(), Adaptive().begin()
    for force in HUNDRED[:300]:
        reference = Reference(specific_force=np.full(3, force), angular_rate=np.full(3, 0.2))
        assert_array_equal(predictor.ahead(reference, DT, N), otherwise.ahead(reference, DT, N))


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e7])
def test_what_is_no_number_is_not_foreseen(value: float) -> None:
    predictor = Road().begin()
    fed(predictor, HUNDRED, 1000)
    trust = predictor.trust
    foreseen = np.full((500, 3), value)
    coming = predictor.ahead(Reference(specific_force=np.full(3, HUNDRED[1000]), preview=foreseen), DT, N)
    assert np.isfinite(coming).all()
    fed(predictor, HUNDRED, 200)
    assert np.isfinite(predictor.trust).all()
    assert (np.abs(predictor.trust - trust) < 0.5).all()


def test_a_present_that_is_no_number_is_passed_on_and_teaches_nothing() -> None:
    predictor = Road().begin()
    fed(predictor, HUNDRED, 1000)
    trust = predictor.trust
    wrong = Reference(specific_force=np.full(3, np.nan), preview=np.zeros((500, 3)))
    assert np.isnan(predictor.ahead(wrong, DT, N)[:, :3]).all()
    assert_allclose(predictor.trust, trust, rtol=1e-3)
