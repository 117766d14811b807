"""A lock is held by one, waited for by others, for so long and no longer, and never left behind."""

import errno
import os
from pathlib import Path

import pytest

from otolith.core.locks import sole

pytestmark = pytest.mark.skipif(os.name != "posix", reason="there is no lock")


def test_a_lock_is_held_by_one_and_given_back(tmp_path: Path) -> None:
    path = tmp_path / "a.lock"
    seconds: list[float] = []
    with sole(path) as held:
        assert held
        with sole(path, patience=0.1, now=lambda: sum(seconds), sleep=seconds.append) as second:
            assert not second
        assert sum(seconds) == pytest.approx(0.1, abs=0.03)
        assert path.exists()  # who did not hold it leaves it
    assert not path.exists()
    with sole(path, patience=0.0) as held:
        assert held


def test_a_lock_is_given_back_after_an_error_and_to_who_waits(tmp_path: Path) -> None:
    path = tmp_path / "a.lock"
    first = sole(path)
    first.__enter__()

    def give_back(_: float) -> None:
        first.__exit__(None, None, None)

    with sole(path, sleep=give_back) as held:
        assert held
    with pytest.raises(KeyError), sole(path):
        raise KeyError
    assert not path.exists()


def test_where_nothing_can_be_locked_work_goes_on(tmp_path: Path) -> None:
    with sole(tmp_path / "missing" / "a.lock") as held:
        assert not held
    (tmp_path / "left.lock").touch()  # as by a process that was killed
    with sole(tmp_path / "left.lock", patience=0.0) as held:
        assert held


def test_on_a_file_system_without_locks_work_goes_on_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr("fcntl.flock", refuse)
    with sole(tmp_path / "a.lock", sleep=lambda _: pytest.fail("it waits")) as held:
        assert not held


def test_a_file_that_cannot_be_removed_stays_and_locks_nobody_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    path = tmp_path / "a.lock"
    with monkeypatch.context() as patched:
        patched.setattr(Path, "unlink", refuse)
        with sole(path) as held:
            assert held
    assert path.exists()
    with sole(path, patience=0.0) as held:
        assert held
