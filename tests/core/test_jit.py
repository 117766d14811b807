"""Machine code from the cache does what the source says now, whichever file was edited."""

import gc
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import otolith
from otolith.core.jit import SourceCache

CALLER = """
from otolith.core.jit import kernel
from small.callee import FACTOR, double

@kernel
def call(x):
    return FACTOR * double(x)
"""
CALLEE = """
from otolith.core.jit import kernel

FACTOR = 1.0

@kernel
def double(x):
    return 2.0 * x
"""
TAKER = """
from otolith.core.jit import kernel

@kernel
def pair_of(pair):
    return pair.x

@kernel
def half_of(pair):
    return 0.5 * pair.x
"""


def package(folder: Path) -> Path:
    """A package of two files, one of which calls into the other."""
    small = folder / "small"
    small.mkdir()
    (small / "__init__.py").touch()
    (small / "caller.py").write_text(CALLER)
    (small / "callee.py").write_text(CALLEE)
    return small


def python(code: str, small: Path, cache: Path | None = None) -> str:
    """What a program that knows the package prints in a process of its own."""
    source = Path(otolith.__file__).parents[1]
    # Python's own cache tells files apart by size and second: an edit within the same second would be missed
    never = {"PYTHONDONTWRITEBYTECODE": "1"}
    environment = {**os.environ, **never, "PYTHONPATH": os.pathsep.join([str(small.parent), str(source)])}
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def run(small: Path, *, first: str = "call", cache: Path | None = None) -> tuple[float, int]:
    """What the caller returns in a process of its own, and how often its code came from the cache."""
    code = (
        "from small.caller import call; from small.callee import double;"
        f"{first}(1.0); print(call(1.0), sum(call.stats.cache_hits.values()))"
    )
    value, hits = python(code, small, cache).split()
    return float(value), int(hits)


@pytest.mark.parametrize("elsewhere", [False, True])
def test_an_edit_of_a_callee_or_of_its_constants_reaches_the_caller(tmp_path: Path, elsewhere: bool) -> None:
    small = package(tmp_path)
    cache = tmp_path / "cache" if elsewhere else None  # as where the source cannot be written beside
    assert run(small, cache=cache) == (2.0, 0)
    assert run(small, cache=cache) == (2.0, 1)
    callee = small / "callee.py"
    callee.write_text(CALLEE.replace("2.0 * x", "3.0 * x"))
    assert run(small, first="double", cache=cache) == (3.0, 0)  # the callee's own cache is fresh by then
    callee.write_text(CALLEE.replace("FACTOR = 1.0", "FACTOR = 5.0"))
    assert run(small, cache=cache) == (10.0, 0)
    assert run(small, cache=cache) == (10.0, 1)


def test_code_of_functions_that_moved_is_removed(tmp_path: Path) -> None:
    """Numba names files by the function's line: without sweeping every edit above it would leave two."""
    small = package(tmp_path)
    for lines in range(3):
        (small / "caller.py").write_text("\n" * lines + CALLER)
        assert run(small) == (2.0, 0)
    kept = sorted(path.suffix for path in (small / "__pycache__").glob("caller.*.nb?"))
    assert kept == [".nbc"]


@pytest.mark.parametrize("called", ["pair_of", "half_of"])
def test_code_for_a_type_whose_module_was_moved_is_made_anew(tmp_path: Path, called: str) -> None:
    """As after a `git pull`: what is kept names a module that is gone; what was compiled has not changed."""
    small = package(tmp_path)
    (small / "caller.py").write_text(TAKER)
    (small / "old.py").write_text("from typing import NamedTuple\nclass Pair(NamedTuple):\n    x: float\n")
    take = "from small.caller import *; from small.{} import Pair; print({}(Pair(6.0)))"
    assert python(take.format("old", "pair_of"), small) == "6.0"
    (small / "old.py").rename(small / "new.py")
    for _ in range(2):
        assert float(python(take.format("new", called), small)) == {"pair_of": 6.0, "half_of": 3.0}[called]
    count = f"{called}.stats.cache_hits.values()"
    assert python(f"{take.format('new', called)}; print(sum({count}))", small).split()[1] == "1"


def test_what_another_numba_has_written_is_left_alone(tmp_path: Path) -> None:
    small = package(tmp_path)
    beside = small / "__pycache__"
    beside.mkdir()
    foreign = [beside / f"caller.call-99.py311.{end}" for end in ("nbi", "1.nbc", "numba0_1-0.0.nbc")]
    for file in foreign:
        file.write_bytes(b"unreadable")
    assert run(small) == (2.0, 0)
    assert all(file.exists() for file in foreign)


def test_a_damaged_file_of_code_is_made_anew(tmp_path: Path) -> None:
    small = package(tmp_path)
    assert run(small) == (2.0, 0)
    (code,) = (small / "__pycache__").glob("caller.call*.nbc")
    code.write_bytes(code.read_bytes()[:20])
    assert run(small) == (2.0, 0)
    assert run(small) == (2.0, 1)


def test_on_a_full_disk_code_is_used_and_said_once_not_to_be_kept(tmp_path: Path) -> None:
    small, cache = package(tmp_path), tmp_path / "cache"
    cache.mkdir()
    code = f"""
import resource, signal, warnings
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
from small.caller import call
resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))  # no file can grow, as on a full disk
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    print(call(1.0), call(1), len(said))
assert "could not be kept in {cache}" in str(said[0].message), said[0].message
assert "File too large; every start compiles it anew; set NUMBA_CACHE_DIR" in str(said[0].message)
"""
    assert python(code, small, cache) == "2.0 2.0 1"
    assert not [path for path in cache.rglob("*") if path.is_file()]


def test_every_signature_has_a_file_of_its_own_whoever_writes_it(tmp_path: Path) -> None:
    """Numba's index gives two signatures that two processes compile at once one number, and so one file."""
    small = package(tmp_path)
    names = set()
    for value in ("1.0", "1", "1j"):
        before = set((small / "__pycache__").glob("caller.call*"))
        python(f"from small.caller import call; call({value})", small)
        (new,) = set((small / "__pycache__").glob("caller.call*")) - before
        new.rename(small / new.name)  # the next process sees none, as one that began at the same time
        names.add(new.name)
    assert len(names) == 3
    for name in names:
        (small / name).rename(small / "__pycache__" / name)
    said = "print(*(call(x) for x in (1.0, 1, 1j)), sum(call.stats.cache_hits.values()))"
    assert python(f"from small.caller import call; {said}", small) == "2.0 2.0 2j 3"


SUMS = """
import numpy as np
from otolith.core.jit import jit_fused, kernel

@jit_fused
def total(x):
    sum_ = 0.0
    for i in range(x.size):
        sum_ += np.exp(x[i]) * np.sin(x[i]) / (1.0 + x[i])
    return sum_

@kernel
def twice(x):
    return total(x) + total(x[::-1])

@kernel
def thrice(x):
    return twice(x) + total(x[1:])
"""
COPIES = """
import numpy as np
from llvmlite.binding import Linkage
from small.sums import thrice

thrice(np.ones(9))
((overload,),) = [thrice.overloads.values()]
module = overload.library._final_module
own = [f for f in module.functions if not f.is_declaration and f.name.startswith("_ZN5small")]
print(*sorted({Linkage(f.linkage).name for f in own}))
"""


def test_no_other_library_replaces_the_copies_that_a_function_calls(tmp_path: Path) -> None:
    small = package(tmp_path)
    (small / "sums.py").write_text(SUMS)
    # its own name is seen from outside; what it calls is there, and seen by nobody
    assert python(COPIES, small) == "external internal"


SLOW = """
import os, time
from pathlib import Path
import numba.extending
from otolith.core.jit import kernel

FOLDER = Path(__file__).parent

def number(x):
    pass

@numba.extending.overload(number)
def compile_number(x):
    with (FOLDER / "compiling").open("a") as file:
        file.write(f"{os.getpid()}\\n")
    while not (FOLDER / "go").exists():
        time.sleep(0.01)
    return lambda x: 2.0 * x

@kernel
def slow(x):
    return number(x)
"""


def compilers(small: Path) -> list[int]:
    """The processes that have begun to compile, in their order."""
    told = small / "compiling"
    return [int(line) for line in told.read_text().split()] if told.exists() else []


def started(small: Path) -> subprocess.Popen[str]:
    """A process that calls the slow kernel."""
    source = Path(otolith.__file__).parents[1]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(small.parent), str(source)])}
    code = "from small.slow import slow; print('calling', flush=True); print(slow(3.0))"
    return subprocess.Popen(
        [sys.executable, "-c", code],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.skipif(os.name != "posix", reason="there two processes compile the same, as documented")
@pytest.mark.parametrize("killed", [False, True])
def test_of_two_processes_that_need_the_same_code_one_compiles_and_the_other_waits(
    tmp_path: Path, killed: bool
) -> None:
    small = package(tmp_path)
    (small / "slow.py").write_text(SLOW)
    with started(small) as first, started(small) as second:
        try:
            for process in (first, second):
                assert process.stdout is not None
                assert process.stdout.readline() == "calling\n"
            until(lambda: len(compilers(small)) == 1)
            time.sleep(1.0)  # in which the other one would begin, too
            (busy,) = compilers(small)
            at_work, other = (first, second) if first.pid == busy else (second, first)
            if killed:
                at_work.kill()
                until(lambda: compilers(small) == [busy, other.pid])
            (small / "go").touch()
            results = [process.communicate(timeout=120)[0] for process in (at_work, other)]
        finally:
            first.kill()
            second.kill()
    assert results == (["", "6.0\n"] if killed else ["6.0\n", "6.0\n"])
    assert compilers(small) == ([busy, other.pid] if killed else [busy])
    assert not list((small / "__pycache__").glob("*.lock"))


def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds, for two minutes at most."""
    end = time.monotonic() + 120.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_garbage_is_looked_for_seldom_while_compiling_and_as_before_afterwards() -> None:
    before = gc.get_threshold()
    within = SourceCache(time_of).alone(lambda _: gc.get_threshold())(())
    assert within[0] >= 50_000
    assert within[1:] == before[1:]
    assert gc.get_threshold() == before


def time_of(x: float) -> float:
    return x
