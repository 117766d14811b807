"""Machine code shipped with the package, so that a first start need not compile.

A wheel for one platform holds an archive of compiled kernels, which `tools/ship_kernels.py` makes; a checkout
has none until that tool is run. Machine code fits exactly one Python, one numba with its LLVM, and one kind
of processor. The archive states Python and numba in its file `made-for.json`, and holds the code twice, in a
folder for processors with AVX2 and in one for all others. Within a folder, the name of a file is a hash of
the function, the types of its arguments, and the fingerprint of all source compiled into it. So code of an
older source is never found, and what is not found is compiled as if there were no archive.
"""

import functools
import hashlib
import json
import platform
import sysconfig
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import llvmlite
import numba
import numpy as np
from llvmlite import binding

ARCHIVE: Final = Path(__file__).parents[1] / "kernels.zip"
MADE_FOR: Final = "made-for.json"
AVX2, ANY = "x86-64-v3", "x86-64"  # LLVM's names of the processors for which the code is compiled
_OF_AVX2: Final = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")  # x86-64-v3 beyond x86-64-v2

# The tool that makes an archive sets `on_compiled` to receive what is compiled, by name, and reads in `taken`
# the names of what was loaded from the archive.
on_compiled: Callable[[str, bytes], None] | None = None
taken: Final[list[str]] = []


def environment() -> dict[str, str]:
    """Return what machine code depends on besides the source and the kind of processor."""
    return {
        "extension suffix": str(sysconfig.get_config_var("EXT_SUFFIX")),  # Python's minor, system, C library
        "processor": platform.machine(),
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "numpy": np.__version__,
    }


@functools.cache
def kind() -> str:
    """Return the kind of this machine's processor: AVX2 or ANY."""
    has = binding.get_host_cpu_features()
    return AVX2 if all(has.get(feature, False) for feature in _OF_AVX2) else ANY


def name_of(function: Callable[..., Any], types: object, stamp: str) -> str:
    """Return the name of a function's code for these argument types and this fingerprint of its source."""
    text = f"{function.__module__}.{function.__qualname__}\n{types}\n{stamp}"
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def code(name: str) -> bytes | None:
    """Return code from the archive; None without a fitting archive, or if it has none of this name."""
    archive = _archive(ARCHIVE)
    try:
        found = archive.read(f"{kind()}/{name}") if archive else None
    except KeyError:
        return None
    if found is not None:
        taken.append(name)
    return found


@functools.cache
def _archive(path: Path) -> zipfile.ZipFile | None:
    """Return the archive if it is made for this environment; warn once if it is made for another."""
    if not path.is_file():
        return None
    archive = zipfile.ZipFile(path)
    made_for, here = json.loads(archive.read(MADE_FOR)), environment()
    others = [
        f"{what} {made_for.get(what)}, not {is_}" for what, is_ in here.items() if made_for.get(what) != is_
    ]
    if others:
        warnings.warn(
            f"kernels are compiled on first use: the machine code that came along is for {'; '.join(others)}",
            stacklevel=2,
        )
        return None
    return archive
