"""Jobs done once each, in several processes: tables and figures share closed loops and explicit laws.

A job is a value: equal jobs are one job. Its answer depends on nothing but itself, so it does not matter
where and in which order jobs are done. The processes are the standard library's. joblib was tried in their
place: what is asked for here (Ctrl-C answered by one process alone, no other left behind, an error that names
its job) took as many lines of its own, so it would have been a dependency more and no code less.
"""

import signal
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any, Protocol


class Job(Protocol):
    """Something to compute; hashable, so that it is done once, and picklable."""

    @property
    def label(self) -> str:
        """A few words for the progress line."""

    @property
    def cost(self) -> float:
        """Seconds that it takes, roughly: the long ones begin first."""

    def run(self) -> Any:
        """Do it."""


Answers = Mapping[Any, Any]
Tell = Callable[[str, float], None]  # label of the job that is done, fraction of all work done


def do_all(jobs: Iterable[Job], *, processes: int, tell: Tell) -> dict[Job, Any]:
    """Do every job once and return the answers by job.

    With one process all is done here. An interruption ends the other processes at once.
    """
    order = sorted(set(jobs), key=lambda job: (-job.cost, job.label))
    total = sum(job.cost for job in order) or 1.0
    answers: dict[Job, Any] = {}
    done = 0.0
    for job, answer in _answered(order, processes):
        answers[job] = answer
        done += job.cost
        tell(job.label, done / total)
    return answers


def _answered(order: list[Job], processes: int) -> Iterable[tuple[Job, Any]]:
    if processes < 2 or len(order) < 2:
        yield from ((job, job.run()) for job in order)
        return
    # Spawned, not forked: threads and compiled code do not survive a fork.
    pool = ProcessPoolExecutor(processes, mp_context=get_context("spawn"), initializer=_ignore_interrupt)
    try:
        waiting: dict[Future[Any], Job] = {pool.submit(_run, job): job for job in order}
        for future in as_completed(waiting):
            yield waiting[future], future.result()
    except BaseException:
        for process in list((pool._processes or {}).values()):
            process.terminate()
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _run(job: Job) -> Any:
    return job.run()


def _ignore_interrupt() -> None:
    """Leave Ctrl-C to the process that the user sees; it ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
