"""The regions found are all regions, and nothing else."""

import tracemalloc
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.mpqp import Law, ParametricQp, Progress, enumerate_regions
from otolith.mpqp import enumerate as enumeration
from otolith.mpqp.geometry import affine_multipliers, affine_slacks, exact_rows
from otolith.mpqp.leastdistance import LeastDistance, least_distance
from otolith.mpqp.packed import CACHE
from otolith.mpqp.prune import inscribed
from otolith.sealed import write_laws
from tests.mpqp.models import random_problem, saturated_line, surge_pitch


def radius(form: LeastDistance, A: np.ndarray) -> float:
    """Radius of the region of active rows A by a general LP solver; -1 when they are dependent."""
    if np.linalg.matrix_rank(form.Q[np.ix_(A, A)], tol=1e-9) < len(A):
        return -1.0
    affine = affine_slacks(form, A)
    affine[A] = affine_multipliers(form, A)
    constant = np.linalg.norm(affine[:, :-1], axis=1) < 1e-9
    if (affine[constant, -1] < -1e-9).any() or (np.abs(affine[A, -1])[constant[A]] < 1e-9).any():
        return -1.0
    affine = affine[~constant]
    rows = affine * np.append(-np.ones(len(form.half)), 1.0)
    rows /= np.linalg.norm(rows[:, :-1], axis=1, keepdims=True)
    p = len(form.half)
    box = np.vstack([np.eye(p), -np.eye(p), form.E.T])
    level = np.concatenate([rows[:, -1], np.ones(2 * p), form.e])
    return inscribed(np.vstack([rows[:, :-1], box]), level)


def active_sets(law: Law) -> set[tuple[int, ...]]:
    return {tuple(law.active(r).tolist()) for r in range(len(law))}


def brute_force(problem: ParametricQp) -> tuple[set[tuple[int, ...]], set[tuple[int, ...]]]:
    """Active sets with a region for certain, and those that may have one, by trying all subsets."""
    form = least_distance(problem)
    m, n, _ = form.sizes
    subsets = [np.array(A, dtype=np.int64) for k in range(n + 1) for A in combinations(range(m), k)]
    radii = [radius(form, A) for A in subsets]
    certain = {tuple(form.rows[A].tolist()) for A, r in zip(subsets, radii, strict=True) if r > 1e-6}
    possible = {tuple(form.rows[A].tolist()) for A, r in zip(subsets, radii, strict=True) if r > 1e-8}
    return certain, possible


def test_a_saturated_line_has_three_regions(line: Law) -> None:
    assert len(line) == 3
    for theta, z in ((-1.5, -1.0), (0.25, 0.25), (1.75, 1.0)):
        answer = line.evaluate(np.array([theta]))
        np.testing.assert_allclose(answer.z, [z], atol=1e-14)
        np.testing.assert_allclose(answer.multipliers, [abs(theta) - 1.0] if abs(theta) > 1 else [])


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 3), st.integers(1, 3), st.integers(3, 6))
def test_equals_brute_force_over_all_active_sets(seed: int, n: int, p: int, m: int) -> None:
    problem = random_problem(seed, n, m, p)
    certain, possible = brute_force(problem)
    found = active_sets(enumerate_regions(problem))
    assert certain <= found <= possible


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 10**6))
def test_symmetric_problems_equal_brute_force_too(seed: int) -> None:
    half = random_problem(seed, 2, 3, 2)
    problem = replace(
        half, f=np.zeros(2), G=np.vstack([half.G, -half.G]), w=np.tile(half.w, 2),
        S=np.vstack([half.S, -half.S]), lower=-half.upper,
    )  # fmt: skip
    law = enumerate_regions(problem)
    assert len(law.form.mirror) > 0
    certain, possible = brute_force(problem)
    assert certain <= active_sets(law) <= possible


def test_blocked_horizon_five_has_the_known_number_of_regions(blocked: Law) -> None:
    """Table 5.2 of the thesis counts 938; 953 at radius 1e-7 (see the module's note on tolerance)."""
    assert len(blocked) == 953


def test_symmetry_switched_off_gives_the_same_regions(blocked: Law) -> None:
    whole = enumerate_regions(blocked.problem, symmetry=False)
    assert len(whole.form.mirror) == 0
    assert active_sets(whole) == active_sets(blocked)


def test_identical_rows_do_not_eliminate_each_other() -> None:
    problem = saturated_line()
    twice = replace(
        problem,
        G=np.vstack([problem.G, problem.G]),
        w=np.tile(problem.w, 2),
        S=np.vstack([problem.S, problem.S]),
    )
    law = enumerate_regions(twice)
    assert len(law) == 3
    np.testing.assert_allclose(law.evaluate(np.array([1.5])).z, [1.0])


def test_rank_deficient_rows_are_no_obstacle() -> None:
    """Three constraints in the plane meet in one point throughout: active sets stay independent."""
    problem = ParametricQp(
        H=np.eye(2), F=-np.eye(2), f=np.zeros(2), G=np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]),
        w=np.array([1.0, 1.0, 2.0]), S=np.zeros((3, 2)), lower=-3 * np.ones(2), upper=3 * np.ones(2),
    )  # fmt: skip
    law = enumerate_regions(problem)
    assert len(law) == 4
    for theta in np.random.default_rng(0).uniform(-3, 3, (200, 2)):
        np.testing.assert_allclose(law.evaluate(theta).z, np.minimum(theta, 1.0), atol=1e-12)


def test_an_opposed_pair_of_rows_acts_as_an_equality() -> None:
    """z1 + z2 = θ1 by two inequalities: the law is found, and equals the projection."""
    problem = ParametricQp(
        H=np.eye(2), F=np.zeros((2, 2)), f=np.zeros(2), G=np.array([[1.0, 1.0], [-1.0, -1.0], [1.0, 0.0]]),
        w=np.array([0.0, 0.0, 0.3]), S=np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 0.1]]),
        lower=-np.ones(2), upper=np.ones(2),
    )  # fmt: skip
    law = enumerate_regions(problem)
    for theta in np.random.default_rng(0).uniform(-1, 1, (200, 2)):
        first = min(theta[0] / 2, 0.3 + 0.1 * theta[1])
        answer = law.evaluate(theta)
        assert answer.region >= 0
        np.testing.assert_allclose(answer.z, [first, theta[0] - first], atol=1e-9)


def test_progress_counts_up_to_the_law(blocked: Law) -> None:
    seen: list[Progress] = []
    enumerate_regions(blocked.problem, progress=seen.append)
    assert abs(seen[-1].regions - len(blocked)) <= 1
    assert seen[-1].open == 0
    assert all(p.seconds >= 0.0 for p in seen)


def test_an_interruption_passes_through() -> None:
    def interrupt(progress: Progress) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        enumerate_regions(surge_pitch(5, blocks=2), progress=interrupt)


def test_a_coarser_tolerance_keeps_fewer_regions(blocked: Law) -> None:
    coarse = enumerate_regions(blocked.problem, tolerance=1e-3)
    assert len(coarse) < len(blocked)
    assert coarse.radius.min() >= 1e-3


@pytest.mark.parametrize(("workers", "chunk"), [(1, 256), (2, 256), (2, 3), (5, 17)])
def test_the_file_is_the_same_whoever_examines_which_set_when(
    blocked: Law, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, workers: int, chunk: int
) -> None:
    monkeypatch.setattr(enumeration, "CHUNK", chunk)
    again = enumerate_regions(blocked.problem, workers=workers)
    write_laws([blocked], tmp_path / "one.h5")
    write_laws([again], tmp_path / "other.h5")
    assert (tmp_path / "one.h5").read_bytes() == (tmp_path / "other.h5").read_bytes()


def test_regions_are_sorted_by_their_active_sets(blocked: Law) -> None:
    """Words of a key are compared from the last to the first, the highest bit first."""
    assert blocked.alone == 1
    keys = [tuple(key[::-1].tolist()) for key in blocked.keys[1:]]
    assert keys == sorted(keys)


def test_rows_are_those_of_the_active_sets(blocked: Law) -> None:
    """The half-spaces that the kernel writes at the end are those that numpy finds, rounded to 32 bits."""
    for s in range(0, len(blocked.radius), 7):
        facets = slice(blocked.start[s], blocked.start[s + 1])
        exact = exact_rows(blocked.form, blocked.form_rows(s), blocked.facets(s))
        np.testing.assert_allclose(blocked.rows[facets], exact, rtol=0.0, atol=1e-6)


def test_no_worker_is_refused(blocked: Law) -> None:
    with pytest.raises(InputError, match="workers is 0, must be at least 1"):
        enumerate_regions(blocked.problem, workers=0)


def test_memory_while_enumerating_stays_below_300_bytes_per_region() -> None:
    enumerate_regions(saturated_line())  # compiles
    tracemalloc.start()
    try:
        law = enumerate_regions(surge_pitch(6), workers=2)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert peak - CACHE <= 300 * len(law)
