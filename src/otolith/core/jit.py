"""One decorator for everything that numba compiles."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile `function` on first use and cache the machine code beside the source.

    Strict IEEE arithmetic: fast-math would let a NaN pass for a number (a residual test
    would then accept it), so it is never switched on where data are judged.
    """
    return cast(F, numba.njit(cache=True, error_model="numpy")(function))
