"""A lock that processes share: one of them does a piece of work, the others wait and find it done."""

import contextlib
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Final

PATIENCE: Final = 600.0  # [s] after which a process goes on without the lock; its holder may be stopped
_PAUSE: Final = 0.02  # [s] between two attempts


@contextlib.contextmanager
def sole(
    path: Path,
    *,
    patience: float = PATIENCE,
    now: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> Iterator[bool]:
    """Wait until no other process holds the lock of this name; yield whether this process holds it now.

    The lock belongs to the open file, so the system gives it back when its process ends, however it ends. Who
    has held it removes the file; one that a killed process has left locks nobody out.

    Such a lock saves work that would be done twice; it is no means to keep data sound. Whoever gets it has to
    look whether the work is done. And a process goes on without it after `patience` [s], or where the file
    cannot be locked: in a folder that cannot be written to, on a file system without locks, and on Windows.
    """
    file = _opened(path)
    if file is None:
        yield False
        return
    with file:
        end = now() + patience
        try:
            while not (held := _locked(file)) and now() < end:
                sleep(_PAUSE)
        except OSError:  # the file system has no locks, or none left
            held = False
        try:
            yield held
        finally:
            if held:
                with contextlib.suppress(OSError):  # the file stays, and locks nobody out
                    path.unlink(missing_ok=True)


def _opened(path: Path) -> IO[bytes] | None:
    """Open the file of a lock; None where there is nothing to lock."""
    if os.name != "posix":
        return None
    try:
        return path.open("ab")
    except OSError:
        return None


def _locked(file: IO[bytes]) -> bool:
    """Lock a file unless another process has; return whether this process has it."""
    import fcntl  # which Windows lacks

    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
