"""Jobs on a Dask cluster: of this machine, or of any that a scheduler's address names.

Every worker gets what the jobs have in common once, also one that joins later or replaces one that died. A
worker does one job at a time, whatever its number of threads, since kernels are not compiled for two at once.
"""

import itertools
import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import Any, Final, Self, TypeVar

from otolith.core.errors import InputError, MissingExtra
from otolith.core.jobs import WorkerLost
from otolith.core.threads import one_thread
from otolith.studies.executors import LOSSES

try:
    from distributed import Client, KilledWorker, LocalCluster, WorkerPlugin, as_completed
except ModuleNotFoundError as error:  # pragma: no cover (the tests have it)
    if error.name != "distributed":
        raise
    hint = "pip install 'otolith[study]'"
    raise MissingExtra(f"--cluster needs distributed, which is not installed: {hint}") from error

Item = TypeVar("Item")
Result = TypeVar("Result")

WAIT: Final = 30.0  # [s] for which a scheduler may be silent
_one_at_a_time = threading.Lock()
_shared: dict[str, Any] = {}  # in a worker: what jobs have in common, by the plugin's name
_numbers = itertools.count()


class _Prepare(WorkerPlugin):
    """Gives a worker what the jobs have in common."""

    def __init__(self, name: str, shared: Any) -> None:
        self.name, self._common = name, shared

    def setup(self, worker: Any) -> None:  # noqa: ARG002 (the role has it)
        """Keep it, as the worker starts."""
        _shared[self.name] = self._common

    def teardown(self, worker: Any) -> None:  # noqa: ARG002
        """Forget it."""
        _shared.pop(self.name, None)


def _on_worker(work: Callable[[Any, Item], Result], name: str, item: Item) -> Result:
    """Do one job, with one thread of BLAS, as `otolith.core.jobs` does."""
    with _one_at_a_time, one_thread():
        return work(_shared[name], item)


class Cluster:
    """An executor on the workers of a Dask scheduler; see `otolith.studies.executors.Executor`.

    Parameters
    ----------
    address : of a scheduler, as in tcp://host:8786; "local" makes one for the time of the study.
    shared : what all work has in common; it is the first argument of the work.
    workers : number of the processes of a local one.

    Raises
    ------
    InputError : no scheduler answers at the address.
    """

    def __init__(self, address: str, shared: Any, workers: int = 2) -> None:
        self._own: Any = None
        if address == "local":
            self._own = LocalCluster(
                n_workers=workers, threads_per_worker=1, dashboard_address=None, silence_logs=logging.ERROR
            )
        try:
            self.client: Any = Client(self._own or address, timeout=WAIT, set_as_default=False)
        except (OSError, ValueError) as error:
            bound = "the address of a Dask scheduler that answers, as in tcp://host:8786, or local"
            raise InputError("--cluster", repr(address), bound) from error
        self._plugin = f"otolith-study-{id(self)}-{self.client.id}"
        self.client.register_plugin(_Prepare(self._plugin, shared), name=self._plugin)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.client.unregister_worker_plugin(self._plugin)
        self.client.close()
        if self._own is not None:
            self._own.close()

    def as_done(
        self, work: Callable[[Any, Item], Result], items: Sequence[Item]
    ) -> Iterator[tuple[int, Result]]:
        """Yield the number of every item with its result; jobs of a worker that died are done again.

        Raises
        ------
        WorkerLost : the workers that did one and the same job died `LOSSES` times.
        """
        numbers: dict[str, int] = {}
        lost = dict.fromkeys(range(len(items)), 0)

        def submit(k: int) -> Any:
            name = f"{self._plugin}-{next(_numbers)}"
            numbers[name] = k
            return self.client.submit(_on_worker, work, self._plugin, items[k], key=name, pure=False)

        with self.client.as_current():  # which it reads as it is made
            waiting = as_completed([submit(k) for k in range(len(items))])
        for future in waiting:
            k = numbers[future.key]
            try:
                result = future.result()
            except KilledWorker as error:
                lost[k] += 1
                if lost[k] == LOSSES:
                    raise WorkerLost(f"workers that did one job died again and again: {error}") from error
                waiting.add(submit(k))
                continue
            yield k, result
