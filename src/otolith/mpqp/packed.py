"""A law in the form that the kernels read, also packed into five arrays.

The cost of a call from Python grows with the number of array arguments, about 0.3 µs each. So the tables are
passed in a few flat arrays, and `opened` splits them again in compiled code, where this costs nothing.
"""

from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_allocating
from otolith.mpqp.expand import Ints32, Rows32
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.region import Form, kernel_form
from otolith.mpqp.sets import SetTable, Words


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


class Packed(NamedTuple):
    """`Tables` packed into five arrays."""

    reals: Vec
    rows: Rows32  # (facets, p + 1)
    ints: Ints32
    keys: Words  # (h, words)
    longs: Ints  # m, n, p, columns of `fixed`, h, facets, alone; then names and mirror


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
    arrays = kernel_form(form)
    reals = (
        arrays.Q, arrays.d, arrays.fixed, arrays.delta, form.V, form.Z, by.centre, by.half, by.weights,
        arrays.grain,
    )  # fmt: skip
    sizes = (m, n, p, arrays.fixed.shape[1], len(start) - 1, len(beyond), alone)
    return Packed(
        np.concatenate([np.ravel(array) for array in reals]), rows,
        np.concatenate([start, beyond, sets.slots]), sets.keys,
        np.concatenate([np.array(sizes), by.names, sets.mirror]),
    )  # fmt: skip


@jit_allocating
def opened(packed: Packed, key: Words) -> Tables:
    """Return the tables contained in the five arrays, without copying; `key` (2, words) is working memory."""
    reals, ints, longs = packed.reals, packed.ints, packed.longs
    m, n, p, f, h, facets, alone = longs[0], longs[1], longs[2], longs[3], longs[4], longs[5], longs[6]
    q = p + 1
    d = m * m
    fixed = d + q * m
    delta = fixed + q * f
    V = delta + m
    Z = V + m * n
    centre = Z + n * q
    form = Form(
        reals[:d].reshape(m, m), reals[d:fixed].reshape(q, m), reals[fixed:delta].reshape(q, f), n,
        reals[delta:V], reals[-1],
    )  # fmt: skip
    slots, names = ints[h + 1 + facets :], longs[7 : 7 + m]
    sets = SetTable(packed.keys, slots, longs[:1], longs[7 + m :], key)
    return Tables(
        form, sets, packed.rows, ints[: h + 1], ints[h + 1 : h + 1 + facets], alone,
        reals[V:Z].reshape(m, n), reals[Z:centre].reshape(n, q), reals[centre : centre + p],
        reals[centre + p : centre + 2 * p], names, reals[centre + 2 * p : -1],
    )  # fmt: skip
