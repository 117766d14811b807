"""Engines with a memory: what is written there is solved, with and without blocks."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.qp import DenseSolver, Status, kkt_residual
from otolith.qp.blocked import Lengths, block_bounds, block_ends, block_starts, condense_blocked
from otolith.qp.blocked_engine import BlockedEngine
from otolith.qp.engines import CondensedEngine, StageEngine, StageMemory, StructuredEngine, expand
from otolith.qp.stage import StageQp, by_columns
from tests.qp.stage_problems import NU, NX, N, stage_qp

EXACT = DenseSolver(primal_tolerance=1e-11)
FORMS = [(), (1, 2, 4)]


def write(memory: StageMemory, qp: StageQp, lengths: Lengths) -> None:
    """Put a problem into an engine's memory."""
    lengths = lengths or (1,) * N
    ends = block_ends(lengths)
    memory.start[:] = qp.x0
    memory.output[:] = qp.output[:, qp.problem.output]
    memory.error[:], memory.state_weight[:] = qp.error, qp.state_weight
    memory.state_linear[:] = qp.state_linear
    memory.input_linear[:] = np.add.reduceat(qp.input_linear, block_starts(lengths))
    memory.varying[:] = qp.varying[ends][:, qp.problem.varying]
    memory.lower[:], memory.upper[:] = block_bounds(qp, lengths)


def firm_at_first(qp: StageQp, penalty: float) -> StageQp:
    """The same problem with the rows on states hard at the first step and soft after it."""
    penalties = np.full((N, qp.problem.rows), np.inf)
    penalties[1:, :-NU] = penalty
    return qp.changed(problem=replace(qp.problem, penalty=penalties))


@pytest.mark.parametrize("make", [StructuredEngine, CondensedEngine, BlockedEngine])
@given(seed=st.integers(0, 10_000), blocks=st.sampled_from(FORMS), soft=st.sampled_from([np.inf, 5.0, 0.3]))
@settings(max_examples=40, deadline=None)
def test_what_lies_in_the_memory_is_solved(
    make: Callable[..., StageEngine], seed: int, blocks: Lengths, soft: float
) -> None:
    rng = np.random.default_rng(seed)
    qp = firm_at_first(stage_qp(rng).changed(x0=0.05 * rng.standard_normal(NX)), soft)
    dense = condense_blocked(qp, blocks or (1,) * N)
    expected = EXACT.solve(dense)
    engine = make(qp.problem, tolerance=1e-6, blocks=blocks)
    write(engine.memory, qp, blocks)
    found = engine.run()
    assert found.status is expected.status
    if expected.status is Status.OPTIMAL:
        assert_allclose(found.U.ravel(), expected.z, atol=1e-6)
        assert kkt_residual(dense, found.U.ravel(), by_columns(found.y, qp.problem)) < 1e-6


@given(seed=st.integers(0, 10_000), blocks=st.sampled_from(FORMS))
@settings(max_examples=20, deadline=None)
def test_the_memory_as_a_value_is_the_problem_that_was_written(seed: int, blocks: Lengths) -> None:
    qp = stage_qp(np.random.default_rng(seed))
    engine = CondensedEngine(qp.problem, tolerance=1e-6, blocks=blocks)
    write(engine.memory, qp, blocks)
    lengths = blocks or (1,) * N
    once, again = (
        condense_blocked(given, lengths) for given in (qp, expand(qp.problem, engine.memory, blocks))
    )
    for name in ("H", "g", "A", "lower", "upper", "penalty"):
        assert_allclose(getattr(again, name), getattr(once, name), atol=1e-12)


HOSTILE = {
    "random": lambda rng, shape: rng.integers(-1, 2, shape),
    "all upper": lambda rng, shape: np.ones(shape, dtype=np.int64),
    "all lower": lambda rng, shape: -np.ones(shape, dtype=np.int64),
    "sparse": lambda rng, shape: rng.integers(-1, 2, shape) * (rng.random(shape) < 0.05),
}


@pytest.mark.parametrize("make", [StructuredEngine, CondensedEngine])
@given(
    seed=st.integers(0, 10_000),
    blocks=st.sampled_from(FORMS),
    soft=st.sampled_from([np.inf, 0.3]),
    kinds=st.tuples(st.sampled_from(sorted(HOSTILE)), st.sampled_from(sorted(HOSTILE))),
    open_rows=st.booleans(),
)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_no_start_and_no_hint_changes_the_answer(
    make: Callable[..., StageEngine],
    seed: int,
    blocks: Lengths,
    soft: float,
    kinds: tuple[str, str],
    open_rows: bool,
) -> None:
    rng = np.random.default_rng(seed)
    qp = firm_at_first(stage_qp(rng), soft)
    if open_rows:  # a guess may name sides that do not exist
        qp.upper[:, 0], qp.lower[:, 1], qp.upper[:, -1] = np.inf, -np.inf, np.inf
    expected = EXACT.solve(condense_blocked(qp, blocks or (1,) * N)).or_raise()
    engine = make(qp.problem, tolerance=1e-6, blocks=blocks)
    write(engine.memory, qp, blocks)
    start, hint = (HOSTILE[kind](rng, engine.memory.lower.shape) for kind in kinds)
    found = engine.run(start, lambda: hint)
    assert found.status is Status.OPTIMAL
    assert_allclose(found.U.ravel(), expected.z, atol=1e-6)
    assert found.factorisations < 100  # bounded time, whatever was guessed


@pytest.mark.parametrize("make", [StructuredEngine, CondensedEngine])
@pytest.mark.parametrize("blocks", FORMS)
def test_the_answer_as_a_hint_is_taken_and_leaves_nothing_to_do(
    make: Callable[..., StageEngine], blocks: Lengths
) -> None:
    qp = stage_qp(np.random.default_rng(5), pull=10.0)
    engine = make(qp.problem, tolerance=1e-6, blocks=blocks)
    write(engine.memory, qp, blocks)
    answer = engine.run()
    assert answer.changes > 3
    engine.reset()
    hinted = engine.run(hint=lambda: answer.working_set)
    assert (hinted.hinted, hinted.changes, hinted.iterations) == (True, 0, 0)
    assert_allclose(hinted.U, answer.U, atol=1e-8)
    settled = engine.run(hint=lambda: np.zeros_like(answer.working_set))
    assert (settled.hinted, settled.changes) == (False, 0)
    engine.reset()
    refused = engine.run(answer.working_set, lambda: np.ones_like(answer.working_set))
    assert (refused.hinted, refused.changes) == (False, 0)


@pytest.mark.parametrize("make", [StructuredEngine, CondensedEngine])
@pytest.mark.parametrize("blocks", FORMS)
def test_a_hint_is_asked_for_once_where_the_start_does_not_settle_and_never_where_it_does(
    make: Callable[..., StageEngine], blocks: Lengths
) -> None:
    qp = stage_qp(np.random.default_rng(5), pull=10.0)
    engine = make(qp.problem, tolerance=1e-6, blocks=blocks)
    write(engine.memory, qp, blocks)
    asked: list[StageEngine] = []

    def nothing() -> None:
        asked.append(engine)

    without = engine.run()
    engine.reset()
    refused = engine.run(hint=nothing)  # an engine that asks in vain goes on as if it had not
    assert len(asked) == 1
    assert (refused.status, refused.changes) == (without.status, without.changes)
    assert_allclose(refused.U, without.U, atol=0.0)
    again = engine.run(hint=nothing)
    assert len(asked) == 1
    assert (again.hinted, again.changes) == (False, 0)
