"""Packed matrices: every entry has one place, and the other places are zeros."""

import numpy as np
import pytest

from otolith.core.arrays import Mat
from otolith.qp.structured.packing import Packing, connected, packing_of

NU, NX = 2, 7


def dynamics(rng: np.random.Generator, links: float) -> tuple[Mat, Mat]:
    A, B = rng.standard_normal((NX, NX)), rng.standard_normal((NX, NU))
    A[rng.uniform(size=A.shape) > links], B[rng.uniform(size=B.shape) > links] = 0.0, 0.0
    return A, B


def packed_as(A: Mat, B: Mat) -> Packing:
    return packing_of(
        NU, NX, frozenset(zip(*(i.tolist() for i in np.nonzero(np.hstack([B, A]))), strict=True))
    )


@pytest.mark.parametrize("links", [0.0, 0.08, 0.2, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_no_entry_is_lost_and_none_is_stored_twice(links: float, seed: int) -> None:
    A, B = dynamics(np.random.default_rng(seed), links)
    packing = packed_as(A, B)
    assert len(set(packing.column)) == NU + NX
    numbers, BA = packing.packed(A, B), np.hstack([B, A])
    assert np.sort(numbers[numbers != 0.0]).tolist() == np.sort(BA[BA != 0.0]).tolist()
    for i, a in np.argwhere(BA).tolist():
        assert numbers[packing.dynamics(NU + i, a)] == BA[i, a]


@pytest.mark.parametrize("links", [0.08, 0.2, 1.0])
@pytest.mark.parametrize("first", [0, NU])
def test_a_symmetric_matrix_has_one_place_for_both_of_its_entries(links: float, first: int) -> None:
    packing = packed_as(*dynamics(np.random.default_rng(5), links))
    each = range(first, NU + NX)
    places = {frozenset((a, b)): packing.symmetric(a, b, first) for a in each for b in each}
    assert len(set(places.values())) == len(places)
    assert all(packing.symmetric(b, a, first) == packing.symmetric(a, b, first) for a in each for b in each)
    assert max(places.values()) < packing.symmetric_size(first)


def test_axes_that_nothing_connects_lie_in_registers_of_their_own() -> None:
    axes = [(1, 0), (2, 1), (0, 3), (1, 4), (4, 2), (3, 5), (5, 6), (4, 7)]  # (state, variable)
    packing = packing_of(2, 6, frozenset((i, a) for i, a in axes))
    parts = connected(8, ((2 + i, a) for i, a in axes))
    for part in parts:
        assert {packing.own[a] for a in part} == {packing.own[part[0]]}
    assert sorted(a for part in parts for a in part) == list(range(8))
