"""A growing table of active sets, each an exact bit mask, with central symmetry taken into account.

Notation: a key has W words of 64 bits, bit i set when row i is active; π is the mirror permutation. Of a set
and its mirror image only the smaller key is stored. A *code* is 2·index + 1 if the requested set is the
image, else 2·index.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Ints
from otolith.core.jit import jit_entry, jit_inner

Words = NDArray[np.uint64]
ONE = np.uint64(1)
LOW_BITS = np.uint64(63)
MIX = np.uint64(0x9E3779B97F4A7C15)
SHIFT = np.uint64(29)
DE_BRUIJN = np.uint64(
    0x03F79D71B4CB0A89
)  # its 64 windows of six bits differ, so each identifies a single bit
TOP = np.uint64(58)
PLACE = np.empty(64, dtype=np.int64)
PLACE[[((0x03F79D71B4CB0A89 << i) % 2**64) >> 58 for i in range(64)]] = np.arange(64)


class SetTable(NamedTuple):
    """Keys in the order found, and an open-addressing table of their indices."""

    keys: Words  # (capacity, W) uint64
    slots: NDArray[np.int32]  # (a power of two) int32 index into keys, -1 when free
    used: Ints  # (1,) number of keys
    mirror: Ints  # (m,) π, or (0,)
    key: Words  # (2, W) uint64 scratch


def set_table(m: int, mirror: Ints, capacity: int = 1 << 12) -> SetTable:
    """Make an empty table for subsets of m rows."""
    words = max(1, -(-m // 64))
    return SetTable(
        np.zeros((capacity, words), dtype=np.uint64),
        np.full(4 * capacity, -1, dtype=np.int32),
        np.zeros(1, dtype=np.int64),
        mirror,
        np.zeros((2, words), dtype=np.uint64),
    )


def grown(table: SetTable, capacity: int) -> SetTable:
    """Copy a table into one with room for at least `capacity` keys."""
    size = len(table.keys)
    if capacity <= size:
        return table
    while size < capacity:
        size *= 2
    keys = np.zeros((size, table.keys.shape[1]), dtype=np.uint64)
    keys[: table.used[0]] = table.keys[: table.used[0]]
    larger = table._replace(keys=keys, slots=np.full(4 * size, -1, dtype=np.int32))
    rehash(larger)
    return larger


def adopted(keys: Words, m: int, mirror: Ints) -> SetTable:
    """Make a table of exactly these keys, in their order; its index takes two to four slots of 4 bytes
    per key.
    """
    size = 1 << max(3, int(2 * len(keys)).bit_length())
    table = set_table(m, np.array(mirror), 1)._replace(
        keys=keys, slots=np.full(size, -1, dtype=np.int32), used=np.array([len(keys)])
    )
    rehash(table)
    return table


@jit_inner
def first_slot(keys: Words, row: int, mask: int) -> int:
    """Slot where the search for a key begins."""
    h = np.uint64(0)
    for w in range(keys.shape[1]):
        h = (h ^ keys[row, w]) * MIX
        h ^= h >> SHIFT
    return int(np.int64(h & np.uint64(mask)))


@jit_entry
def rehash(table: SetTable) -> None:
    """Enter every key into the empty slots."""
    mask = table.slots.shape[0] - 1
    for i in range(table.used[0]):
        s = first_slot(table.keys, i, mask)
        while table.slots[s] >= 0:
            s = (s + 1) & mask
        table.slots[s] = i


@jit_inner
def fold(table: SetTable, A: Ints, k: int) -> int:
    """Write the canonical key of rows A[:k] to key[0]; return 1 when that is the mirror image, else 0."""
    key = table.key
    W = key.shape[1]
    for w in range(W):
        key[0, w] = key[1, w] = np.uint64(0)
    for a in range(k):
        key[0, A[a] >> 6] |= ONE << (np.uint64(A[a]) & LOW_BITS)
    if table.mirror.shape[0] == 0:
        return 0
    for a in range(k):
        i = table.mirror[A[a]]
        key[1, i >> 6] |= ONE << (np.uint64(i) & LOW_BITS)
    for w in range(W):
        if key[1, w] != key[0, w]:
            if key[1, w] > key[0, w]:
                return 0
            for v in range(W):
                key[0, v] = key[1, v]
            return 1
    return 0


@jit_inner
def seek(table: SetTable) -> int:
    """Return the slot that contains key[0], or the free slot where it belongs."""
    mask = table.slots.shape[0] - 1
    s = first_slot(table.key, 0, mask)
    while table.slots[s] >= 0:
        i = table.slots[s]
        same = True
        for w in range(table.key.shape[1]):
            if table.keys[i, w] != table.key[0, w]:
                same = False
        if same:
            return s
        s = (s + 1) & mask
    return s


@jit_inner
def insert_key(table: SetTable) -> int:
    """Return the index of key[0], which is added if new; the caller must provide room for it."""
    s = seek(table)
    if table.slots[s] < 0:
        i = table.used[0]
        for w in range(table.key.shape[1]):
            table.keys[i, w] = table.key[0, w]
        table.slots[s] = i
        table.used[0] = i + 1
    return int(table.slots[s])


@jit_inner
def insert(table: SetTable, A: Ints, k: int) -> int:
    """Return the code of the rows A[:k], which are added if new; the caller must provide room for them."""
    image = fold(table, A, k)
    return 2 * insert_key(table) + image


@jit_entry
def enter(table: SetTable, A: Ints, k: int) -> int:
    """`insert` for callers in Python."""
    return insert(table, A, k)


@jit_entry
def unpack(keys: Words, row: int, A: Ints) -> int:
    """Write the rows of a key in ascending order to A; return how many there are."""
    k = 0
    for w in range(keys.shape[1]):
        word = keys[row, w]
        while word != np.uint64(0):
            without = word & (word - ONE)  # the lowest bit cleared
            A[k] = 64 * w + PLACE[((word ^ without) * DE_BRUIJN) >> TOP]
            k += 1
            word = without
    return k
