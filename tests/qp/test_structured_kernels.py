"""The compiled pieces one by one, each against plain numpy."""

import os
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.arrays import Mat
from otolith.core.disk import NotWritten
from otolith.qp.stage import StageQp, by_columns, condense, rollout, row_values, stage_residual, stationarity
from otolith.qp.structured import StructuredSolver
from otolith.qp.structured.generate import module_of, source, sweep, write
from otolith.qp.structured.layout import Structure
from tests.qp.stage_problems import NU, NX, N, stage_problem, stage_qp

seeds = st.integers(0, 10_000)


def loaded(seed: int, soft: float = np.inf) -> tuple[StructuredSolver, StageQp, np.random.Generator]:
    rng = np.random.default_rng(seed)
    qp = stage_qp(rng, soft=soft).changed(x0=rng.standard_normal(NX))
    solver = StructuredSolver(qp.problem)
    solver.load(qp)
    return solver, qp, rng


def by_dense_algebra(qp: StageQp, weight: Mat, gradient: Mat) -> Mat:
    """Minimiser (N, nu) of the cost plus Σ ½ w r² + c r over all rows r, one linear solve in U."""
    dense = condense(qp)
    R = np.vstack([np.eye(N * NU), dense.A])  # rows in the order of the dense problem
    free = row_values(qp, np.zeros((N, NU)), rollout(qp, np.zeros((N, NU))))
    w, c = by_columns(weight, qp.problem), by_columns(gradient + weight * free, qp.problem)
    return np.linalg.solve(dense.H + R.T @ (w[:, None] * R), -dense.g - R.T @ c).reshape(N, NU)


@given(seed=seeds)
@settings(max_examples=15, deadline=None)
def test_riccati_is_the_dense_solve(seed: int) -> None:
    solver, qp, rng = loaded(seed)
    weight, gradient = rng.uniform(0, 5, (N, qp.problem.rows)), rng.standard_normal((N, qp.problem.rows))
    solver.rows("DIAGONAL")[:], solver.rows("GRADIENT")[:] = weight, gradient
    solver.kernels.factor(solver.vector, N - 1)
    solver.kernels.forward(solver.vector)
    expected = by_dense_algebra(qp, weight, gradient)
    np.testing.assert_allclose(solver.part("U"), expected, atol=1e-9)
    np.testing.assert_allclose(solver.part("X"), rollout(qp, expected), atol=1e-9)
    np.testing.assert_allclose(
        solver.rows("VALUE"), row_values(qp, expected, rollout(qp, expected)), atol=1e-9
    )


@pytest.mark.parametrize("last", range(N))
def test_stages_after_the_last_change_keep_their_factors(last: int) -> None:
    solver, qp, rng = loaded(3)
    W, rows = solver.vector, qp.problem.rows
    solver.rows("DIAGONAL")[:], solver.rows("GRADIENT")[:] = rng.uniform(0, 5, (2, N, rows))
    solver.kernels.factor(W, N - 1)
    solver.rows("DIAGONAL")[: last + 1] = rng.uniform(0, 5, (last + 1, rows))
    solver.rows("GRADIENT")[:] = rng.standard_normal((N, rows))
    solver.kernels.factor(W, last)
    solver.kernels.forward(W)
    expected = by_dense_algebra(qp, solver.rows("DIAGONAL"), solver.rows("GRADIENT"))
    np.testing.assert_allclose(solver.part("U"), expected, atol=1e-9)


def test_a_new_gradient_needs_no_new_factors() -> None:
    solver, qp, rng = loaded(4)
    W, rows = solver.vector, qp.problem.rows
    solver.rows("DIAGONAL")[:] = rng.uniform(0, 5, (N, rows))
    solver.kernels.factor(W, N - 1)
    solver.rows("GRADIENT")[:] = rng.standard_normal((N, rows))
    solver.kernels.backward(W, 0)
    solver.kernels.forward(W)
    expected = by_dense_algebra(qp, solver.rows("DIAGONAL"), solver.rows("GRADIENT"))
    np.testing.assert_allclose(solver.part("U"), expected, atol=1e-9)


def passed_on(pulls: Mat, share: float) -> Mat:
    """Sums (N, rows) if each wrong one passes a share of itself to the next stage."""
    sums = pulls.copy()
    for k in range(1, len(sums)):
        sums[k] += share * np.minimum(sums[k - 1], 0.0)
    return sums


def test_wrong_pulls_are_passed_on_along_their_rows_in_both_directions() -> None:
    solver, _, rng = loaded(5)
    pulls = solver.rows("EXCESS")
    pulls[:] = rng.standard_normal(pulls.shape)
    solver.kernels.end_arcs(solver.vector)
    there = passed_on(pulls, solver.kernels.SHARE)
    back = passed_on(pulls[::-1], solver.kernels.SHARE)[::-1]
    assert solver.kernels.SHARE > 0.0
    np.testing.assert_allclose(solver.rows("PULL"), np.minimum(there, back), atol=1e-12)


def test_an_arc_that_is_too_long_loses_its_wrong_ends_at_once() -> None:
    """Row 0 is active at all stages: its first pulls right themselves within two stages, its last at once."""
    solver, _, _ = loaded(5)
    W, rows = solver.vector, solver.rows
    rows("SET")[:], rows("MULTIPLIER")[:] = 0.0, 0.0
    rows("LO")[:], rows("HI")[:] = -1.0, 1.0
    rows("VALUE")[:] = 0.0
    rows("SET")[:, 0] = rows("VALUE")[:, 0] = 1.0
    rows("MULTIPLIER")[:, 0] = 1.0
    rows("MULTIPLIER")[:2, 0] = -2.0, 0.5
    rows("MULTIPLIER")[-1, 0] = -0.5
    assert solver.kernels.review(W, False, True) == 3.0
    assert rows("SET")[:, 0].tolist() == [0.0] * 2 + [1.0] * (N - 3) + [0.0]
    rows("SET")[:, 0] = 1.0
    assert solver.kernels.review(W, False, False) == 2.0  # without passing on, its very ends alone


@given(seed=seeds, soft=st.sampled_from([np.inf, 0.5]))
@settings(max_examples=20, deadline=None)
def test_the_compiled_certificate_is_the_plain_one(seed: int, soft: float) -> None:
    solver, qp, rng = loaded(seed, soft)
    U, y = rng.standard_normal((N, NU)), rng.standard_normal((N, qp.problem.rows))
    y[rng.uniform(size=y.shape) < 0.3] = 0.0
    solver.part("U")[:], solver.rows("MULTIPLIER")[:] = U, y
    assert solver.kernels.well_posed(solver.vector)
    assert solver.kernels.certificate(solver.vector) == pytest.approx(stage_residual(qp, U, y), rel=1e-10)
    slope = np.max(np.abs(stationarity(qp, U, rollout(qp, U), y)))
    assert solver.kernels.stationarity(solver.vector)[0] == pytest.approx(slope, rel=1e-10)


def test_a_negative_state_weight_is_refused_by_the_kernel() -> None:
    solver, _, _ = loaded(1)
    assert solver.kernels.well_posed(solver.vector)
    solver.part("STATE_WEIGHT")[2, 1] = -1e-12
    assert not solver.kernels.well_posed(solver.vector)


@pytest.mark.parametrize("part", ["U", "MULTIPLIER", "ERROR", "START"])
def test_the_compiled_certificate_of_a_nan_is_infinite(part: str) -> None:
    solver, _, _ = loaded(1)
    solver.kernels.well_posed(solver.vector)
    solver.part(part).flat[3] = np.nan
    assert solver.kernels.certificate(solver.vector) == np.inf


@given(seed=seeds)
@settings(max_examples=15, deadline=None)
def test_the_least_value_of_combined_rows_is_that_of_the_best_corner(seed: int) -> None:
    solver, qp, rng = loaded(seed)
    y = rng.standard_normal((N, qp.problem.rows))
    y[:, -NU:] = 0.0  # rows on states only
    solver.rows("GRADIENT")[:] = y
    dense = condense(qp)
    pull = dense.A.T @ by_columns(y, qp.problem)[N * NU :]  # (N·nu,)
    corner = np.where(pull > 0, qp.lower[:, -NU:].ravel(), qp.upper[:, -NU:].ravel()).reshape(N, NU)
    expected = np.sum(y * row_values(qp, corner, rollout(qp, corner)))
    least, size = solver.kernels.least_of_rows(solver.vector)
    assert least == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert size >= abs(least)


@given(seed=seeds)
@settings(max_examples=15, deadline=None, derandomize=True)
def test_a_pivot_row_takes_the_pull_on_an_input_without_bounds(seed: int) -> None:
    solver, qp, rng = loaded(seed)
    assert solver.structure.pivots == {1: 0}
    open_, y = -1, rng.standard_normal((N, qp.problem.rows))
    y[:, -NU:] = 0.0
    solver.rows("GRADIENT")[:] = y
    solver.rows("LOWER")[:, open_], solver.rows("UPPER")[:, open_] = -np.inf, np.inf
    least, size = solver.kernels.least_of_rows(solver.vector)
    taken = solver.rows("GRADIENT").copy()
    np.testing.assert_array_equal(taken[:, 1:], y[:, 1:])  # only the pivot row's part changed
    pull = (condense(qp).A.T @ by_columns(taken, qp.problem)[N * NU :]).reshape(N, NU)
    np.testing.assert_allclose(pull[:, open_], 0.0, atol=1e-10 * size)
    corner = np.where(pull > 0, qp.lower[:, -NU:], qp.upper[:, -NU:])
    corner[:, open_] = rng.standard_normal(N)  # whatever it is
    expected = np.sum(taken * row_values(qp, corner, rollout(qp, corner)))
    assert least == pytest.approx(expected, abs=1e-9 * size)


@given(seed=seeds)
@settings(max_examples=15, deadline=None, derandomize=True)
def test_of_violations_at_stages_in_a_row_the_worst_is_kept(seed: int) -> None:
    solver, qp, rng = loaded(seed)
    W, shape = solver.vector, (N, qp.problem.rows)
    solver.kernels.well_posed(W)
    values, sets = 2.0 * rng.standard_normal(shape), rng.choice([0.0, 0.0, 0.0, 1.0, -2.0], shape)
    solver.rows("VALUE")[:], solver.rows("SET")[:] = values, sets
    excess = np.where(sets == 0.0, np.maximum(values - qp.upper, qp.lower - values), 0.0)
    excess = np.maximum(excess, 0.0)
    assert solver.kernels.find_violations(W) == np.count_nonzero(excess)
    np.testing.assert_array_equal(solver.rows("MARK"), excess > 0.0)
    solver.kernels.keep_peaks(W)
    beside = np.pad(excess, ((1, 1), (0, 0)))
    peak = (excess > beside[:-2]) & (excess > beside[2:]) & (excess > 0.0)
    np.testing.assert_array_equal(solver.rows("MARK"), peak)


def test_numbers_are_data_and_only_the_structure_is_compiled() -> None:
    first, second = (StructuredSolver(stage_problem(np.random.default_rng(seed))) for seed in (1, 2))
    assert first.kernels is second.kernels


@pytest.mark.parametrize("lengths", [(), (3, 4)])
def test_no_name_of_a_generated_module_is_given_twice(lengths: tuple[int, ...]) -> None:
    text = source(Structure.of(stage_problem(np.random.default_rng(1)), lengths))
    names = re.findall(r"^(?:def )?([A-Za-z_0-9]+)(?: = |\()", text, re.MULTILINE)
    assert len(names) > 100
    assert sorted(set(names)) == sorted(names)


def test_another_sparsity_is_another_module() -> None:
    problem = stage_problem(np.random.default_rng(1))
    A = problem.A.copy()
    A[0, 2] = 0.3
    fields = {name: getattr(problem, name) for name in type(problem).__slots__}
    other = type(problem)(**fields | {"A": A})
    assert source(Structure.of(problem)) != source(Structure.of(other))


def test_many_writers_leave_one_whole_module(tmp_path: Path) -> None:
    text = source(Structure.of(stage_problem(np.random.default_rng(1))))
    with ThreadPoolExecutor(8) as pool:
        paths = set(pool.map(lambda _: write(text, tmp_path), range(32)))
    assert [path.read_text("utf-8") for path in paths] == [text]
    assert list(tmp_path.iterdir()) == list(paths)


def test_an_extension_is_compiled_with_the_engine(tmp_path: Path) -> None:
    structure = Structure.of(stage_problem(np.random.default_rng(1)))
    module = module_of(structure, "\n@kernel\ndef horizon(W):\n    return W[START] + N\n", tmp_path)
    assert module.horizon(np.ones(4)) == N + 1


def test_the_folder_of_modules_is_bounded_and_the_oldest_go_with_their_machine_code(tmp_path: Path) -> None:
    (tmp_path / "__pycache__").mkdir()
    for age in range(5):
        module = write(f"X = {age}\n", tmp_path)
        code = tmp_path / "__pycache__" / f"{module.stem}.solve-1.py311.1.nbc"
        code.touch()
        os.utime(module, (1000.0 - age, 1000.0 - age))
    (tmp_path / "notes.py").touch()
    sweep(tmp_path, kept=2)
    left = sorted(path.read_text() for path in tmp_path.glob("otolith_stage_*.py"))
    assert left == ["X = 0\n", "X = 1\n"]
    assert len(list((tmp_path / "__pycache__").iterdir())) == 2
    assert (tmp_path / "notes.py").exists()


def test_a_cache_that_cannot_be_written_is_named_with_what_chooses_another(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(
        NotWritten, match=r"otolith_stage_\w+.py could .* for which OTOLITH_CACHE names another"
    ):
        write("text", tmp_path / "file")
