"""How the program ends on request: with one sentence, no partial files, and the shell's exit code.

This module imports nothing of this package and nothing slow, because it takes effect before the rest is
imported.
"""

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from types import FrameType, TracebackType
from typing import NoReturn

_AGAIN = 0.02  # [s] after which a lost request is repeated
_WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}
if hasattr(signal, "SIGHUP"):
    _WORDS[signal.SIGHUP] = "left without a terminal"


class Stopped(BaseException):
    """A signal asks the program to end; neither `except Exception` nor a library catches this."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextlib.contextmanager
def signals_stop() -> Iterator[None]:
    """Let SIGINT (Ctrl-C), SIGTERM and SIGHUP (a closed terminal) end the block with one sentence and the
    shell's exit code.

    The signals raise `Stopped` inside the block; afterwards their former handlers are restored. A signal that
    is ignored, as under nohup, stays ignored. Only the main thread can do this.

    If `Stopped` is raised in a callback from C (the compiler's, for example), Python can only report it and
    continues; C code may then fail and print errors, as modules that import NumPy from C do. So anything that
    fails after a signal ends in the same way, only the sentence is printed, and where the program continues
    the request is repeated.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked: list[int] = []

    def stop(number: int, _: FrameType | None) -> NoReturn:
        asked.append(number)
        raise Stopped(asked[0])

    def lost(what: "sys.UnraisableHookArgs") -> None:
        if isinstance(what.exc_value, Stopped):
            again = threading.Timer(_AGAIN, _raise_in_main_thread, [asked[0]])
            again.daemon = True
            again.start()
        else:
            report(what)

    def printed(kind: type[BaseException], value: BaseException, where: TracebackType | None) -> None:
        if not isinstance(value, Stopped):
            show(kind, value, where)

    before = {number: signal.getsignal(number) for number in _WORDS}
    report, sys.unraisablehook = sys.unraisablehook, lost
    show, sys.excepthook = sys.excepthook, printed
    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, stop)
    try:
        yield
    except Stopped as stopped:
        _exit_with_sentence(stopped.number)
    except Exception:
        if asked:
            _exit_with_sentence(asked[0])
        raise
    finally:
        sys.unraisablehook, sys.excepthook = report, show
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def unstoppable() -> Iterator[None]:
    """Let nothing but SIGKILL end the block, which takes a bounded time and must not be left half done."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, signal.SIG_IGN) for number in _WORDS}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _raise_in_main_thread(number: int) -> None:
    """Send the signal to the main thread; a signal to the process may reach another thread instead."""
    if hasattr(signal, "pthread_kill"):
        signal.pthread_kill(threading.main_thread().ident or 0, number)
    else:
        signal.raise_signal(number)


def _exit_with_sentence(number: int) -> NoReturn:
    """Report that the program was stopped, and exit with 128 + the signal's number, as shells expect."""
    for every in _WORDS:
        signal.signal(every, signal.SIG_IGN)  # a second Ctrl-C must not interrupt the exit
    word = _WORDS[signal.Signals(number)]
    with contextlib.suppress(OSError):
        sys.stderr.write(f"otolith: {word}; nothing half-written was left\n")
    sys.exit(128 + number)
