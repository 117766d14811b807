"""What every telemetry source does: one packet becomes one sample, or a `WireError`."""

from typing import Protocol

from otolith.live.messages import Telemetry


class Source(Protocol):
    """Reads the packets of one source. It is pure: equal bytes give equal samples, and it knows no past."""

    @property
    def name(self) -> str:
        """Return the source's name, as a user writes it."""

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample that a packet holds; NaN, infinity and impossible numbers never pass.

        Raises
        ------
        WireError : the packet is damaged or not of this source; nothing else is ever raised.
        OtherPacket : the packet is sound, but of a kind that holds no motion.
        """
