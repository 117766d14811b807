"""The working sets that training visited, found again by the nearest parameter.

Notation: ϑ = (x, r) states and wanted forces, each divided by its standard deviation in training. If the
problem is symmetric, a question is mirrored so that the first wanted force is not negative, and the set is
mirrored back.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import Ints, Mat, Vec, frozen_array
from otolith.core.jit import kernel


@dataclass(frozen=True, slots=True)
class Table:
    """Entries of a parameter and the set that was optimal there."""

    deviation: Vec  # (7P,)
    parameters: Mat  # (n, 7P), scaled
    which: Ints  # (n,) index into `sets`
    sets: NDArray[np.int8]  # (distinct, M, rows)
    symmetric: bool

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return plain arrays."""
        return {f"table.{name}": np.asarray(getattr(self, name)) for name in self.__slots__}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> "Table":
        """Restore from plain arrays.

        Raises
        ------
        ValueError : the arrays do not belong together.
        KeyError : an array is missing.
        """
        parameters, which = frozen_array(arrays["table.parameters"]), arrays["table.which"]
        sets = frozen_array(arrays["table.sets"], dtype=np.int8)
        if len(parameters) != len(which) or not ((which >= 0) & (which < len(sets))).all() or sets.ndim != 3:
            raise ValueError("the table's entries refer to what does not exist")
        deviation = frozen_array(arrays["table.deviation"])
        if parameters.ndim != 2 or deviation.shape != parameters.shape[1:] or not (deviation > 0.0).all():
            raise ValueError("the table's parameters and their deviations do not belong together")
        return cls(
            deviation,
            parameters,
            frozen_array(which, dtype=np.int64),
            sets,
            bool(arrays["table.symmetric"]),
        )


class Tabled:
    """Looks up the distinct sets among the entries nearest to the question."""

    def __init__(self, table: Table, *, nearest: int = 3) -> None:
        self._table, self._nearest = table, min(nearest, len(table.parameters))
        self._distance = np.empty(len(table.parameters))

    def reset(self) -> None:
        """Do nothing: there is no memory."""

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints | None:
        """Return hints (K, M, rows), nearest first."""
        del plan
        table = self._table
        sign = -1.0 if table.symmetric and wanted[0] < 0.0 else 1.0
        distances(sign * np.concatenate([x, wanted]) / table.deviation, table.parameters, self._distance)
        near = np.argpartition(self._distance, self._nearest - 1)[: self._nearest]
        which = table.which[near[np.argsort(self._distance[near])]]
        _, first = np.unique(which, return_index=True)
        found: Ints = np.int64(sign) * table.sets[which[np.sort(first)]].astype(np.int64)
        return found


@kernel
def distances(parameter: Vec, parameters: Mat, squared: Vec) -> None:
    """Write the squared distances (n,) of one parameter (p,) from many (n, p)."""
    for i in range(parameters.shape[0]):
        total = 0.0
        for j in range(parameters.shape[1]):
            total += (parameters[i, j] - parameter[j]) ** 2
        squared[i] = total
