"""Packets that are a list of single channels: Codemasters' fixed one, its custom_udp, and EA SPORTS WRC.

The game, or the user, says in a file which channels stand in a packet and in which order. From that list a
`Packet` is made, and what is known by a channel's name is put together: forces, rates, velocity,
directions. What the list lacks is not in the sample.

World axes: x left, y up, z forward at heading zero, as EA documents them for WRC. Accelerations of WRC are
in world axes and are projected on the car's directions; forces of Codemasters' games are the car's already,
in g.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.live.messages import Flag, Telemetry
from otolith.live.wire.attitude import axes_of, quaternion
from otolith.live.wire.formats import Packet, Values, WireError, turning

_WORLD: Final = turning("left up forward")
_CAR: Final = turning("left up forward")


@dataclass(frozen=True, slots=True, kw_only=True)
class Names:
    """Which channels hold what. Three channels make a vector; an empty name stands for zero."""

    force_car: tuple[str, ...] = ()  # forward, left, up
    acceleration_world: tuple[str, ...] = ()  # left, up, forward
    velocity_world: tuple[str, ...] = ()
    velocity_car: tuple[str, ...] = ()
    position: tuple[str, ...] = ()
    forward: tuple[str, ...] = ()
    left: tuple[str, ...] = ()
    up: tuple[str, ...] = ()
    rate: tuple[str, ...] = ()  # roll, pitch, yaw
    time: str = ""
    paused: str = ""


@dataclass(frozen=True, slots=True)
class Channels:
    """A source whose packet is a list of channels."""

    name: str
    packet: Packet
    names: Names

    def parse(self, packet: bytes) -> Telemetry:
        """Return the sample that a packet holds; see `source.Source`."""
        values, names = self.packet.decode(packet), self.names
        axes = self._axes(values)
        velocity = _vector(values, names.velocity_car, _CAR)
        if velocity is None:
            velocity = _projected(axes, _vector(values, names.velocity_world, _WORLD))
        acceleration = _vector(values, names.force_car, None)
        if acceleration is None:
            acceleration = _projected(axes, _vector(values, names.acceleration_world, _WORLD))
        return Telemetry(
            sender_ns=self._time(values),
            flags=self._flags(values),
            acceleration=acceleration,
            angular_rate=_vector(values, names.rate, None),
            attitude=None if axes is None else quaternion(axes),
            velocity=velocity,
            position=_vector(values, names.position, _WORLD),
            speed=None if velocity is None else float(np.linalg.norm(velocity)),
        )

    def _axes(self, values: Values) -> Mat | None:
        """Return the car's axes in the world, and refuse directions of which `up` is on the wrong side."""
        forward, left = (_vector(values, one, _WORLD) for one in (self.names.forward, self.names.left))
        if forward is None or left is None:
            return None
        axes = axes_of(forward, left, self.packet.name)
        up = _vector(values, self.names.up, _WORLD)
        if up is not None and float(up @ axes[:, 2]) < 0.9:
            agreement = f"{float(up @ axes[:, 2]):.4g}"
            raise WireError(
                f"up direction of {self.packet.name}, along forward × left",
                agreement,
                "about 1, a right-handed frame",
            )
        return axes

    def _time(self, values: Values) -> int | None:
        return round(values[self.names.time][0] * 1e9) if self.names.time in values else None

    def _flags(self, values: Values) -> Flag | None:
        if self.names.paused not in values:
            return None
        return Flag.PAUSED if values[self.names.paused][0] else Flag.RUNNING


def _vector(values: Mapping[str, tuple[float, ...]], names: tuple[str, ...], M: Mat | None) -> Vec | None:
    """Return the vector (3,) of three channels, turned by M; None if the packet lacks any of them."""
    if not names or not all(name in values for name in names if name):
        return None
    stated = np.array([values[name][0] if name else 0.0 for name in names])
    return stated if M is None else M @ stated


def _projected(axes: Mat | None, vector_world: Vec | None) -> Vec | None:
    """Return a world vector in the car's axes; None where the packet does not say how the car stands."""
    return None if axes is None or vector_world is None else axes.T @ vector_world
