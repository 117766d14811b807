"""The table against a search by hand."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from otolith.cueing.hints.table import Table, Tabled


def random_table(*, symmetric: bool) -> Table:
    rng = np.random.default_rng(3)
    sets = rng.integers(-1, 2, (6, 4, 9)).astype(np.int8)
    return Table(rng.uniform(0.5, 2.0, 7), rng.normal(size=(30, 7)), rng.integers(0, 6, 30), sets, symmetric)


@pytest.mark.parametrize("symmetric", [True, False])
def test_the_nearest_entries_give_their_sets_in_order_and_each_once(symmetric: bool) -> None:
    table, rng = random_table(symmetric=symmetric), np.random.default_rng(5)
    at_work = Tabled(table, nearest=5)
    for _ in range(40):
        x, wanted = rng.normal(size=6), rng.normal(size=1)
        sign = -1 if symmetric and wanted[0] < 0.0 else 1
        asked = sign * np.append(x, wanted) / table.deviation
        near = sorted(range(30), key=lambda i: float(np.sum((table.parameters[i] - asked) ** 2)))[:5]
        expected = list(dict.fromkeys(int(table.which[i]) for i in near))
        found = at_work.sets(x, wanted, np.empty((0, 0)))
        assert found is not None
        assert_array_equal(found, sign * table.sets[expected].astype(np.int64))


def test_arrays_there_and_back_are_the_same_table_and_foreign_ones_are_refused() -> None:
    table = random_table(symmetric=True)
    again = Table.from_arrays(table.to_arrays())
    assert again.symmetric is True
    assert_array_equal(again.sets[again.which], table.sets[table.which])
    with pytest.raises(ValueError, match="does not exist"):
        Table.from_arrays({**table.to_arrays(), "table.which": table.which + 6})
