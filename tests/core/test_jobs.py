"""Work that processes share: the results of one process, in their order, and nothing left behind."""

import multiprocessing
import os

import pytest

from otolith.core.disk import NotWritten
from otolith.core.errors import CorruptFile, InputError, OtolithError
from otolith.core.jobs import WorkerLost, Workers, number_of_jobs


def halved(of: int, item: int) -> int:
    """Count down from an item, so that later ones are done first, and refuse odd ones."""
    if item % 2:
        raise InputError("the item", item, "even")
    return of + sum(1 for _ in range(item)) // 2


def process(of: None, item: int) -> int:
    return os.getpid()


def lost(of: None, item: int) -> None:
    os._exit(3)


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_come_in_the_order_of_the_work_and_errors_as_they_are(jobs: int) -> None:
    seen: list[int] = []
    with Workers(jobs, 10) as workers:
        assert workers.each(halved, [600_000, 2, 4, 400_000], seen.append) == [300_010, 11, 12, 200_010]
        assert sorted(seen) == [2, 4, 400_000, 600_000]
        assert workers.each(halved, []) == []
        assert workers.each(halved, [8]) == [14]
        with pytest.raises(InputError, match=r"^the item is 3, must be even$") as refused:
            workers.each(halved, [2, 3])
    assert (refused.value.field, refused.value.value) == ("the item", 3)
    assert not multiprocessing.active_children()


def test_one_job_is_done_here_and_several_elsewhere() -> None:
    with Workers(1, None) as workers:
        assert set(workers.each(process, [1, 2])) == {os.getpid()}
    with Workers(2, None) as workers:
        assert os.getpid() not in workers.each(process, [1, 2])


def test_an_interruption_leaves_no_process_behind() -> None:
    def interrupt(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), Workers(2, 0) as workers:
        workers.each(halved, [2 * k for k in range(20)], interrupt)
    assert not multiprocessing.active_children()


def test_a_process_that_ends_by_itself_is_one_sentence() -> None:
    with pytest.raises(WorkerLost, match="perhaps because memory was short"), Workers(2, None) as workers:
        workers.each(lost, [1, 2])
    assert not multiprocessing.active_children()


def test_errors_travel_between_processes_as_they_are() -> None:
    import pickle
    from pathlib import Path

    errors: list[OtolithError] = [
        InputError("a", 1, "b"),
        CorruptFile("c"),
        NotWritten(Path("d"), "the disk is full"),
    ]
    for error in errors:
        again = pickle.loads(pickle.dumps(error))
        assert (type(again), str(again), vars(again)) == (type(error), str(error), vars(error))


def test_the_number_of_jobs_is_as_asked_or_what_is_worth_it() -> None:
    cores = number_of_jobs(None)
    assert 1 <= cores <= (os.cpu_count() or 1)
    assert number_of_jobs(7) == 7
    assert number_of_jobs(None, most=0) == number_of_jobs(None, most=1) == 1
    assert number_of_jobs(None, most=10**6) == cores
    with pytest.raises(InputError, match=r"--jobs is 0, must be at least 1"):
        number_of_jobs(0)
