"""Packets damaged at random, and what a source makes of them; `benchmarks/fuzz_packets.py` does more."""

import dataclasses
from collections.abc import Iterator

import numpy as np

from otolith.live.messages import Telemetry
from otolith.live.wire.formats import WireError
from tests.live.wire.golden import Golden

SEVERE = np.frombuffer(bytes.fromhex("0001 7f80 80ff ff7f c07f 7f7f"), dtype=np.uint8)  # NaN, infinity, edges


def damaged(packet: bytes, generator: np.random.Generator) -> bytes:
    """Return a packet with some bytes replaced, and one time in eight of another length."""
    data = np.frombuffer(packet, dtype=np.uint8).copy()
    places = generator.integers(0, len(data), size=generator.integers(0, 9))
    values = (
        generator.integers(0, 256, size=len(places))
        if generator.random() < 0.5
        else SEVERE[places % len(SEVERE)]
    )
    data[places] = values
    if generator.random() < 0.125:
        data = np.resize(data, generator.integers(0, len(data) + 8))
    return data.tobytes()


def outcomes(golden: Golden, count: int, seed: int) -> Iterator[Telemetry | WireError]:
    """Yield what a source makes of damaged packets; any other exception ends the run."""
    generator = np.random.default_rng(seed)
    for _ in range(count):
        try:
            yield golden.source.parse(damaged(golden.packet, generator))
        except WireError as error:
            yield error


def sound(sample: Telemetry) -> bool:
    """Return whether all numbers are finite and an attitude is a unit quaternion."""
    found = [getattr(sample, one.name) for one in dataclasses.fields(Telemetry)]
    finite = all(np.isfinite(one).all() for one in found if isinstance(one, np.ndarray | float))
    return finite and (sample.attitude is None or bool(abs(np.linalg.norm(sample.attitude) - 1.0) < 1e-6))
