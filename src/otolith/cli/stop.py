"""How the program ends when it is told to: one sentence, nothing half-written, the shell's exit code.

Imports nothing of this package and nothing slow: it is in place before the rest is imported.
"""

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from types import FrameType
from typing import NoReturn

_WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}


class Stopped(BaseException):
    """A signal asks the program to end; no `except Exception` and no library catches it."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextlib.contextmanager
def signals_stop() -> Iterator[None]:
    """Let SIGINT (Ctrl-C) and SIGTERM raise `Stopped` inside; afterwards they do what they did before.

    A signal that is ignored, as under nohup, stays ignored. Only the main thread can do this.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.getsignal(number) for number in _WORDS}
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, _stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def told(stopped: Stopped) -> NoReturn:
    """Say that the program was stopped, and end with 128 + the signal's number, as shells expect it."""
    for number in _WORDS:
        signal.signal(number, signal.SIG_IGN)  # the end is near: a second Ctrl-C shall not disturb it
    word = _WORDS[signal.Signals(stopped.number)]
    with contextlib.suppress(OSError):
        sys.stderr.write(f"otolith: {word}; nothing half-written was left\n")
    sys.exit(128 + stopped.number)


def _stop(number: int, _: FrameType | None) -> NoReturn:
    raise Stopped(number)
