"""How the pure arithmetic of the structured engine is compiled."""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

from otolith.core.jit import compiled

F = TypeVar("F", bound=Callable[..., Any])

_FREEDOMS = {"contract", "nsz", "reassoc", "arcp"}  # of fast-math, those that keep NaN and infinity


def pure(function: F) -> F:
    """Compile a kernel that may fuse and reorder its arithmetic; no data are judged in it."""
    return compiled(function, fastmath=_FREEDOMS)


def woven(function: F) -> F:
    """Compile a function as part of its callers only.

    Every compiled function carries the machine code of those it calls, compiled again; weaving the
    ones that only steer into the one call at the top makes that a fraction.
    """
    compile_: Any = numba.njit(inline="always", error_model="numpy")
    woven_in: F = compile_(function)
    return woven_in
