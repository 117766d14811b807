"""Work that is shared between processes, with the results of one process, in the same order.

The processes are those of the standard library. joblib was tried instead: the requirements here (Ctrl-C is
handled by one process, no other process is left behind, errors are those of the work) took as many lines of
our own, so it would have added a dependency and saved no code.
"""

import functools
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from types import TracebackType
from typing import Any, Generic, Self, TypeVar

from otolith.core.errors import InputError, OtolithError
from otolith.core.threads import one_thread

Shared = TypeVar("Shared")
Item = TypeVar("Item")
Result = TypeVar("Result")

_shared: Any = None  # in a worker: what all of its work has in common


class WorkerLost(OtolithError):
    """A process that did part of the work ended without a result."""


class Workers(Generic[Shared]):
    """Processes that do work with something in common, which is sent to each of them once.

    It is a context manager. An interruption of the block, or an error, ends the processes at once. With one
    job, or one item, the work is done in the calling process. Work, items and results have to be picklable.

    Parameters
    ----------
    jobs : number of processes.
    shared : what all work has in common; it is the first argument of the work.
    """

    def __init__(self, jobs: int, shared: Shared) -> None:
        self.jobs, self._shared = jobs, shared
        self._pool: ProcessPoolExecutor | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._pool is None:
            return
        if kind is not None:
            for process in list((self._pool._processes or {}).values()):
                process.terminate()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def each(
        self,
        work: Callable[[Shared, Item], Result],
        items: Sequence[Item],
        done: Callable[[Item], None] = lambda _: None,
    ) -> list[Result]:
        """Return the results of the work on every item, in the order of the items.

        Parameters
        ----------
        done : is called with every item that is done, in the order of time.

        Raises
        ------
        WorkerLost : a process ended without a result. Errors of the work are raised as they are.
        """
        results = dict(self.as_done(work, items, done))
        return [results[k] for k in range(len(items))]

    def as_done(
        self,
        work: Callable[[Shared, Item], Result],
        items: Sequence[Item],
        done: Callable[[Item], None] = lambda _: None,
    ) -> Iterator[tuple[int, Result]]:
        """Yield the number of every item, and its result, as soon as it is known; see `each`."""
        if self.jobs < 2 or len(items) < 2:
            for k, item in enumerate(items):
                yield k, _with_one_thread(work, self._shared, item)
                done(item)
            return
        if self._pool is None:
            # Processes are spawned, because threads and compiled code do not survive a fork.
            self._pool = ProcessPoolExecutor(
                self.jobs, get_context("spawn"), initializer=_begin, initargs=(self._shared,)
            )
        waiting: dict[Future[Result], int] = {
            self._pool.submit(_work, work, item): k for k, item in enumerate(items)
        }
        try:
            for future in as_completed(waiting):
                yield waiting[future], future.result()
                done(items[waiting[future]])
        except BrokenProcessPool as error:
            raise WorkerLost(
                "a process that did part of the work ended by itself, perhaps because memory was short; "
                "fewer processes (--jobs) need less"
            ) from error


def number_of_jobs(asked: int | None, most: int | None = None) -> int:
    """Return the number of processes that `--jobs` asks for: one per core if it was not given.

    Parameters
    ----------
    most : number of processes that are worth their start, if it was not given.

    Raises
    ------
    InputError : it is less than 1.
    """
    if asked is None:
        return max(1, min(_cores(), _cores() if most is None else most))
    if asked < 1:
        raise InputError("--jobs", asked, "at least 1")
    return asked


@functools.cache
def _cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _begin(shared: Any) -> None:
    """Prepare a worker, where Ctrl-C is left to the process that started it."""
    global _shared
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _shared = shared


def _work(work: Callable[[Any, Item], Result], item: Item) -> Result:
    return _with_one_thread(work, _shared, item)


def _with_one_thread(work: Callable[[Shared, Item], Result], shared: Shared, item: Item) -> Result:
    """Do work with one thread of BLAS: more would wait for each other, and change the last digits."""
    with one_thread():
        return work(shared, item)
