"""Jobs are done once each, wherever they are done, and what a process that dies was doing is done again."""

import os
import time
from pathlib import Path

import pytest

from otolith.core.errors import InputError
from otolith.core.jobs import WorkerLost
from otolith.studies.executors import Processes


def squared(folder: Path, item: int) -> int:
    """Square a number and note that it was done; who comes to 5 first dies."""
    if item == 5 and not (folder / "died").exists():
        (folder / "died").touch()
        time.sleep(0.2)  # so that another job is under way
        os._exit(9)
    with (folder / str(item)).open("a") as file:
        file.write("done\n")
    return item * item


def lost(folder: Path, item: int) -> None:
    os._exit(9)


def refused(folder: Path, item: int) -> int:
    raise InputError("the item", item, "another")


def test_a_process_that_dies_loses_nothing_but_its_job(tmp_path: Path) -> None:
    with Processes(2, tmp_path) as processes:
        found = list(processes.as_done(squared, range(12)))
    assert (tmp_path / "died").exists()
    assert sorted(found) == [(k, k * k) for k in range(12)]
    again = [k for k in range(12) if (tmp_path / str(k)).read_text() != "done\n"]
    assert len(again) <= 2  # what the other one had done, but not told yet


def test_processes_that_die_again_and_again_are_one_sentence(tmp_path: Path) -> None:
    with Processes(2, tmp_path) as processes, pytest.raises(WorkerLost, match="ended by itself"):
        list(processes.as_done(lost, range(4)))


def test_one_job_is_done_here_and_errors_are_those_of_the_work(tmp_path: Path) -> None:
    with Processes(1, tmp_path) as processes:
        assert list(processes.as_done(squared, [2, 3])) == [(0, 4), (1, 9)]
        with pytest.raises(InputError, match="the item is 1"):
            list(processes.as_done(refused, [1]))
