"""Compiled functions call their own copies of the functions that they need.

Numba puts copies of all that a function calls into its machine code, and lets the loader choose: of copies
of one function in several libraries, all callers get the one that was loaded first. Where sums may be fused
or reordered, the copies differ in the last digits, for each was optimised among its own neighbours. A result
would then depend on what else a process has compiled or loaded before. Here every library keeps its copies to
itself, so that the same call gives the same bits in each process.

Other people's functions are left alone. The parts of numba used here are private; `keep_copies_apart`
returns whether it found them.
"""

from typing import Any, Final

from llvmlite.binding import Linkage
from numba.core import codegen

_PREFIXES: Final[set[str]] = set()  # of the symbols of our functions


def own(module: str) -> None:
    """Let functions of this module's package, given by its full name, be among ours."""
    package = module.partition(".")[0]
    _PREFIXES.add(f"_ZN{len(package)}{package}")  # as symbols are mangled


def keep_copies_apart() -> bool:
    """Change how numba finishes libraries; return whether this numba has the parts that are needed."""
    library: Any = getattr(codegen, "CPUCodeLibrary", None)
    finish = getattr(library, "_finalize_final_module", None)
    if finish is None or not hasattr(library, "_get_module_for_linking"):
        return False

    def finish_with_own_copies(self: Any) -> None:
        if self._shared_module is None:  # of code that comes from a cache only its object is used
            _hide_copies(self)
        finish(self)

    library._finalize_final_module = finish_with_own_copies
    return True


def _hide_copies(library: Any) -> None:
    """Hide the copies of our functions in a library from all others, before it is made machine code."""
    module = library._final_module
    copies = [
        function
        for function in module.functions
        if not function.is_declaration
        and function.linkage == Linkage.linkonce_odr
        and function.name.startswith(tuple(_PREFIXES))
    ]
    if not copies:
        return
    # What is linked into callers stays as numba makes it: there, equal copies are merged before optimising.
    shared = module.clone()
    for function in shared.functions:
        if not function.is_declaration and function.linkage == Linkage.external:
            function.linkage = "linkonce_odr"
    library._shared_module = shared
    for function in copies:
        function.linkage = "internal"
