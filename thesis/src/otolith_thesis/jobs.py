"""Jobs that are run once each in several processes, because tables and figures share loops and laws.

A job is a value: equal jobs are one job. Its result depends only on the job, so it does not matter where and
in which order jobs run.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

from otolith.core.jobs import Workers


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
    """Run every job once and return the results by job; see `otolith.core.jobs.Workers`."""
    order = sorted(set(jobs), key=lambda job: (-job.cost, job.label))
    total, ran = sum(job.cost for job in order) or 1.0, 0.0

    def done(job: Job) -> None:
        nonlocal ran
        ran += job.cost
        progress(job.label, ran / total)

    with Workers(processes, None) as workers:
        return dict(zip(order, workers.each(_run, order, done), strict=True))


def _run(_: None, job: Job) -> Any:
    return job.run()
