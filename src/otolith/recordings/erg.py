"""CarMaker results: an .erg file of binary records, and the .erg.info file that describes them.

The format is described here after files and public readers of it. The data begin with 16 bytes: "CM-ERG" and
two zeros, version (1), byte order (0 little, 1 big), size of a record in 16 bits, four unused bytes. The info
file is text, ``key = value``: File.Format, File.ByteOrder, File.At.<n>.Name and .Type for the n-th field of a
record, counted from 1, and Quantity.<name>.Unit; also .Factor and .Offset where they differ from 1 and 0.
"""

import re
import struct
from collections.abc import Mapping
from typing import Final

import numpy as np

from otolith.core.errors import CorruptFile, InputError, one_of
from otolith.recordings.channels import Layout
from otolith.recordings.recorded import Columns

HEADER: Final = struct.Struct("<8sBBH4x")
MAGIC: Final = b"CM-ERG\0\0"
VERSION: Final = 1
TYPES: Final = {
    "Double": "f8",
    "Float": "f4",
    "LongLong": "i8",
    "ULongLong": "u8",
    "Long": "i4",
    "ULong": "u4",
    "Int": "i4",
    "UInt": "u4",
    "Short": "i2",
    "UShort": "u2",
    "Char": "i1",
    "UChar": "u1",
}
ORDERS: Final = {"littleendian": ("<", 0), "bigendian": (">", 1)}
_BYTES: Final = re.compile(r"(\d+) Bytes?")


def parse_erg(info: str, data: bytes, source: str) -> Columns:
    """Return the numeric channels of a CarMaker result from its .erg.info (text) and its .erg (bytes).

    An incomplete last record, which an interrupted simulation leaves, is dropped with a note.

    Raises
    ------
    InputError : the info describes another format, no channels, or an unknown type.
    CorruptFile : the data do not begin as CarMaker's, or not as the info states.
    """
    entries = _entries(info)
    order, code = _order(entries, source)
    record, kept = _record(entries, order, source)
    _check_header(data, code, record.itemsize, source)
    body = len(data) - HEADER.size
    rows, rest = divmod(body, record.itemsize)
    table = np.frombuffer(data, dtype=record, count=rows, offset=HEADER.size)
    notes = (f"{source}: the last record is incomplete and was dropped",) if rest else ()
    values = []
    for position, name in kept:
        factor = float(entries.get(f"Quantity.{name}.Factor", "1"))
        offset = float(entries.get(f"Quantity.{name}.Offset", "0"))
        raw = table[f"f{position}"]
        values.append(raw if (factor, offset) == (1.0, 0.0) else factor * raw + offset)
    return Columns(
        source=source,
        names=tuple(name for _, name in kept),
        units=tuple(entries.get(f"Quantity.{name}.Unit", "").strip(" -") for _, name in kept),
        values=tuple(values),
        layout=Layout(form="CarMaker result", rows=rows),
        notes=notes,
    )


def _entries(info: str) -> Mapping[str, str]:
    lines = (line.partition("=") for line in info.splitlines() if not line.startswith("#"))
    return {key.strip(): value.strip() for key, equals, value in lines if equals}


def _order(entries: Mapping[str, str], source: str) -> tuple[str, int]:
    form = entries.get("File.Format", "erg")
    if form.lower() != "erg":
        raise InputError(f"File.Format of {source}.info", repr(form), "erg")
    order = entries.get("File.ByteOrder", "LittleEndian")
    if order.lower() not in ORDERS:
        raise InputError(f"File.ByteOrder of {source}.info", repr(order), "LittleEndian or BigEndian")
    return ORDERS[order.lower()]


def _record(
    entries: Mapping[str, str], order: str, source: str
) -> tuple[np.dtype[np.void], list[tuple[int, str]]]:
    """Return the layout of a record, and position and name of its numeric fields; others are padding."""
    fields: list[tuple[str, str]] = []
    kept: list[tuple[int, str]] = []
    position = 1
    while f"File.At.{position}.Name" in entries:
        name, kind = entries[f"File.At.{position}.Name"], entries.get(f"File.At.{position}.Type", "Double")
        space = _BYTES.fullmatch(kind)
        if kind in TYPES:
            fields.append((f"f{position}", order + TYPES[kind]))
            kept.append((position, name))
        elif space:
            fields.append((f"f{position}", f"V{space.group(1)}"))
        else:
            raise InputError(f"type of {name!r} in {source}.info", repr(kind), one_of(TYPES, kind))
        position += 1
    if not kept:
        raise InputError(f"File.At.1.Name of {source}.info", "missing", "the name of the first channel")
    return np.dtype(fields), kept


def _check_header(data: bytes, code: int, size: int, source: str) -> None:
    if len(data) < HEADER.size:
        raise CorruptFile(f"{source} is cut off: it has {len(data)} bytes, its header takes {HEADER.size}")
    magic, version, order, record = HEADER.unpack_from(data)
    if magic != MAGIC:
        raise CorruptFile(f"{source} is no CarMaker result: it does not begin with CM-ERG")
    if version != VERSION:
        raise CorruptFile(f"{source} has version {version} of its format, this program reads {VERSION}")
    if order == 1:
        record = int.from_bytes(record.to_bytes(2, "little"), "big")
    if order != code or record != size:
        raise CorruptFile(
            f"{source} does not belong to its .info: records of {record} bytes in byte order {order}, "
            f"described are {size} bytes in byte order {code}"
        )
