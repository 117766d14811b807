"""Frames and envelopes, against loops in plain Python."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.commander.frames import ENVELOPE, HEADER, Frame, envelope, gap, unpack


def test_a_frame_comes_back_as_it_was() -> None:
    rows = np.arange(12, dtype=np.float32).reshape(4, 3)
    rows[1, 2] = np.nan
    sent = Frame(kind=ENVELOPE, sequence=7, t0=0.5, age=0.01, decimation=10, rows=rows)
    packed = sent.pack()
    back = unpack(packed)
    assert len(packed) == HEADER.size + 4 * 12 == 36 + 48
    np.testing.assert_array_equal(back.rows, rows)
    assert (back.kind, back.sequence, back.t0, back.age, back.decimation) == (ENVELOPE, 7, 0.5, 0.01, 10)
    column = np.frombuffer(packed, dtype="<f4", offset=36 + 4 * 4, count=4)  # the second, in one piece
    np.testing.assert_array_equal(column, rows[:, 1])


def test_a_shortened_or_foreign_frame_is_refused() -> None:
    packed = Frame(kind=1, sequence=1, t0=0.0, age=0.0, decimation=1, rows=gap(0.0, 2, 2)).pack()
    for damaged in (packed[:-1], b"XXXX" + packed[4:]):
        with pytest.raises(ValueError, match="no frame"):
            unpack(damaged)


numbers = st.one_of(st.floats(-1e3, 1e3, width=32), st.just(np.nan))


@given(st.lists(st.tuples(numbers, numbers), min_size=1, max_size=37), st.integers(1, 12))
def test_an_envelope_has_least_and_largest_of_every_bucket(
    values: list[tuple[float, float]], wide: int
) -> None:
    time = np.arange(len(values), dtype=np.float32)[:, None]
    rows = np.hstack([time, np.array(values, dtype=np.float32)])
    made = envelope(rows, wide)
    for k, first in enumerate(range(0, len(rows), wide)):
        for column in (1, 2):
            known = [float(one) for one in rows[first : first + wide, column] if not np.isnan(one)]
            low, high = (min(known), max(known)) if known else (np.nan, np.nan)
            np.testing.assert_array_equal(made[2 * k : 2 * k + 2, column], [low, high])
        assert made[2 * k, 0] == made[2 * k + 1, 0]
    assert len(made) == 2 * -(-len(rows) // wide)
