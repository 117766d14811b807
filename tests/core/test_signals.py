"""Signals wait for the end of a block, and are then heard by whoever heard them before."""

import signal
import threading
from collections.abc import Iterator

import pytest

from otolith.core.signals import signals_wait


class Asked(BaseException):
    pass


@pytest.fixture
def handled() -> Iterator[None]:
    """SIGTERM raises, as in the program."""

    def stop(number: int, _: object) -> None:
        raise Asked(number)

    before = signal.signal(signal.SIGTERM, stop)
    yield
    signal.signal(signal.SIGTERM, before)


@pytest.mark.usefixtures("handled")
def test_a_signal_is_heard_after_the_block_once_and_by_its_own_handler() -> None:
    reached = []

    def asked_within() -> None:
        with signals_wait():
            signal.raise_signal(signal.SIGTERM)
            signal.raise_signal(signal.SIGTERM)
            reached.append(True)

    with pytest.raises(Asked):
        asked_within()
    assert reached
    with pytest.raises(Asked):  # the handler is back
        signal.raise_signal(signal.SIGTERM)


@pytest.mark.usefixtures("handled")
def test_a_request_to_end_outweighs_a_failure_of_the_block() -> None:
    def fails() -> None:
        with signals_wait():
            signal.raise_signal(signal.SIGTERM)
            raise ZeroDivisionError

    with pytest.raises(Asked):
        fails()


def test_what_is_ignored_stays_ignored_and_other_threads_are_left_alone() -> None:
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with signals_wait():
            signal.raise_signal(signal.SIGTERM)
            assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, before)
    seen = []

    def elsewhere() -> None:
        with signals_wait():
            seen.append(signal.getsignal(signal.SIGINT))

    expected = signal.getsignal(signal.SIGINT)
    other = threading.Thread(target=elsewhere)
    other.start()
    other.join()
    assert seen == [expected]
