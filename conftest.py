"""Shared by all tests, those of the thesis too: one thread for BLAS, the same examples in each run of
properties, and `--fast`, the daily loop.
"""

import os
import platform
import subprocess
from typing import Any, NoReturn

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings
from numba.core.dispatcher import Dispatcher

# What failed once can be repeated anywhere. `pytest --hypothesis-profile=search` tries new examples.
settings.register_profile("search", deadline=None)  # no test asserts a time
settings.register_profile("repeatable", deadline=None, derandomize=True, database=None)
settings.load_profile("repeatable")


def pytest_addoption(parser: pytest.Parser) -> None:
    """`pytest --fast`, the daily loop: see `pytest_collection`."""
    parser.addoption(
        "--fast", action="store_true", help="skip every test at its first call of a compiled kernel"
    )


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """With --fast, a test is skipped at the moment it calls a kernel, or starts another process that might.

    So no list has to be kept of which tests those are, and no test that needs no kernel is left out.
    Processes of pytest-xdist are started before this.
    """
    if not session.config.getoption("--fast"):
        return

    def compiled(*_: Any, **__: Any) -> NoReturn:
        raise pytest.skip.Exception("calls compiled code (--fast)", allow_module_level=True)

    platform.processor()  # asks another program once, and some libraries ask it on import
    patch = pytest.MonkeyPatch()
    session.config.add_cleanup(patch.undo)
    patch.setattr(
        Dispatcher, "_compile_for_args", compiled
    )  # what a first call with arguments of a type calls
    patch.setattr(subprocess.Popen, "__init__", compiled)
