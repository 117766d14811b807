"""Where jobs are done: in this process, or in several on this machine. `otolith.studies.cluster` is a third.

An executor yields results in the order of time. What a lost process was doing is done again.
"""

from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import Any, Final, Protocol, Self, TypeVar

from otolith.core.jobs import WorkerLost, Workers

Item = TypeVar("Item")
Result = TypeVar("Result")

LOSSES: Final = 3  # how often in a row processes may be lost without any job having been done


class Executor(Protocol):
    """Does work on items with something in common; a context manager."""

    def __enter__(self) -> Self:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End all that was begun."""

    def as_done(
        self, work: Callable[[Any, Item], Result], items: Sequence[Item]
    ) -> Iterator[tuple[int, Result]]:
        """Yield the number of every item with its result, once each, as soon as it is known."""


class Processes:
    """Processes on this machine, or with one of them this process itself.

    Parameters
    ----------
    shared : what all work has in common; it is the first argument of the work.

    Raises
    ------
    WorkerLost : a process was lost `LOSSES` times in a row before any job was done.
    """

    def __init__(self, jobs: int, shared: Any) -> None:
        self._jobs, self._shared = jobs, shared
        self._workers: Workers[Any] = Workers(jobs, shared)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._workers.__exit__(kind, error, trace)

    def as_done(
        self, work: Callable[[Any, Item], Result], items: Sequence[Item]
    ) -> Iterator[tuple[int, Result]]:
        """Yield the number of every item with its result; see `Executor`."""
        open_ = list(range(len(items)))
        losses = 0
        while open_:
            asked = list(open_)
            try:
                for k, result in self._workers.as_done(work, [items[number] for number in asked]):
                    losses = 0
                    open_.remove(asked[k])
                    yield asked[k], result
            except WorkerLost as lost:
                losses += 1
                if losses == LOSSES:
                    raise
                self._workers.__exit__(WorkerLost, lost, None)
                self._workers = Workers(self._jobs, self._shared)
