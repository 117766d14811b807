"""Writes the golden frame, and the constants of the page: `python -m tests.commander.golden_frame`."""

from importlib.resources import files
from pathlib import Path

import numpy as np

from otolith.commander.frames import ENVELOPE, Frame, javascript

GOLDEN = Path(__file__).with_name("golden_frame.bin")
CONSTANTS = Path(str(files("otolith.commander") / "web" / "frames.js"))


def golden() -> Frame:
    """Return a frame with a gap, both signs, and numbers that 32 bits do not hold exactly."""
    rows = np.array(
        [[0.0, np.nan, np.nan], [0.0, np.nan, np.nan], [0.005, -1.5, 0.1], [0.005, 2.25, 9.81]],
        dtype=np.float32,
    )
    return Frame(kind=ENVELOPE, sequence=4_000_000_001, t0=1.5, age=0.0625, decimation=10, rows=rows)


if __name__ == "__main__":
    GOLDEN.write_bytes(golden().pack())
    CONSTANTS.write_text(javascript(), encoding="utf-8")
