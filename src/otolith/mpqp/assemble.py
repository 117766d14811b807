"""Turn the result of an enumeration into a law: number the regions and link the neighbours.

The notation is that of `lookup` (ids, mirror images) and `sets` (codes).
"""

import numpy as np

from otolith.core.arrays import Bools, Ints
from otolith.mpqp.expand import UNKNOWN, Found, Ints32
from otolith.mpqp.law import Law
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.problem import ParametricQp
from otolith.mpqp.sets import SetTable, Words


def assemble(
    problem: ParametricQp,
    form: LeastDistance,
    table: SetTable,
    found: Found,
    *,
    tolerance: float,
    seconds: float,
    compile_seconds: float,
) -> Law:
    """Make a law of the regions found; regions that are their own mirror images come first."""
    h, facets = int(found.used[0]), int(found.used[1])
    owner = found.owner[:h].astype(np.int64)
    own = _own_images(table.keys[owner], form)
    order = np.argsort(~own, kind="stable")
    number = np.full(int(table.used[0]), -1, dtype=np.int64)
    number[owner[order]] = np.arange(h)
    lengths = np.diff(found.start[: h + 1])[order]
    pick = _slices(found.start[:h][order], lengths)
    return Law(
        problem=problem, form=form, keys=table.keys[owner[order]], centre=found.centre[:h][order],
        radius=found.radius[:h][order], start=np.append(0, np.cumsum(lengths)).astype(np.int32),
        rows=found.rows[:facets][pick], constraint=found.constraint[:facets][pick],
        beyond=_linked(found.beyond[:facets][pick], number, h, int(own.sum())), alone=int(own.sum()),
        tolerance=tolerance, seconds=seconds, compile_seconds=compile_seconds,
    )  # fmt: skip


def _own_images(keys: Words, form: LeastDistance) -> Bools:
    """Mark the active sets that are their own mirror images; all of them if there is no symmetry."""
    if len(form.mirror) == 0:
        return np.ones(len(keys), dtype=np.bool_)
    m = len(form.rows)
    octets = keys.astype("<u8").view(np.uint8).reshape(len(keys), -1)
    bits = np.unpackbits(octets, axis=1, bitorder="little")[:, :m]
    own: Bools = (bits == bits[:, form.mirror]).all(axis=1)
    return own


def _slices(start: Ints, lengths: Ints) -> Ints:
    """Concatenate the indices start[i], ..., start[i] + lengths[i] - 1 for all i."""
    offset = np.cumsum(lengths) - lengths
    total = int(lengths.sum())
    indices: Ints = np.arange(total) + np.repeat(start - offset, lengths)
    return indices


def _linked(beyond: Ints32, number: Ints, h: int, alone: int) -> Ints32:
    """Convert codes of active sets to region ids; a set that is no region becomes UNKNOWN."""
    ids = beyond.astype(np.int64)
    codes = ids >= 0
    stored, image = number[ids[codes] >> 1], (ids[codes] & 1).astype(bool)
    region = np.where(image & (stored >= alone), stored + h - alone, stored)
    ids[codes] = np.where(stored < 0, UNKNOWN, region)
    return ids.astype(np.int32)
