"""Jobs are done once each, here or in other processes, with the same answers."""

from dataclasses import dataclass

import pytest

from otolith_thesis.jobs import do_all


@dataclass(frozen=True)
class Square:
    """A job that could hardly be simpler."""

    value: int
    cost: float = 1.0

    @property
    def label(self) -> str:
        return f"square of {self.value}"

    def run(self) -> int:
        if self.value < 0:
            raise ValueError(f"no {self.value}")
        return self.value**2


@pytest.mark.parametrize("processes", [1, 2])
def test_every_job_is_done_once_the_long_ones_first(processes: int) -> None:
    reports: list[tuple[str, float]] = []
    jobs = [Square(2), Square(3, cost=5.0), Square(2), Square(4)]
    answers = do_all(jobs, processes=processes, progress=lambda *now: reports.append(now))
    assert answers == {job: job.value**2 for job in jobs}
    assert len(reports) == 3
    assert reports[-1][1] == pytest.approx(1.0)
    if processes == 1:
        assert [label for label, _ in reports] == ["square of 3", "square of 2", "square of 4"]


@pytest.mark.parametrize("processes", [1, 2])
def test_a_job_that_fails_ends_the_work(processes: int) -> None:
    with pytest.raises(ValueError, match="no -1"):
        do_all([Square(-1, cost=9.0), Square(2)], processes=processes, progress=lambda *_: None)


def test_an_interruption_leaves_no_process_behind() -> None:
    import multiprocessing

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        do_all([Square(k) for k in range(20)], processes=2, progress=interrupt)
    assert not multiprocessing.active_children()


def test_nothing_to_do_is_done() -> None:
    assert do_all([], processes=2, progress=lambda *_: None) == {}
