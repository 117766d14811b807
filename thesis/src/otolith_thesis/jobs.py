"""Jobs that are run once each in several processes, because tables and figures share loops and laws.

A job is a value: equal jobs are one job. Its result depends only on the job, so it does not matter where and
in which order jobs run. The processes are those of the standard library. joblib was tried instead: the
requirements here (Ctrl-C is handled by one process, no other process is left behind, an error names its job)
took as many lines of our own, so it would have added a dependency and saved no code.
"""

import signal
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Any, Protocol


class Job(Protocol):
    """A computation; it is hashable, so that it runs once, and picklable."""

    @property
    def label(self) -> str:
        """Return a few words for the progress line."""

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]; long jobs start first."""

    def run(self) -> Any:
        """Compute the result."""


Answers = Mapping[Any, Any]
OnProgress = Callable[[str, float], None]  # arguments: label of the finished job, fraction of all work done


def do_all(jobs: Iterable[Job], *, processes: int, progress: OnProgress) -> dict[Job, Any]:
    """Run every job once and return the results by job.

    With one process, all jobs run in the calling process. An interruption ends the other processes at once.
    """
    order = sorted(set(jobs), key=lambda job: (-job.cost, job.label))
    total = sum(job.cost for job in order) or 1.0
    answers: dict[Job, Any] = {}
    done = 0.0
    for job, answer in _answered(order, processes):
        answers[job] = answer
        done += job.cost
        progress(job.label, done / total)
    return answers


def _answered(order: list[Job], processes: int) -> Iterable[tuple[Job, Any]]:
    if processes < 2 or len(order) < 2:
        yield from ((job, job.run()) for job in order)
        return
    # Processes are spawned, because threads and compiled code do not survive a fork.
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
    """Ignore Ctrl-C, which the parent process handles; it ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
