"""Damage as a broken disk or cable does it; a helper of the tests."""

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np


def flipped(path: Path, *, count: int, seed: int = 14, head: int = 4096) -> Iterator[int]:
    """Flip one bit of a file, yield its place, flip it back; every second one in its first `head` bytes."""
    good, rng = path.read_bytes(), np.random.default_rng(seed)
    with path.open("r+b", buffering=0) as file:
        for k in range(count):
            place = int(rng.integers(min(len(good), head) if k % 2 else len(good)))
            os.pwrite(file.fileno(), bytes([good[place] ^ 1 << int(rng.integers(8))]), place)
            yield place
            os.pwrite(file.fileno(), good[place : place + 1], place)
