"""The proof passes for right laws, and fails for wrong ones."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.mpqp import Law, enumerate_regions, verify
from tests.mpqp.models import random_problem, saturated_line


def test_the_blocked_law_passes(blocked: Law) -> None:
    result = verify(blocked, 3000, np.random.default_rng(0))
    assert result.passed
    assert result.feasible > 1000
    assert result.facets > 100
    assert (result.regions, result.tolerance) == (len(blocked), 1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_laws_of_random_problems_pass(seed: int) -> None:
    law = enumerate_regions(random_problem(seed, 4, 8, 3))
    assert verify(law, 500, np.random.default_rng(seed)).passed


def without_region(law: Law, s: int) -> Law:
    """A law with a hole: the stored region s is gone."""
    arrays = law.to_arrays()
    start, h = arrays["start"].astype(np.int64), len(law.radius)
    kept = np.repeat(np.arange(h), np.diff(start)) != s
    number = np.full(len(law), -3)
    ids = [r for r in range(len(law)) if law.stored(r)[0] != s]
    number[ids] = np.arange(len(ids))
    beyond = arrays["beyond"].astype(np.int64)[kept]
    for name in ("keys", "centre", "radius"):
        arrays[name] = np.delete(arrays[name], s, axis=0)
    for name in ("rows", "constraint"):
        arrays[name] = arrays[name][kept]
    lengths = np.delete(np.diff(start), s)
    arrays["start"] = np.append(0, np.cumsum(lengths))
    arrays["beyond"] = np.where(beyond >= 0, number[np.maximum(beyond, 0)], beyond)
    return Law.from_arrays(arrays)


def test_a_hole_is_reported(blocked: Law) -> None:
    worst = int(blocked.radius.argmax())
    holed = without_region(blocked, worst)
    result = verify(holed, 3000, np.random.default_rng(0))
    assert result.missing > 0
    assert not result.passed
    centre, _ = blocked.ball(worst)
    theta = blocked.form.centre + blocked.form.half * centre
    answer = holed.evaluate(theta)
    assert (answer.region, answer.found) == (-1, True)
    np.testing.assert_allclose(answer.z, blocked.evaluate(theta).z, atol=1e-12)


def test_a_law_of_another_model_is_reported(blocked: Law) -> None:
    problem = blocked.problem
    foreign = replace(blocked, problem=replace(problem, w=problem.w * 1.01))
    result = verify(foreign, 100, np.random.default_rng(0))
    assert result.max_law_error > 1e-6
    assert not result.passed


def test_regions_without_one_of_their_facets_stray(blocked: Law) -> None:
    """They then cover their neighbours: what a census of few points would miss."""
    arrays, first = blocked.to_arrays(), blocked.start[:-1]
    for name in ("rows", "constraint", "beyond"):
        arrays[name] = np.delete(arrays[name], first, axis=0)
    arrays["start"] = arrays["start"] - np.arange(len(arrays["start"]))
    result = verify(Law.from_arrays(arrays), 300, np.random.default_rng(0))
    assert result.strays > 100
    assert not result.passed
    assert verify(blocked, 300, np.random.default_rng(0)).strays == 0


def test_a_region_stored_twice_is_reported(blocked: Law) -> None:
    arrays = blocked.to_arrays()
    for name in ("keys", "centre", "radius"):
        arrays[name] = np.append(arrays[name], arrays[name][-1:], axis=0)
    last = slice(blocked.start[-2], blocked.start[-1])
    for name in ("rows", "constraint", "beyond"):
        arrays[name] = np.append(arrays[name], arrays[name][last], axis=0)
    arrays["start"] = np.append(arrays["start"], len(arrays["beyond"]))
    old, h = arrays["beyond"], len(blocked.radius)
    arrays["beyond"] = np.where(old >= h, old + 1, old)  # ids of mirror images move up by one
    result = verify(Law.from_arrays(arrays), 1000, np.random.default_rng(0))
    assert result.doubles > 0
    assert not result.passed


def test_rows_that_limit_the_parameter_alone_are_part_of_the_verdict() -> None:
    """|z| ≤ 1 and 0 z ≤ 1 - θ: beyond θ = 1 there is nothing, though no region's own facets say so."""
    line = saturated_line()
    problem = replace(
        line,
        G=np.vstack([line.G, np.zeros((1, 1))]),
        w=np.append(line.w, 1.0),
        S=np.array([[0.0], [0.0], [-1.0]]),
    )
    law = enumerate_regions(problem)
    assert not law.evaluate(np.array([1.5])).found
    assert verify(law, 500, np.random.default_rng(0)).passed


def test_a_law_that_answers_where_there_is_nothing_is_reported() -> None:
    """The law of |z| ≤ 1, held against a model that asks for z ≥ 1.5 and z ≤ 1."""
    law = enumerate_regions(saturated_line())
    narrower = replace(law.problem, w=np.array([1.0, -1.5]))
    result = verify(replace(law, problem=narrower), 200, np.random.default_rng(0))
    assert result.false_hits > 100
    assert not result.passed
