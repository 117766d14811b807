"""Records one after the other: the form of every file that live operation appends to.

A record is u32 length of the payload, u32 CRC-32 of kind and payload, u8 kind, payload; little endian. A file
whose writer was killed ends within a record at most; a damaged one is readable up to its damage.
"""

import struct
import zlib
from collections.abc import Iterator, Mapping
from mmap import mmap
from typing import Final, NamedTuple

from otolith.core.errors import CorruptFile

HEAD: Final = struct.Struct("<IIB")


class Record(NamedTuple):
    """A record, and where it begins in its file."""

    place: int
    kind: int
    payload: bytes


def record(kind: int, payload: bytes) -> bytes:
    """Return a record, ready to be appended to a file."""
    return HEAD.pack(len(payload), zlib.crc32(payload, zlib.crc32(bytes([kind]))), kind) + payload


class Records:
    """The records of a file, in their order.

    Parameters
    ----------
    source : the file's name, for errors.
    kinds : names of the kinds of records, for errors.
    most : longest payload that is possible [bytes].

    Raises
    ------
    CorruptFile : when the iteration comes to a record whose checksum is wrong, or that is impossible. What
        came before is sound.
    """

    def __init__(self, data: bytes | mmap, source: str, kinds: Mapping[int, str], *, most: int) -> None:
        self._data, self._source, self._kinds, self._most = data, source, kinds, most
        self.cut = False  # after the iteration: whether the file ends within a record

    def __iter__(self) -> Iterator[Record]:
        place, data = 0, self._data
        while place < len(data):
            if len(data) - place < HEAD.size:
                self.cut = True
                return
            length, checksum, kind = HEAD.unpack(data[place : place + HEAD.size])
            if length > self._most:
                raise self._damage(place, kind, f"it would have {length:,} bytes")
            payload = data[place + HEAD.size : place + HEAD.size + length]
            if len(payload) < length:
                self.cut = True
                return
            if zlib.crc32(payload, zlib.crc32(bytes([kind]))) != checksum:
                raise self._damage(place, kind, "its checksum is wrong")
            yield Record(place, kind, payload)
            place += HEAD.size + length

    def _damage(self, place: int, kind: int, what: str) -> CorruptFile:
        named = self._kinds.get(kind, f"of the unknown kind {kind}")
        return CorruptFile(f"{self._source} is damaged at byte {place:,}, in a record {named}: {what}")
