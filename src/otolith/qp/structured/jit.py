"""How the pure arithmetic of the structured engine is compiled."""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

F = TypeVar("F", bound=Callable[..., Any])

_FREEDOMS = {"contract", "nsz", "reassoc", "arcp"}  # of fast-math, those that keep NaN and infinity


def pure(function: F) -> F:
    """Compile a kernel that may fuse and reorder its arithmetic; no data are judged in it."""
    compile_: Any = numba.njit(cache=True, error_model="numpy", fastmath=_FREEDOMS)
    compiled: F = compile_(function)
    return compiled


def woven(function: F) -> F:
    """Compile a function as part of its callers only.

    Every compiled function carries the machine code of those it calls, compiled again; weaving the
    ones that only steer into the one call at the top makes that a fraction.
    """
    compile_: Any = numba.njit(inline="always", error_model="numpy")
    compiled: F = compile_(function)
    return compiled
