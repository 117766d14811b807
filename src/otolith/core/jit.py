"""Decorators for all functions that numba compiles, and a cache of machine code that is never stale.

Numba caches machine code next to the source, or in the user's cache if that folder is not writable, and
recompiles when the source file of the function itself changes. But compiled code also contains the functions
it calls and the constants it reads, possibly from other files. Here the cached code is stamped with a
fingerprint of all these files (`otolith.core.sources`). After an edit or a `git pull`, no process runs code
that differs from the source, whatever the order in which functions are called. What the cache does not hold
may have come with the package (`otolith.core.shipped`); the rest is compiled.
"""

import gc
import hashlib
import pickle
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, Final, TypeVar, cast

import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.compiler_lock import global_compiler_lock

from otolith.core import own_copies, shipped
from otolith.core.locks import sole
from otolith.core.sources import fingerprint

F = TypeVar("F", bound=Callable[..., Any])

_FREEDOMS: Final = {
    "contract",
    "nsz",
    "reassoc",
    "arcp",
}  # the fast-math flags that preserve NaN and infinity

# The exceptions that unpickling raises when cached code refers to a type that was moved or renamed.
_MOVED: Final = (ImportError, AttributeError)
_OBJECTS: Final = 50_000  # that are made between two looks for garbage while something is compiled
_NUMBA: Final = "numba" + numba.__version__.replace(".", "_")  # in the names of files of machine code
_unkept: set[str] = set()  # folders of which this process has said that nothing can be stored in them
_swept: set[tuple[str, str]] = set()  # (folder, module) whose stale code this process has already removed

if not own_copies.keep_copies_apart():
    warnings.warn(
        f"numba {numba.__version__} is not known: last digits of results may depend on what else is compiled",
        stacklevel=2,
    )


def kernel(function: F) -> F:
    """Compile `function` on first use and cache its machine code next to the source.

    The arithmetic is strict IEEE. Fast-math could treat a NaN as a number, so that a test of a residual would
    accept it; it is therefore never used where data are judged.
    """
    return compiled(function)


def compiled(function: F, **options: Any) -> F:
    """Compile as `kernel` does, with further options of `numba.njit`."""
    options = {"error_model": "numpy", **options}
    own_copies.own(function.__module__)
    dispatcher: Any = numba.njit(**options)(function)
    if hasattr(dispatcher, "py_func"):  # absent when numba is disabled
        cache = _cache_of(function)
        if cache is not None:
            dispatcher._cache = cache
            dispatcher.compile = cache.alone(dispatcher.compile)
    return cast(F, dispatcher)


def jit_fused(function: F) -> F:
    """Compile a kernel whose arithmetic may be fused and reordered. Do not use it where data are judged."""
    return compiled(function, fastmath=_FREEDOMS)


def jit_inlined(function: F) -> F:
    """Compile a function only as part of its callers.

    Every compiled function contains its own copy of the functions it calls, compiled again. Inlining those
    that only steer into the one call at the top reduces the compile time to a fraction.
    """
    compile_: Any = numba.njit(inline="always", error_model="numpy")
    inlined: F = compile_(function)
    return inlined


def jit_entry(function: F) -> F:
    """Compile like `kernel` a function that is called only from Python, never from C; this takes half the
    time.
    """
    return _lean(function, no_cfunc_wrapper=True)


def jit_unlocked(function: F) -> F:
    """Compile like `jit_entry` a function during which other threads run Python, or another such function.

    It must not write to what another thread uses.
    """
    return _lean(function, no_cfunc_wrapper=True, nogil=True)


def jit_allocating(function: F) -> F:
    """Compile like `kernel` a function that creates arrays and is called only from other kernels."""
    return _lean(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def jit_inner(function: F) -> F:
    """Compile like `jit_allocating` a function that neither creates nor returns an array.

    Without reference counting of its array arguments it runs in half the time.
    """
    return _lean(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False)


def jit_inner_fused(function: F) -> F:
    """Compile like `jit_inner` a function whose arithmetic may be fused and reordered, as in `jit_fused`."""
    return cast(F, _freed(jit_fused(function), no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False))


def _lean(function: F, **options: bool) -> F:
    """Compile a kernel without the wrappers that numba adds for callers that do not exist here."""
    return cast(F, _freed(kernel(function), **options))


def _freed(dispatcher: Any, **options: bool) -> Any:
    """Change the options of a compiled function."""
    if hasattr(dispatcher, "targetoptions"):  # absent when numba is disabled
        dispatcher.targetoptions.update(options)
    return dispatcher


def _cache_of(function: Callable[..., Any]) -> "SourceCache | None":
    """Return the cache of `function`'s machine code; None without a source file or a writable folder."""
    if not Path(function.__code__.co_filename).is_file():
        return None
    try:
        return SourceCache(function)
    except (
        RuntimeError,
        AttributeError,
    ) as error:  # numba finds no cache folder, or this version of numba lacks the parts used here
        warnings.warn(f"every start compiles anew: {error}; set NUMBA_CACHE_DIR", stacklevel=4)
        return None


@contextmanager
def _seldom_collecting() -> Iterator[None]:
    """Look for garbage seldom while the compiler makes millions of objects, nearly all of which stay.

    As often as Python does by default, it takes 7 % of the time, and more in a large process.
    """
    before = gc.get_threshold()
    if before[0] > 0:
        gc.set_threshold(max(before[0], _OBJECTS), *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


def _warn_unkept(folder: str, error: OSError) -> None:
    """Say that machine code cannot be kept in a folder; once, for a program calls many functions."""
    if folder not in _unkept:
        _unkept.add(folder)
        reason = f"machine code could not be kept in {folder}: {error.strerror or error}"
        warnings.warn(f"{reason}; every start compiles it anew; set NUMBA_CACHE_DIR", stacklevel=2)


class _Files(IndexDataCacheFile):
    """Files of one function's machine code: one for each signature and source, named by a hash of both.

    Numba's own index gives a number to every signature and is written before the code. Two processes that
    compile different signatures at the same time give both the same number, and code is then called with the
    arguments of another signature. Without an index, nothing can be mixed up.
    """

    def save(self, key: Any, data: Any) -> None:
        """Store the code for a key of numba's; the file appears whole."""
        self._save_data(self._name(key), data)  # type: ignore[no-untyped-call]

    def load(self, key: Any) -> Any:
        """Load the code for a key of numba's; None if there is none, or only a damaged file."""
        try:
            return self._load_data(self._name(key))  # type: ignore[no-untyped-call]
        except (FileNotFoundError, EOFError, pickle.UnpicklingError):
            return None

    def remove(self, key: Any) -> None:
        """Remove the code for a key of numba's."""
        Path(self._data_path(self._name(key))).unlink(missing_ok=True)  # type: ignore[no-untyped-call]

    def lock(self, key: Any) -> Path:
        """Return the file whose lock the process that compiles the code for a key of numba's holds."""
        return Path(self._data_path(self._name(key)) + ".lock")  # type: ignore[no-untyped-call]

    def remove_others(self, stem: str) -> None:
        """Remove what this numba has stored for a module's functions under other fingerprints, and locks."""
        for file in Path(self._cache_path).glob(f"{stem}.*.{_NUMBA}-*.nbc*"):
            if self._stamp not in file.name:
                file.unlink(missing_ok=True)

    @property
    def _stamp(self) -> str:
        return f"{_NUMBA}-{self._source_stamp[:16]}"

    def _name(self, key: Any) -> str:
        base = self._index_name.removesuffix(".nbi")
        return f"{base}.{self._stamp}.{hashlib.sha256(repr(key).encode()).hexdigest()[:32]}.nbc"


class SourceCache(FunctionCache):
    """Numba's cache for one function, stamped with the fingerprint of all source compiled into it."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._module = function.__module__
        self._file = function.__code__.co_filename
        self._files = _Files(self._cache_path, self._impl.filename_base, "")  # type: ignore[no-untyped-call]
        self._cache_file = self._files
        self._locks = ExitStack()  # held while this process compiles

    def alone(self, compile_: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """Return a dispatcher's method `compile` that does not compile what another process is compiling.

        Processes that wait for each other in a circle are impossible: each holds the locks of functions that
        call the one it waits for, and no function is called by those that it calls.
        """

        def compile_alone(signature: Any) -> Any:
            with global_compiler_lock, _seldom_collecting(), ExitStack() as locks:
                before, self._locks = self._locks, locks
                try:
                    return compile_(signature)
                finally:
                    self._locks = before

        return compile_alone

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load the machine code for a signature, from the cache or as shipped; None if there is none.

        In that case this process holds the lock of the signature, so that no other one compiles it, too.
        """
        self._stamp()
        found = self._stored(sig, target_context) or self._shipped(sig, target_context)
        if found is None:
            key = self._index_key(sig, target_context.codegen())  # type: ignore[no-untyped-call]
            self._locks.enter_context(sole(self._files.lock(key)))
            found = self._stored(sig, target_context)  # by a process that held the lock
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store the machine code for a signature, after removing code of this module under other stamps.

        Where it cannot be stored, as on a full disk, the compiled code is used all the same, and a warning
        says once that it is not kept.
        """
        self._stamp()
        self._sweep()
        try:
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
        except OSError as error:
            _warn_unkept(self.cache_path, error)
        if shipped.on_compiled is not None:
            from numba.core.serialize import dumps  # the pickling of numba's own cache

            code = dumps(self._impl.reduce(data))  # type: ignore[no-untyped-call]
            shipped.on_compiled(self._shipped_as(sig), code)

    def _stored(self, sig: Any, target_context: Any) -> Any:
        """Load the machine code for a signature from the cache, or None."""
        try:
            found = super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except _MOVED:
            self._files.remove(self._index_key(sig, target_context.codegen()))  # type: ignore[no-untyped-call]
            return None
        if found is not None and tuple(found.signature.args) != tuple(sig):
            return None  # types of equal names are not equal
        return found

    def _shipped(self, sig: Any, target_context: Any) -> Any:
        """Load the machine code for a signature from the package's archive, or None."""
        code = shipped.code(self._shipped_as(sig))
        if code is None:
            return None
        found = self._impl.rebuild(target_context, pickle.loads(code))  # noqa: S301 (of the package itself)
        return found if tuple(found.signature.args) == tuple(sig) else None

    def _shipped_as(self, sig: Any) -> str:
        return shipped.name_of(self._py_func, sig, self._cache_file._source_stamp)

    def _stamp(self) -> None:
        self._cache_file._source_stamp = fingerprint(self._file, self._module)

    def _sweep(self) -> None:
        """Remove code that no process can load any more, once per module; otherwise it piles up with
        every edit.
        """
        folder, stem = self.cache_path, Path(self._file).stem
        if (folder, stem) not in _swept:
            _swept.add((folder, stem))
            self._files.remove_others(stem)
