"""Kernels without what numba adds for callers that they do not have: it takes half the time to compile."""

from collections.abc import Callable
from typing import Any, TypeVar

from otolith.core.jit import kernel

F = TypeVar("F", bound=Callable[..., Any])


def _compiled(function: F, **options: bool) -> F:
    compiled: Any = kernel(function)
    if hasattr(compiled, "targetoptions"):  # absent when numba is disabled
        compiled.targetoptions.update(options)
    result: F = compiled
    return result


def kernel_entry(function: F) -> F:
    """Like `kernel`, for a function that is called from Python, never from C."""
    return _compiled(function, no_cfunc_wrapper=True)


def inner_maker(function: F) -> F:
    """Like `kernel`, for a function that makes arrays and is called from kernels only."""
    return _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def inner(function: F) -> F:
    """Like `inner_maker`, for a function that neither makes nor returns an array.

    Without reference counts on the arrays it is handed it runs in half the time.
    """
    return _compiled(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False)
