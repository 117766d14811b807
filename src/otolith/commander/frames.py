"""The binary frames of the stream, and the envelope that thins a signal without hiding its extremes.

A frame is a header of 36 bytes, then rows × columns numbers of 32 bits, column after column, so that a page
has every signal as one `Float32Array` without copying. All is little endian. In an envelope every bucket of
`decimation` samples gives two rows of equal time: the least and the largest value of each column. A row that
is NaN in all columns but the time is a gap.
"""

import struct
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Singles

MAGIC: Final = b"OTLC"
VERSION: Final = 1
ENVELOPE, RAW = 1, 2  # kinds
PROTOCOL: Final = "otolith.1"  # subprotocol of the websocket
WINDOW: Final = 3  # frames that may be unacknowledged
HEADER: Final = struct.Struct("<4sHHIddIHH")


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Rows of signals for one client."""

    kind: int  # ENVELOPE or RAW
    sequence: int  # number of the frame for this client
    t0: float  # [s] time of the first row
    age: float  # [s] since the newest sample was made
    decimation: int  # samples per bucket; 1 in a raw frame
    rows: Singles  # (rows, columns)

    def pack(self) -> bytes:
        """Return the frame as bytes."""
        rows, columns = self.rows.shape
        head = HEADER.pack(
            MAGIC,
            VERSION,
            self.kind,
            self.sequence & 0xFFFFFFFF,
            self.t0,
            self.age,
            rows,
            columns,
            self.decimation,
        )
        return head + np.asarray(self.rows, dtype="<f4").tobytes(order="F")


def unpack(message: bytes) -> Frame:
    """Return the frame that `Frame.pack` wrote.

    Raises
    ------
    ValueError : the bytes are no frame of this version.
    """
    magic, version, kind, sequence, t0, age, rows, columns, decimation = HEADER.unpack_from(message)
    if (magic, version) != (MAGIC, VERSION) or len(message) != HEADER.size + 4 * rows * columns:
        raise ValueError(f"no frame of version {VERSION}")
    data = np.frombuffer(message, dtype="<f4", offset=HEADER.size).reshape((rows, columns), order="F")
    return Frame(kind=kind, sequence=sequence, t0=t0, age=age, decimation=decimation, rows=data)


def envelope(rows: Singles, bucket: int) -> Singles:
    """Return the least and the largest value of every column in buckets of rows (2 n / bucket, columns).

    Column 0 is the time; both rows of a bucket have that of its middle. A NaN is left out where a bucket also
    has numbers, and stays where it has none. The last bucket may be shorter.
    """
    first = np.arange(0, len(rows), bucket)
    made = np.empty((2 * len(first), rows.shape[1]), dtype=rows.dtype)
    np.fmin.reduceat(rows, first, axis=0, out=made[0::2])
    np.fmax.reduceat(rows, first, axis=0, out=made[1::2])
    middle = 0.5 * (made[0::2, 0] + made[1::2, 0])
    made[0::2, 0] = made[1::2, 0] = middle
    return made


def gap(time: float, columns: int, count: int) -> Singles:
    """Return rows (count, columns) that are NaN in all columns but the time [s]."""
    rows = np.full((count, columns), np.nan, dtype=np.float32)
    rows[:, 0] = time
    return rows


def javascript() -> str:
    """Return the constants of the layout as a module for the page."""
    constants = {
        "MAGIC": f'"{MAGIC.decode()}"',
        "VERSION": VERSION,
        "PROTOCOL": f'"{PROTOCOL}"',
        "WINDOW": WINDOW,
        "KIND": f"{{ENVELOPE: {ENVELOPE}, RAW: {RAW}}}",
        "HEADER_BYTES": HEADER.size,
        "AT": "{version: 4, kind: 6, sequence: 8, t0: 12, age: 20, rows: 28, columns: 32, decimation: 34}",
    }
    lines = [f"export const {name} = {value};" for name, value in constants.items()]
    return "// Written by a test from otolith/commander/frames.py.\n" + "\n".join(lines) + "\n"
