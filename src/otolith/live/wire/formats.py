"""Packets described as data, and the one decoder that reads all of them.

A packet is a list of fields in the order of the wire. A field says its type, its unit and the directions of
its axes; from these follow its place, its factor to SI units and its turning into x forward, y left, z up.
Whatever the bytes, decoding ends in numbers that are finite and possible, or in a `WireError`.
"""

import math
import struct
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.recordings.units import STANDARD_GRAVITY


class WireError(InputError):
    """A packet is refused: the sentence names the field, its value, and the bound with its unit."""


class OtherPacket(WireError):
    """A packet is sound but of a kind that holds no motion and shares the port. It says nothing about the
    health of the source, so whoever counts refused packets leaves it out.
    """


Number = int | float
Values = Mapping[str, tuple[Number, ...]]

ANY: Final = sys.float_info.max  # bound of numbers that only have to be finite
# type of a field -> code of the struct module
TYPES: Final = {
    "u8": "B",
    "i8": "b",
    "u16": "H",
    "i16": "h",
    "u32": "I",
    "i32": "i",
    "u64": "Q",
    "f32": "f",
    "f64": "d",
    "pad": "x",
}
# unit -> (factor to SI, largest size in SI units, SI unit). The bounds are those of what is possible,
# far beyond driving. What is only implausible is judged where the past is known, in `live.core.health`.
UNITS: Final = {
    "": (1.0, ANY, ""),
    "m": (1.0, 1e8, "m"),
    "m/65536": (1.0 / 65536.0, 1e8, "m"),
    "m/s": (1.0, 1e4, "m/s"),
    "m/s²": (1.0, 1e4, "m/s²"),
    "g": (STANDARD_GRAVITY, 1e4, "m/s²"),
    "g/1000": (1e-3 * STANDARD_GRAVITY, 1e4, "m/s²"),
    "rad": (1.0, 1e4, "rad"),
    "deg": (math.pi / 180.0, 1e4, "rad"),
    "rad/s": (1.0, 1e3, "rad/s"),
    "rad/s²": (1.0, 1e6, "rad/s²"),
    "unit/32767": (1.0 / 32767.0, 1.01, ""),
    "unit": (1.0, 1.01, ""),
    "s": (1.0, 1e9, "s"),
    "ms": (1e-3, 1e9, "s"),
    "ns": (1.0, ANY, "ns"),
}
# direction -> unit vector in x forward, y left, z up
DIRECTIONS: Final = {
    "forward": (1.0, 0.0, 0.0),
    "back": (-1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "right": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}


def turning(axes: str, *, rotation: bool = False) -> Mat:
    """Return the matrix (3, 3) that turns a vector into x forward, y left, z up.

    Parameters
    ----------
    axes : where each component points, such as "right up forward".
    rotation : whether the vector is an angular rate. In left-handed axes positive rotation follows the left
        hand, so that the turning of a rate has the opposite sign to that of a velocity.
    """
    M = np.array([DIRECTIONS[word] for word in axes.split()]).T
    handed = round(float(np.linalg.det(M)))
    return M * handed + 0.0 if rotation else M  # adding zero makes -0.0 a plain zero


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """One number of a packet, or several of one kind: a vector, or an array that is skipped."""

    name: str  # what it is; fields that nothing uses are of type "pad"
    type: str  # one of TYPES
    count: int = 1
    unit: str = ""  # one of UNITS
    axes: str = ""  # of a vector: where its components point, as the source's document says
    scale: float = 1.0  # by which the source multiplies before it sends

    def __post_init__(self) -> None:
        if self.type not in TYPES or self.unit not in UNITS or self.count < 1:
            raise ValueError(f"field {self.name} has type {self.type}, unit {self.unit}, count {self.count}")


class Scaling(NamedTuple):
    """How the numbers of a field are read: where they stand, what makes SI units of them, and their bound."""

    name: str
    where: slice
    factor: float
    bound: float
    stated: Field


@dataclass(frozen=True, kw_only=True)
class Packet:
    """A packet's fields in the order of the wire; what they hold is checked before anyone sees it."""

    name: str  # of the source and the packet, for the user
    fields: tuple[Field, ...]
    magic: bytes = b""  # with which the packet begins; not a field
    order: str = "<"  # little endian; ">" is big endian
    tail: int = 0  # bytes at the end that are not read
    plan: tuple[Scaling, ...] = field(init=False, repr=False)  # how the numbers of each field are read

    def __post_init__(self) -> None:
        plan, at = [], 0
        for one in self.fields:
            if one.type != "pad":
                factor, bound, _ = UNITS[one.unit]
                plan.append(Scaling(one.name, slice(at, at + one.count), factor / one.scale, bound, one))
                at += one.count
        object.__setattr__(self, "plan", tuple(plan))

    @cached_property
    def layout(self) -> struct.Struct:
        """Return the packet's form for the struct module, the magic and the tail included as padding."""
        codes = "".join(f"{one.count}{TYPES[one.type]}" for one in self.fields)
        return struct.Struct(f"{self.order}{len(self.magic)}x{codes}{self.tail}x")

    @property
    def size(self) -> int:
        """Return the packet's length in bytes."""
        return self.layout.size

    def offset(self, name: str) -> int:
        """Return where a field begins [bytes], for documents and tests."""
        before = 0
        for one in self.fields:
            if one.name == name:
                return len(self.magic) + before
            before += one.count * struct.calcsize(f"{self.order}{TYPES[one.type]}")
        raise KeyError(name)

    def decode(self, packet: bytes) -> Values:
        """Return the numbers of every field in SI units, in the axes of the wire.

        Raises
        ------
        WireError : size or magic are wrong, or a number is not finite or not possible.
        """
        if len(packet) != self.size:
            raise WireError(f"size of {self.name}", f"{len(packet)} bytes", f"{self.size} bytes")
        if not packet.startswith(self.magic):
            found = packet[: len(self.magic)].hex(" ")
            raise WireError(f"start of {self.name}", found, f"{self.magic.hex(' ')} (hexadecimal bytes)")
        numbers: tuple[Number, ...] = self.layout.unpack(packet)
        values: dict[str, tuple[Number, ...]] = {}
        for name, where, factor, bound, stated in self.plan:
            part = numbers[where]
            if factor != 1.0:  # whole numbers of 64 bits would lose digits
                part = tuple([number * factor for number in part])
            for number in part:
                if not -bound <= number <= bound:  # NaN is not within any bound
                    raise self._impossible(stated, number, bound)
            values[name] = part
        return values

    def _impossible(self, of: Field, number: Number, bound: float) -> WireError:
        unit = UNITS[of.unit][2]
        allowed = f"within ±{bound:g} {unit}".rstrip() if bound < ANY else "finite"
        return WireError(f"{of.name} of {self.name}", f"{number:.6g} {unit}".rstrip(), allowed)

    def encode(self, values: Mapping[str, tuple[Number, ...]]) -> bytes:
        """Return the packet that holds these numbers, given in SI units; fields not given are zero."""
        numbers: list[Number] = []
        for one in self.fields:
            if one.type == "pad":
                continue
            given = values.get(one.name, (0,) * one.count)
            if len(given) != one.count:
                raise ValueError(f"{one.name} has {len(given)} numbers, expected {one.count}")
            factor = UNITS[one.unit][0] / one.scale
            if factor != 1.0:  # whole numbers of 64 bits would lose digits in a division
                given = tuple(number / factor for number in given)
            numbers += given if one.type in ("f32", "f64") else map(round, given)
        data = bytearray(self.layout.pack(*numbers))
        data[: len(self.magic)] = self.magic
        return bytes(data)


def vector(values: Values, name: str, M: Mat) -> Vec:
    """Return a vector field (3,) turned by a matrix of `turning`."""
    return np.asarray(M @ np.array(values[name], dtype=np.float64), dtype=np.float64)
