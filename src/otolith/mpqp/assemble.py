"""Turn the result of an enumeration into the arrays of a law: sort the regions and link the neighbours.

The notation is that of `lookup` (ids, mirror images) and `sets` (codes).
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Bools, Mat, Vec
from otolith.mpqp.bench import Block
from otolith.mpqp.expand import UNKNOWN, Ints16, Ints32, Rows32, write_rows
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.region import kernel_form, work_memory
from otolith.mpqp.sets import SetTable, Words

_AT_ONCE: Final = 4096  # sets whose bits are compared at once, one byte each


class Regions(NamedTuple):
    """The arrays of a law that say which regions there are and what lies beyond their facets; see `Law`."""

    keys: Words
    centre: Mat
    radius: Vec
    start: Ints32
    constraint: Ints16
    beyond: Ints32
    alone: int


def assemble(form: LeastDistance, table: SetTable, blocks: Sequence[Block]) -> Regions:
    """Sort the regions by their active sets; those that are their own mirror images come first."""
    owner = np.concatenate([block.owner for block in blocks])
    keys = table.keys[owner]
    own = _own_images(keys, form)
    order = np.lexsort((*keys.T, ~own))
    number = np.full(int(table.used[0]), -1, dtype=np.int32)
    number[owner[order]] = np.arange(len(owner))
    lengths = np.concatenate([block.facets for block in blocks])
    pick = _slices((np.cumsum(lengths, dtype=np.int32) - lengths)[order], lengths[order])
    beyond = np.concatenate([block.beyond for block in blocks])[pick]
    return Regions(
        keys=keys[order],
        centre=np.concatenate([block.centre for block in blocks])[order],
        radius=np.concatenate([block.radius for block in blocks])[order],
        start=np.append(0, np.cumsum(lengths[order])).astype(np.int32),
        constraint=np.concatenate([block.constraint for block in blocks])[pick],
        beyond=_linked(beyond, number, len(owner), int(own.sum())),
        alone=int(own.sum()),
    )


def half_spaces(form: LeastDistance, regions: Regions) -> Rows32:
    """Compute the half-spaces (facets, p + 1) of all facets."""
    kernel = kernel_form(form)
    rows = np.empty((len(regions.beyond), len(form.half) + 1), dtype=np.float32)
    write_rows(kernel, work_memory(kernel), regions.keys, regions.start, regions.constraint, rows)
    return rows


def _own_images(keys: Words, form: LeastDistance) -> Bools:
    """Mark the active sets that are their own mirror images; all of them if there is no symmetry."""
    own = np.ones(len(keys), dtype=np.bool_)
    if len(form.mirror):
        for first in range(0, len(keys), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            octets = keys[some].astype("<u8").view(np.uint8)
            bits = np.unpackbits(octets, axis=1, bitorder="little", count=len(form.rows))
            own[some] = (bits == bits[:, form.mirror]).all(axis=1)
    return own


def _slices(start: Ints32, lengths: Ints32) -> Ints32:
    """Concatenate the indices start[i], ..., start[i] + lengths[i] - 1 for all i."""
    indices = np.arange(lengths.sum(), dtype=np.int32)
    indices += np.repeat(start - (np.cumsum(lengths, dtype=np.int32) - lengths), lengths)
    return indices


def _linked(beyond: Ints32, number: Ints32, h: int, alone: int) -> Ints32:
    """Convert codes of active sets to region ids; a set that is no region becomes UNKNOWN."""
    stored, image = number[np.maximum(beyond, 0) >> 1], (beyond & 1).astype(np.bool_)
    region = np.where(image & (stored >= alone), stored + np.int32(h - alone), stored)
    region[stored < 0] = UNKNOWN
    return np.where(beyond >= 0, region, beyond)
