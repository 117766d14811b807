"""Frames and envelopes, against loops in plain Python."""

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.commander.frames import ENVELOPE, HEADER, Frame, envelope, gap, javascript, unpack
from tests.commander.golden_frame import CONSTANTS, GOLDEN, golden


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


def test_the_layout_is_that_of_the_golden_frame_and_of_the_page() -> None:
    """Whoever changes the layout runs tests/commander/golden_frame.py, and raises VERSION."""
    assert golden().pack() == GOLDEN.read_bytes()
    assert javascript() == CONSTANTS.read_text(encoding="utf-8")


@pytest.mark.skipif(
    shutil.which("node") is None, reason="node, which reads the frame as the page does, is absent"
)
def test_the_page_reads_the_golden_frame(tmp_path: Path) -> None:
    """The page's own `decode`, run by node; its imports are of addresses, which node needs as files."""
    web = CONSTANTS.parent
    (tmp_path / "frames.mjs").write_text(CONSTANTS.read_text(encoding="utf-8"), encoding="utf-8")
    stream = (web / "stream.js").read_text(encoding="utf-8").replace("/web/frames.js", "./frames.mjs")
    (tmp_path / "stream.mjs").write_text(stream, encoding="utf-8")
    (tmp_path / "read.mjs").write_text(
        'import {readFileSync} from "node:fs";\nimport {decode} from "./stream.mjs";\n'
        "const bytes = new Uint8Array(readFileSync(process.argv[2]));\n"
        "const frame = decode(bytes.buffer.slice(0, bytes.length));\n"
        "const text = (value) => (Number.isNaN(value) ? null : value);\n"
        "console.log(JSON.stringify({...frame, signals: frame.signals.map((one) => [...one].map(text))}));\n",
        encoding="utf-8",
    )
    done = subprocess.run(
        ["node", str(tmp_path / "read.mjs"), str(GOLDEN)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    read, frame = json.loads(done.stdout), golden()
    assert (read["kind"], read["sequence"], read["rows"]) == (frame.kind, frame.sequence, len(frame.rows))
    assert read["age"] == frame.age
    signals = [[np.nan if one is None else one for one in signal] for signal in read["signals"]]
    np.testing.assert_array_equal(np.array(signals, dtype=np.float32), frame.rows.T)
