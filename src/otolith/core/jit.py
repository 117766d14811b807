"""Decorators for everything that numba compiles, and a cache of machine code that is never stale.

Numba keeps machine code beside the source, or in the user's cache where that cannot be written to, and
compiles anew when the source file of the function itself changes. But the code of a function holds that of
all functions it calls, and the constants it reads, also from other files. Here the code is stamped with
a fingerprint of all these files (`otolith.core.sources`), so that after an edit or a `git pull` no
process runs what the source no longer says, in whatever order functions are called.
"""

import pickle
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import numba
from numba.core.caching import FunctionCache

from otolith.core.sources import fingerprint

F = TypeVar("F", bound=Callable[..., Any])

_FREEDOMS: Final = {"contract", "nsz", "reassoc", "arcp"}  # of fast-math, those that keep NaN and infinity

# What unpickling raises where the code kept is for a type whose module or class was moved since.
_MOVED: Final = (ImportError, AttributeError)
_swept: set[tuple[str, str]] = set()  # folders and modules whose stale code this process has removed


def kernel(function: F) -> F:
    """Compile `function` on first use and cache the machine code beside the source.

    Strict IEEE arithmetic: fast-math would let a NaN pass for a number (a residual test
    would then accept it), so it is never switched on where data are judged.
    """
    return compiled(function)


def compiled(function: F, **options: Any) -> F:
    """As `kernel`, with further options of `numba.njit`."""
    options = {"error_model": "numpy", **options}
    dispatcher: Any = numba.njit(**options)(function)
    if hasattr(dispatcher, "py_func"):  # absent when numba is disabled
        dispatcher._cache = _cache_of(function) or dispatcher._cache
    return cast(F, dispatcher)


def jit_fused(function: F) -> F:
    """Compile a kernel that may fuse and reorder its arithmetic; no data are judged in it."""
    return compiled(function, fastmath=_FREEDOMS)


def jit_inlined(function: F) -> F:
    """Compile a function as part of its callers only.

    Every compiled function carries the machine code of those it calls, compiled again; inlining the
    ones that only steer into the one call at the top makes that a fraction.
    """
    compile_: Any = numba.njit(inline="always", error_model="numpy")
    inlined: F = compile_(function)
    return inlined


def jit_entry(function: F) -> F:
    """Like `kernel`, for a function that only Python calls, never C; it compiles in half the time."""
    return _lean(function, no_cfunc_wrapper=True)


def jit_allocating(function: F) -> F:
    """Like `kernel`, for a function that makes arrays and is called from kernels only."""
    return _lean(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def jit_inner(function: F) -> F:
    """Like `jit_allocating`, for a function that neither makes nor returns an array.

    Without reference counts on the arrays it is handed it runs in half the time.
    """
    return _lean(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False)


def _lean(function: F, **options: bool) -> F:
    """A kernel without what numba adds for callers that it does not have."""
    dispatcher: Any = kernel(function)
    if hasattr(dispatcher, "targetoptions"):  # absent when numba is disabled
        dispatcher.targetoptions.update(options)
    return cast(F, dispatcher)


def _cache_of(function: Callable[..., Any]) -> FunctionCache | None:
    """Where the machine code of `function` is kept; None without a source file or a folder to write to."""
    if not Path(function.__code__.co_filename).is_file():
        return None
    try:
        return SourceCache(function)
    except (
        RuntimeError,
        AttributeError,
    ) as error:  # numba's: no locator; another numba, without the parts used
        warnings.warn(f"every start compiles anew: {error}; set NUMBA_CACHE_DIR", stacklevel=4)
        return None


class SourceCache(FunctionCache):
    """Numba's cache of one function, its stamp the fingerprint of all source that is compiled into it."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        _ = self._cache_file._source_stamp  # AttributeError here rather than stale code later
        self._module = function.__module__
        self._file = function.__code__.co_filename

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code of a signature, or None; the stamp is made when it is first asked for."""
        self._stamp()
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except _MOVED:
            _remove(Path(self._cache_file._index_path))
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the machine code of a signature, after what the module kept under other stamps is removed."""
        self._stamp()
        self._sweep()
        super().save_overload(sig, data)  # type: ignore[no-untyped-call]

    def _stamp(self) -> None:
        self._cache_file._source_stamp = fingerprint(self._file, self._module)

    def _sweep(self) -> None:
        """Remove what no process can load any more, once per module: it would pile up with every edit."""
        folder, stem = self.cache_path, Path(self._file).stem
        if (folder, stem) in _swept:
            return
        _swept.add((folder, stem))
        for index in Path(folder).glob(f"{stem}.*.nbi"):
            if _stamp_of(index) not in (None, self._cache_file._source_stamp):
                _remove(index)


def _remove(index: Path) -> None:
    """Remove an index of numba's, and the machine code that it lists."""
    for stale in (*index.parent.glob(f"{index.stem}.*.nbc"), index):
        stale.unlink(missing_ok=True)


def _stamp_of(index: Path) -> Any:
    """The stamp in an index of numba's; None when another version of numba wrote it, or it is damaged.

    An index that names a type which was moved or renamed has the stamp "", which no source has.
    """
    try:
        with index.open("rb") as file:
            if pickle.load(file) != numba.__version__:  # noqa: S301 (numba loads the same file)
                return None
            return pickle.load(file)[0]  # noqa: S301
    except _MOVED:
        return ""
    except (OSError, EOFError, pickle.UnpicklingError):
        return None
