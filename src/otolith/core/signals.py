"""Signals that have to wait: code that C calls back must not be left by an exception."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_WAIT = ("SIGINT", "SIGTERM", "SIGHUP")  # the last one is not known everywhere


@contextmanager
def signals_wait() -> Iterator[None]:
    """Let requests to end the program wait until the end of the block.

    Python runs a signal's handler between any two of its own steps, thus also in a function that a C library
    calls. If the handler raises there, the library may crash. In other threads than the main one, no handler
    is ever run, and the block is not changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []

    def note(number: int, _: FrameType | None) -> None:
        came.append(number)

    handlers = {}
    try:
        for number in (getattr(signal, name) for name in _WAIT if hasattr(signal, name)):
            if callable(handler := signal.getsignal(number)):
                handlers[number] = handler
                signal.signal(number, note)
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])
