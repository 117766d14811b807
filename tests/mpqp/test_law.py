"""Answers of a law against an independent QP, whatever the walk starts from."""

import copy
import gc
import pickle
from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import CorruptFile
from otolith.mpqp import InvalidProblem, Law, enumerate_regions
from otolith.mpqp.lookup import OUTSIDE
from otolith.mpqp.oracle import solve
from otolith.mpqp.packed import CACHE
from tests.mpqp.models import random_problem, surge_pitch


@pytest.fixture(scope="module")
def thetas(blocked: Law) -> np.ndarray:
    problem = blocked.problem
    return np.random.default_rng(7).uniform(problem.lower, problem.upper, (20_000, 5))


def test_law_equals_an_independent_qp_at_20000_parameters(blocked: Law, thetas: np.ndarray) -> None:
    truth = np.array([solve(blocked.problem, theta) for theta in thetas])
    for answers in (blocked.evaluate_many(thetas), blocked.locate_many(thetas)):
        np.testing.assert_array_equal(answers.found, np.isfinite(truth[:, 0]))
        np.testing.assert_allclose(answers.z, truth, rtol=0.0, atol=1e-8)
        assert (answers.region[answers.found] >= 0).all()


def test_every_start_leads_to_the_same_answer(blocked: Law, thetas: np.ndarray) -> None:
    for start in (0, 17, 476, 477, 952):
        for theta in thetas[:100]:
            cold, walked = blocked.evaluate(theta), blocked.evaluate(theta, start)
            assert cold.found == walked.found
            assert cold.region == walked.region
            np.testing.assert_allclose(cold.z, walked.z, atol=1e-10)


def test_multipliers_satisfy_the_optimality_conditions(blocked: Law, thetas: np.ndarray) -> None:
    problem = blocked.problem
    region = -1
    for theta in thetas[:300]:
        answer = blocked.evaluate(theta, region)
        if not answer.found:
            continue
        region = answer.region
        g, b = problem.at(theta)
        assert (answer.multipliers >= -1e-9).all()
        stationarity = problem.H @ answer.z + g + problem.G[answer.active].T @ answer.multipliers
        np.testing.assert_allclose(stationarity, 0.0, atol=1e-8)
        np.testing.assert_allclose((problem.G @ answer.z - b)[answer.active], 0.0, atol=1e-9)
        assert (problem.G @ answer.z <= b + 1e-9).all()


def test_the_first_components_are_those_of_the_whole_answer(blocked: Law, thetas: np.ndarray) -> None:
    start = -1
    for theta in thetas[:300]:
        whole, (z, region) = blocked.evaluate(theta, start), blocked.first(theta, 2, start)
        np.testing.assert_array_equal(z, whole.z[:2])
        assert region == whole.region
        start = max(region, start)
    z, region = blocked.first(2 * blocked.problem.upper, 2, 7)
    assert np.isnan(z).all()
    assert region == OUTSIDE


def test_parameters_of_another_size_are_refused(blocked: Law) -> None:
    """A kernel would read beyond them."""
    for ask in (blocked.evaluate, lambda theta: blocked.first(theta, 2), blocked.evaluate_many):
        for bad in (np.zeros(4), np.zeros((2, 6)), np.zeros(())):
            with pytest.raises(InvalidProblem, match="shape"):
                ask(bad)
    for count in (0, 5):
        with pytest.raises(InvalidProblem, match="must be 1 to 4"):
            blocked.first(np.zeros(5), count)


def test_copies_have_memory_of_their_own(blocked: Law, thetas: np.ndarray) -> None:
    """Kernels know a law's arrays by their addresses, which a copy must not keep."""
    original = Law.from_arrays(blocked.to_arrays())
    copies = [pickle.loads(pickle.dumps(original)), copy.deepcopy(original)]
    del original
    gc.collect()
    truth = blocked.evaluate_many(thetas[:500])
    for one in copies:
        answers = one.evaluate_many(thetas[:500])
        np.testing.assert_array_equal(answers.region, truth.region)
        np.testing.assert_array_equal(answers.z, truth.z)


@pytest.mark.parametrize("cache", [1, 1 << 12, CACHE])
def test_an_answer_does_not_depend_on_what_was_asked_before(
    blocked: Law, thetas: np.ndarray, monkeypatch: pytest.MonkeyPatch, cache: int
) -> None:
    """What a law keeps about the regions that it has looked at does not change a bit."""
    fresh = Law.from_arrays(blocked.to_arrays())
    monkeypatch.setattr("otolith.mpqp.packed.CACHE", cache)
    used = Law.from_arrays(blocked.to_arrays())
    used.evaluate_many(thetas)
    for theta, start in zip(thetas[:200], range(0, 900, 4), strict=False):
        one, other = fresh.evaluate(theta, start), used.evaluate(theta, start)
        np.testing.assert_array_equal(one.z, other.z)
        np.testing.assert_array_equal(one.multipliers, other.multipliers)
        assert one.region == other.region


def test_gains_and_halfspaces_agree_with_the_answer(blocked: Law, thetas: np.ndarray) -> None:
    for theta in thetas[:300]:
        answer = blocked.evaluate(theta)
        if not answer.found:
            continue
        K, k = blocked.gains(answer.region)
        np.testing.assert_allclose(K @ theta + k, answer.z, atol=1e-9)
        A, b = blocked.halfspaces(answer.region)
        assert (A @ theta <= b + 1e-9).all()
        np.testing.assert_array_equal(np.sort(answer.active), blocked.active(answer.region))


def test_neighbours_know_each_other(blocked: Law) -> None:
    """Facet-to-facet is the rule; where one facet has several neighbours the link may be one-sided."""
    links = {(r, int(s)) for r in range(len(blocked)) for s in blocked.neighbours(r) if s >= 0}
    mutual = sum((s, r) in links for r, s in links)
    assert mutual > 0.8 * len(links)


def test_twins_are_mirror_images(blocked: Law) -> None:
    for r in range(0, len(blocked), 50):
        twin = blocked.twin(r)
        assert blocked.twin(twin) == r
        np.testing.assert_allclose(blocked.gains(twin)[0], blocked.gains(r)[0], atol=1e-9)
        np.testing.assert_allclose(blocked.gains(twin)[1], -blocked.gains(r)[1], atol=1e-9)


def test_points_on_the_edge_of_the_box_are_answered(blocked: Law) -> None:
    theta = np.zeros(5)
    theta[4] = blocked.problem.upper[4]
    assert blocked.evaluate(theta * (1 + 1e-10)).found
    assert not blocked.evaluate(theta * (1 + 1e-3)).found


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_not_finite_is_not_found(blocked: Law, bad: float) -> None:
    theta = np.zeros(5)
    theta[2] = bad
    answer = blocked.evaluate(theta, 0)
    assert not answer.found
    assert np.isnan(answer.z).all()


def test_an_asymmetric_law_with_linear_cost_equals_the_qp() -> None:
    base = surge_pitch(5, blocks=2)
    f = np.random.default_rng(0).standard_normal(4) * 0.1
    problem = replace(base, f=f, upper=base.upper * np.array([0.9, 1.0, 0.8, 1.0, 0.7]))
    law = enumerate_regions(problem)
    assert len(law.form.mirror) == 0
    thetas = np.random.default_rng(1).uniform(problem.lower, problem.upper, (2000, 5))
    truth = np.array([solve(problem, theta) for theta in thetas])
    np.testing.assert_allclose(law.locate_many(thetas).z, truth, rtol=0.0, atol=1e-8)


def test_memory_per_region_is_below_the_bound(blocked: Law) -> None:
    assert blocked.nbytes <= 350 * len(blocked)


def test_arrays_restore_the_law(blocked: Law, thetas: np.ndarray) -> None:
    again = Law.from_arrays(blocked.to_arrays())
    assert len(again) == len(blocked)
    one, two = blocked.evaluate_many(thetas[:500]), again.evaluate_many(thetas[:500])
    np.testing.assert_array_equal(one.region, two.region)
    np.testing.assert_array_equal(one.z, two.z)


def test_a_law_without_symmetry_is_restored_too() -> None:
    law = enumerate_regions(random_problem(5, 2, 5, 2))
    assert len(Law.from_arrays(law.to_arrays())) == len(law)


@pytest.mark.parametrize("name", ["keys", "rows", "problem.H", "beyond", "alone", "rows_kept"])
def test_a_missing_array_is_refused(line: Law, name: str) -> None:
    arrays = line.to_arrays()
    del arrays[name]
    with pytest.raises(CorruptFile, match=name):
        Law.from_arrays(arrays)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("beyond", np.full(4, 99)),
        ("keys", np.full((2, 1), 255, dtype=np.uint64)),
        ("start", np.array([0, 9, 1])),
        ("radius", np.ones(7)),
        ("problem.H", -np.ones((1, 1))),
        ("rows_kept", np.array([0, 5])),
    ],
)
def test_altered_arrays_are_refused(line: Law, name: str, value: np.ndarray) -> None:
    with pytest.raises(CorruptFile):
        Law.from_arrays(line.to_arrays() | {name: value})
