"""Sources whose frames come in two packets, as F1's do: both halves become one sample."""

from dataclasses import fields

from otolith.live.messages import Telemetry
from otolith.live.wire.formats import OtherPacket
from otolith.live.wire.source import Source


class Joined:
    """Joins the halves of a frame, which bear the same sequence number.

    It is the only reader of packets that remembers one: the first half of a frame. That half is answered
    with `OtherPacket`; if its other half never comes, the frame is lost like any packet that is.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._half: Telemetry | None = None

    @property
    def name(self) -> str:
        """Return the source's name, as a user writes it."""
        return self._source.name

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample of a frame, once its second half is here; see `source.Source`."""
        sample, half = self._source.parse(packet), self._half
        self._half = sample
        if half is None or half.sequence != sample.sequence:
            raise OtherPacket(f"frame {sample.sequence} of {self.name}", "half here", "whole to be used")
        joined = _joined(half, sample)
        if joined.acceleration is None or joined.angular_rate is None:  # the same half twice
            raise OtherPacket(
                f"frame {sample.sequence} of {self.name}", "half here, twice", "whole to be used"
            )
        self._half = None
        return joined


def _joined(first: Telemetry, second: Telemetry) -> Telemetry:
    """Return the sample that holds what either does; the second counts where both do."""
    both = {one.name: getattr(second, one.name) for one in fields(Telemetry)}
    return Telemetry(
        **{name: getattr(first, name) if value is None else value for name, value in both.items()}
    )
