"""What sends in the virtual world, and what networks do to packets."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.live.messages import Flag
from otolith.live.wire.generic import TELEMETRY, seal

SECOND: Final = 1_000_000_000  # [ns]
MS: Final = 1_000_000  # [ns]


@dataclass(slots=True)
class Link:
    """A link for packets, with everything that networks do to them."""

    delay_ns: int = MS
    jitter_ns: int = 0  # largest further delay
    loss: float = 0.0  # share of packets
    duplication: float = 0.0
    reordering: float = 0.0  # share of packets that come 40 ms later
    corruption: float = 0.0
    silent_until_ns: int = 0

    def times(self, now_ns: int, rng: np.random.Generator) -> list[int]:
        """Return when a packet that is sent now arrives: not at all, once, or twice."""
        if now_ns < self.silent_until_ns or rng.random() < self.loss:
            return []
        late = 40 * MS if rng.random() < self.reordering else 0
        arrival = now_ns + self.delay_ns + late + int(rng.integers(0, self.jitter_ns + 1))
        return [arrival, arrival + MS] if rng.random() < self.duplication else [arrival]

    def content(self, packet: bytes, rng: np.random.Generator) -> bytes:
        """Return what arrives of a packet."""
        if rng.random() >= self.corruption:
            return packet
        broken = bytearray(packet)
        broken[int(rng.integers(len(packet)))] ^= 1 << int(rng.integers(8))
        return bytes(broken) if rng.random() < 0.5 else bytes(broken[: int(rng.integers(len(packet)))])


@dataclass(slots=True)
class Source:
    """A vehicle that sends the generic packet.

    Parameters
    ----------
    drive : time [s] -> specific force and angular rate (6,) in our axes.
    change : makes other numbers of those of a packet: a fault of the source.
    """

    drive: Callable[[float], Vec]
    rate_hz: float = 60.0
    sequence: int = 0
    clock_ns: int = 100 * SECOND  # what the sender's clock shows when ours shows zero
    flags: Flag = Flag.RUNNING
    speed: float = 20.0  # [m/s]
    change: Callable[[dict[str, tuple[Any, ...]]], dict[str, tuple[Any, ...]]] | None = None

    def packet(self, now_ns: int) -> bytes:
        """Return the next packet."""
        self.sequence += 1
        wanted = self.drive(1e-9 * now_ns)
        values: dict[str, tuple[Any, ...]] = {
            "sequence": (self.sequence,),
            "time": (now_ns + self.clock_ns,),
            "flags": (int(self.flags),),
            "source": (0,),
            "specific force": tuple(wanted[:3]),
            "angular rate": tuple(wanted[3:]),
            "attitude": (1.0, 0.0, 0.0, 0.0),
            "velocity": (self.speed, 0.0, 0.0),
        }
        return seal(TELEMETRY, values if self.change is None else self.change(values))
