"""Copies inside kernels, number by number.

For `out[:] = values` numba also compiles the text of an error message, strings and all, in every process that
compiles: two seconds (`findings/numba-slice-copy.sh`).
"""

from typing import Any

from numpy.typing import NDArray

from otolith.core.jit import jit_inner


@jit_inner
def copy_to(out: NDArray[Any], values: NDArray[Any] | tuple[float, ...]) -> None:
    """Write the first len(out) of `values` to `out`."""
    for i in range(len(out)):
        out[i] = values[i]
