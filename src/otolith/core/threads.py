"""One thread of linear algebra: for small matrices more of them only wait for each other, and change the
last digits.
"""

import functools
import sys
from contextlib import AbstractContextManager
from typing import Any

from threadpoolctl import ThreadpoolController


def one_thread() -> AbstractContextManager[Any]:
    """Return a context in which the libraries of linear algebra use one thread each.

    Libraries come with modules, so they are searched again only after another module has been imported. A
    search takes a millisecond, a fortieth of a closed loop of 20 s.
    """
    limited: AbstractContextManager[Any] = _libraries(len(sys.modules)).limit(limits=1)
    return limited


@functools.lru_cache(maxsize=1)
def _libraries(modules: int) -> ThreadpoolController:  # noqa: ARG001 (the number is the key)
    """Return what sets the threads of the libraries that are loaded now."""
    return ThreadpoolController()
