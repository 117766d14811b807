"""Where the variables of a stage lie in registers: columns of matrices over (u_k, x_k), in groups of four.

Inputs and states that A and B connect are neighbours, so that a row of [B A] has all its non-zeros in one or
two groups, and the others are never touched: a platform's axis has one input and three states. A variable a
is input a, or state a − nu. Symmetric matrices keep, of a state's row, only the groups from its own on, and
of an input's row all groups, since inputs are eliminated first.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from otolith.core.arrays import Mat
from otolith.core.lanes import WIDTH


@dataclass(frozen=True, slots=True)
class Packing:
    """The columns of all variables, and the places of their entries in packed matrices."""

    nu: int
    column: tuple[int, ...]  # of every variable
    own: tuple[tuple[int, ...], ...]  # groups of the variables that each variable is connected with

    @property
    def variables(self) -> range:
        """All variables, inputs first."""
        return range(len(self.column))

    @property
    def states(self) -> range:
        """The variables that are states."""
        return range(self.nu, len(self.column))

    @property
    def parts(self) -> list[list[int]]:
        """The variables in parts that A and B do not connect."""
        parts = sorted(set(self.own))
        return [[a for a in self.variables if self.own[a] == part] for part in parts]

    @property
    def groups(self) -> range:
        """All groups."""
        return range(max(max(own) for own in self.own) + 1)

    @property
    def width(self) -> int:
        """Number of columns of all groups."""
        return WIDTH * len(self.groups)

    def group(self, a: int) -> int:
        """The group in which a variable lies."""
        return self.column[a] // WIDTH

    def lane(self, a: int) -> int:
        """The place of a variable in its group."""
        return self.column[a] % WIDTH

    def later(self, a: int) -> range:
        """The groups of row a of a symmetric matrix that are kept."""
        return self.groups if a < self.nu else self.groups[self.group(a) :]

    def dynamics_row(self, a: int, group: int) -> int:
        """Place of a group of the row of [B A] that leads to the state that is variable a."""
        before = sum(len(self.own[b]) for b in self.states if b < a)
        return WIDTH * (before + self.own[a].index(group))

    def dynamics(self, a: int, b: int) -> int:
        """Place of the entry in column b of that row."""
        return self.dynamics_row(a, self.group(b)) + self.lane(b)

    @property
    def dynamics_size(self) -> int:
        """Count the numbers of a packed [B A]."""
        return WIDTH * sum(len(self.own[a]) for a in self.states)

    def symmetric_row(self, a: int, group: int, first: int = 0) -> int:
        """Place of a group of row a in a symmetric matrix over the variables from `first` on."""
        before = sum(len(self.later(b)) for b in range(first, a))
        return WIDTH * (before + group - self.later(a)[0])

    def symmetric(self, a: int, b: int, first: int = 0) -> int:
        """Place of entry (a, b) in a symmetric matrix over the variables from `first` on."""
        a, b = sorted((a, b), key=lambda one: (one >= self.nu, self.column[one]))
        return self.symmetric_row(a, self.group(b), first) + self.lane(b)

    def symmetric_size(self, first: int = 0) -> int:
        """Count the numbers of a symmetric matrix over the variables from `first` on."""
        return WIDTH * sum(len(self.later(a)) for a in self.variables[first:])

    def packed(self, A: Mat, B: Mat) -> Mat:
        """Pack A (…, nx, nx) and B (…, nx, nu) to (…, numbers)."""
        BA = np.concatenate([B, A], axis=-1)
        numbers = np.zeros((*BA.shape[:-2], self.dynamics_size))
        for a in self.states:
            for b in self.variables:
                if self.group(b) in self.own[a]:
                    numbers[..., self.dynamics(a, b)] = BA[..., a - self.nu, b]
        return numbers


@lru_cache
def packing_of(nu: int, nx: int, entries: frozenset[tuple[int, int]]) -> Packing:
    """Pack nu inputs and nx states; `entries` are the non-zeros (state, variable) of [B A]."""
    column, end = [0] * (nu + nx), 0
    own: list[tuple[int, ...]] = [()] * (nu + nx)
    for part in connected(nu + nx, ((nu + i, a) for i, a in entries)):
        first, length = end // WIDTH, -(-len(part) // WIDTH)
        for place, a in enumerate(part):
            column[a], own[a] = end + place, tuple(range(first, first + length))
        end += length * WIDTH
    return Packing(nu, tuple(column), tuple(own))


def connected(count: int, links: Iterable[tuple[int, int]]) -> list[list[int]]:
    """Split the numbers below `count` into parts without a link between them, in the order of their first."""
    part_of = list(range(count))
    for a, b in links:
        old, new = part_of[a], part_of[b]
        part_of = [new if part == old else part for part in part_of]
    parts = {part: [a for a in range(count) if part_of[a] == part] for part in part_of}
    return sorted(parts.values())
