"""The ring of rows: what is read is what was written, or a gap that is known as one."""

import multiprocessing
import os
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.commander.rows import CAPACITY, Rows


@pytest.fixture(scope="module")
def ends() -> Iterator[tuple[Rows, Rows]]:
    name = f"otolith-test-rows-{os.getpid()}"
    with Rows(name, 2) as writer, Rows(name) as reader:
        yield writer, reader


def numbered(first: int, count: int) -> np.ndarray:
    """Return rows whose first column is their own number, as 32 bits hold it."""
    k = np.arange(first, first + count)
    return np.column_stack([k, -k]).astype(np.float32)


@settings(max_examples=30, deadline=None)
@given(pieces=st.lists(st.tuples(st.integers(0, 40_000), st.integers(0, 5_000)), min_size=1, max_size=8))
def test_a_reader_gets_every_row_or_knows_which_are_gone(
    ends: tuple[Rows, Rows], pieces: list[tuple[int, int]]
) -> None:
    writer, reader = ends
    writer.begin(7)
    assert (reader.generation, reader.written) == (7, 0)
    written = cursor = 0
    for count, most in pieces:
        writer.write(numbered(written, count))
        written += count
        first, rows = reader.read(cursor, most)
        assert first >= cursor
        assert first == cursor or first == written - CAPACITY + 2_048  # what is gone was overwritten
        assert len(rows) == min(most, written - first)
        np.testing.assert_array_equal(rows, numbered(first, len(rows)))
        cursor = first + len(rows)


def write_one_by_one(where: str, count: int) -> None:
    with Rows(where) as writer:
        row = np.zeros((1, 2), dtype=np.float32)
        for _ in range(count):
            writer.write(row)


def test_a_reader_never_sees_a_number_that_is_half_written() -> None:
    name = f"otolith-test-rows-words-{os.getpid()}"
    with Rows(name, 2) as reader:
        reader.begin(1)
        writer = multiprocessing.get_context("spawn").Process(target=write_one_by_one, args=(name, 100_000))
        writer.start()
        written = 0
        while writer.is_alive():
            for _ in range(1_000):
                before, written = written, reader.written
                assert before <= written
                assert reader.age >= 0.0
        writer.join()
        assert reader.written == 100_000


def test_another_run_begins_without_rows_or_age(ends: tuple[Rows, Rows]) -> None:
    writer, reader = ends
    writer.begin(1)
    assert reader.age == float("inf")
    writer.write(numbered(0, 3))
    assert 0.0 <= reader.age < 10.0
    writer.begin(2)
    assert (reader.generation, reader.written, reader.age) == (2, 0, float("inf"))
    assert reader.read(0, 10)[1].shape == (0, 2)


def test_a_reader_that_is_overtaken_while_it_copies_reads_again(
    ends: tuple[Rows, Rows], monkeypatch: pytest.MonkeyPatch
) -> None:
    writer, reader = ends
    writer.begin(3)
    writer.write(numbered(0, CAPACITY))
    seen: list[int] = []
    plain = vars(Rows)["written"].fget
    assert plain is not None

    def written(rows: Rows) -> int:
        seen.append(plain(rows))
        if len(seen) == 2:  # after the copy, before the look whether it is whole
            Rows.written = property(plain)  # type: ignore[method-assign,assignment]
            writer.write(numbered(CAPACITY, 30_000))
            return plain(rows)
        return seen[-1]

    monkeypatch.setattr(Rows, "written", property(written))
    first, rows = reader.read(0, 100)
    np.testing.assert_array_equal(rows, numbered(first, 100))
    assert first == CAPACITY + 30_000 - CAPACITY + 2_048
