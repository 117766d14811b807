"""A law in the form that the kernels read, behind one array.

A call from Python is dear: an array costs 0.04 µs, a tuple of five 0.7 µs, more than the lookup itself. So
the kernels get a single array of integers, which holds the addresses and sizes of all others, and `opened`
makes arrays of them again, where this costs nothing. `Packed` keeps the arrays alive.

The kernels of one law share its working memory. They hold Python's lock, so no two of them run at once.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_allocating
from otolith.core.methods import array_at, pointer
from otolith.mpqp.expand import Ints32, Rows32
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.region import Form, kernel_form
from otolith.mpqp.sets import SetTable


class Tables(NamedTuple):
    """A law in the form that the kernels read."""

    form: Form
    sets: SetTable
    rows: Rows32  # (facets, p + 1) float32
    start: Ints32  # (h + 1,) int32
    beyond: Ints32  # (facets,) int32 region ids, negative where there is no region
    alone: int
    V: Mat  # (m, n)
    Z: Mat  # (n, p + 1)
    centre: Vec  # (p,) of the parameter box
    half: Vec  # (p,)
    names: Ints  # (m,) number by which an answer refers to each row of `form`
    weights: Vec  # (m,) factor from λ to an answer's multiplier of that row
    T: NDArray[np.float64]  # (places, n, p + 1) λ_A = -T τ; place of stored region s: s modulo places
    owner: Ints  # (places,) the region whose T it is; ~s if its rows are dependent, so that it has none


CACHE: Final = 1 << 22  # [bytes] in which a law keeps T of the regions that it has looked at
_NOBODY: Final = np.iinfo(np.int64).min
_ARRAYS: Final = 28  # arrays behind a block; their addresses come first, then the sizes


class Packed:
    """`Tables` and `Scratch` behind one array of integers, `block`: addresses, then sizes.

    The sizes are m, n, p, columns of `fixed`, h, facets, `alone`, slots, words, length of `mirror`, places.
    Every array has an address of its own: LLVM does not vectorise loops over parts of the same memory.
    """

    def __init__(self, arrays: tuple[NDArray[Any], ...], sizes: tuple[int, ...]) -> None:
        self._arrays, self._sizes = tuple(np.ascontiguousarray(array) for array in arrays), sizes
        m, n, p, _, h, _, _, _, words, _ = sizes
        w, places = n + 2, _places(h, n * (p + 1))
        numbers = [(places, n, p + 1), (p,), (p,), (m,), (m,), (w,), (w,), (w, w)]
        self._memory: tuple[NDArray[Any], ...] = (
            *(np.empty(shape) for shape in numbers), np.full(places, _NOBODY),
            np.empty(m + 1, dtype=np.int64), np.empty((2, words), dtype=np.uint64),
        )  # fmt: skip
        addresses = [array.ctypes.data for array in (*self._arrays, *self._memory)]
        self.block: Ints = np.array([*addresses, *sizes, places], dtype=np.int64)

    @property
    def slots(self) -> Ints32:
        """Index of the active sets."""
        return self._arrays[13]

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle the arrays, not their addresses."""
        return Packed, (self._arrays, self._sizes)


def _places(regions: int, numbers: int) -> int:
    """How many T of so many numbers are kept: all of them, or a power of two that fits into CACHE."""
    most = max(1, CACHE // (8 * numbers))
    return max(1, min(regions, 1 << (most.bit_length() - 1)))


class Numbering(NamedTuple):
    """How answers name the rows of the least-distance problem, and the parameter box they refer to."""

    centre: Vec  # (p,)
    half: Vec  # (p,)
    names: Ints  # (m,)
    weights: Vec  # (m,)


def plain(form: LeastDistance, centre: Vec, half: Vec) -> Numbering:
    """Make a numbering in which rows keep their own numbers and multipliers."""
    m = len(form.rows)
    return Numbering(centre, half, np.arange(m), np.ones(m))


def pack(
    form: LeastDistance,
    sets: SetTable,
    start: Ints32,
    rows: Rows32,
    beyond: Ints32,
    alone: int,
    by: Numbering,
) -> Packed:
    """Pack the tables of regions with these active sets, facets and neighbours."""
    m, n, p = form.sizes
    kernel = kernel_form(form)
    arrays = (
        kernel.Q, kernel.d, kernel.fixed, kernel.delta, form.V, form.Z, by.centre, by.half, by.weights,
        np.array([kernel.grain]), rows, start, beyond, sets.slots, sets.keys, sets.mirror, by.names,
    )  # fmt: skip
    sizes = (
        m, n, p, kernel.fixed.shape[1], len(start) - 1, len(beyond), alone, len(sets.slots),
        sets.keys.shape[1], len(sets.mirror),
    )  # fmt: skip
    return Packed(arrays, sizes)


@jit_allocating
def opened(block: Ints) -> Tables:
    """Return the tables behind a block, without copying."""
    sizes = block[_ARRAYS:]
    m, n, p, f, h, facets, alone = sizes[0], sizes[1], sizes[2], sizes[3], sizes[4], sizes[5], sizes[6]
    slots, words, images, places, q = sizes[7], sizes[8], sizes[9], sizes[10], p + 1
    form = Form(
        array_at(pointer(block, 0), (m, m), np.float64), array_at(pointer(block, 1), (q, m), np.float64),
        array_at(pointer(block, 2), (q, f), np.float64), n, array_at(pointer(block, 3), m, np.float64),
        array_at(pointer(block, 9), 1, np.float64)[0],
    )  # fmt: skip
    sets = SetTable(
        array_at(pointer(block, 14), (h, words), np.uint64), array_at(pointer(block, 13), slots, np.int32),
        sizes[:1], array_at(pointer(block, 15), images, np.int64),
        array_at(pointer(block, 27), (2, words), np.uint64),
    )  # fmt: skip
    return Tables(
        form, sets, array_at(pointer(block, 10), (facets, q), np.float32),
        array_at(pointer(block, 11), h + 1, np.int32), array_at(pointer(block, 12), facets, np.int32), alone,
        array_at(pointer(block, 4), (m, n), np.float64), array_at(pointer(block, 5), (n, q), np.float64),
        array_at(pointer(block, 6), p, np.float64), array_at(pointer(block, 7), p, np.float64),
        array_at(pointer(block, 16), m, np.int64), array_at(pointer(block, 8), m, np.float64),
        array_at(pointer(block, 17), (places, n, q), np.float64),
        array_at(pointer(block, 25), places, np.int64),
    )  # fmt: skip
