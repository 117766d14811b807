"""A thread's memory for the enumeration: it examines some active sets and hands over what it has found.

The notation is that of `expand` and `sets`. Codes refer to the thread's own table of sets until
`expand.merge` converts them.
"""

from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.mpqp.expand import Found, Ints16, Ints32, expand_many, found_memory
from otolith.mpqp.leastdistance import LeastDistance
from otolith.mpqp.region import Form, Work, work_memory
from otolith.mpqp.sets import SetTable, Words, grown, set_table

CHUNK: Final = 256  # sets that a thread examines before it hands over what it has found
_FACETS: Final = 1 << 13  # facets for which a thread has memory at first


class Block(NamedTuple):
    """Some regions, in the order in which their sets were found."""

    owner: Ints32  # (regions,) index of the active set
    centre: Mat  # (regions, p)
    radius: Vec  # (regions,)
    facets: Ints32  # (regions,) number of facets
    constraint: Ints16  # (facets,)
    beyond: Ints32  # (facets,) code of the set beyond, NOWHERE or UNKNOWN


class Batch(NamedTuple):
    """What a thread has found about some sets."""

    examined: int
    block: Block
    sets: Words  # (N, words) the sets beyond the facets, in the order of their codes


class Bench:
    """Working memory of one thread."""

    def __init__(self, form: LeastDistance, kernel: Form) -> None:
        m, _, p = form.sizes
        self._kernel: Form = kernel
        self.work: Work = work_memory(kernel)
        self._table: SetTable = set_table(m, np.array(form.mirror))
        self._found: Found = found_memory(p, CHUNK + 2, _FACETS)

    def examine(self, keys: Words, tolerance: float) -> Batch:
        """Examine at most CHUNK sets (N, words)."""
        self._table.slots.fill(-1)
        self._table.used[0] = 0
        self._found.used.fill(0)
        while self._found.used[2] < len(keys):
            self._make_room()
            expand_many(self._kernel, self.work, keys, self._table, self._found, tolerance)
        return Batch(len(keys), self._block(), self._table.keys[: self._table.used[0]].copy())

    def _make_room(self) -> None:
        """Provide memory for at least one more region with all its facets and the sets beyond them."""
        rows, facets = len(self.work.ids), int(self._found.used[1])
        self._table = grown(self._table, int(self._table.used[0]) + rows * (self._kernel.n + 2))
        if facets + rows > len(self._found.beyond):
            larger = 2 * len(self._found.beyond) + rows
            self._found = self._found._replace(
                constraint=np.resize(self._found.constraint, larger),
                beyond=np.resize(self._found.beyond, larger),
            )

    def _block(self) -> Block:
        """Copy what has been found."""
        regions, facets, found = int(self._found.used[0]), int(self._found.used[1]), self._found
        return Block(
            found.owner[:regions].copy(), found.centre[:regions].copy(), found.radius[:regions].copy(),
            np.diff(found.start[: regions + 1]), found.constraint[:facets].copy(),
            found.beyond[:facets].copy(),
        )  # fmt: skip
