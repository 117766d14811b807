"""Array types, and functions that every layer needs of them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Vec = NDArray[np.float64]
Mat = NDArray[np.float64]
Cube = NDArray[np.float64]
Singles = NDArray[np.float32]  # 32 bits, for pictures
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


def firsts(structure: Bools) -> Ints:
    """Return where each row begins in a list of all true entries, row by row, and its length (rows + 1,)."""
    return np.cumsum([0, *structure.sum(axis=1)])


def frozen_array(values: object, *, dtype: Any = np.float64, order: Any = "C") -> NDArray[Any]:
    """Return a read-only copy of `values` as an array of the given type and memory order."""
    array = np.array(values, dtype=dtype, order=order)
    array.setflags(write=False)
    return array


def freeze(instance: Any, **shapes: tuple[int, ...]) -> None:
    """Replace the named array fields of a frozen dataclass by read-only float64 copies of the stated shape.

    Raises
    ------
    ValueError : a field has another shape. This is a programming error, never a user's.
    """
    # This replaces dataclasses.fields, which is too slow for the thousands of states made per second.
    names = type(instance).__dataclass_fields__
    for name, shape in shapes.items():
        if name not in names:
            raise ValueError(f"{type(instance).__name__} has no field {name}")
        array = frozen_array(getattr(instance, name))
        if array.shape != shape:
            raise ValueError(f"{type(instance).__name__}.{name} has shape {array.shape}, expected {shape}")
        object.__setattr__(instance, name, array)
