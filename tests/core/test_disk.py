"""Files are whole or absent, whatever stops their writer; what is read is bounded."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from otolith.core import disk
from otolith.core.errors import InputError


def dead_process() -> int:
    """Number of a process that has ended."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


def test_a_full_disk_is_one_sentence_and_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.write_bytes(b"old")

    def fill(temporary: Path) -> None:
        temporary.write_bytes(b"half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with (
        pytest.raises(disk.NotWritten, match=r"run.h5 could not be written: No space left on device"),
        disk.whole(path) as temporary,
    ):
        fill(temporary)
    assert path.read_bytes() == b"old"
    assert names(tmp_path) == ["run.h5"]


def test_a_disk_that_is_full_only_when_it_is_forced_to_write_counts_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.EDQUOT, os.strerror(errno.EDQUOT))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(disk.NotWritten, match="quota"):
        disk.write_text(tmp_path / "a.json", "{}")
    assert names(tmp_path) == []


def test_what_a_killed_program_left_is_swept_and_what_a_living_one_writes_is_not(tmp_path: Path) -> None:
    dead = disk.part_prefix(tmp_path / "run.h5").replace(f"-{os.getpid()}-", f"-{dead_process()}-")
    (tmp_path / f"{dead}abc123.h5").write_bytes(b"half")
    (tmp_path / f"{dead}folder").mkdir()
    (tmp_path / f"{dead}folder" / "run.h5").write_bytes(b"half")
    (tmp_path / ".hidden").write_text("mine")
    with disk.whole(tmp_path / "first.txt") as living:
        disk.write_text(tmp_path / "second.txt", "x")
        assert living.exists()
        assert names(tmp_path) == sorted([".hidden", living.name, "second.txt"])
    assert names(tmp_path) == [".hidden", "first.txt", "second.txt"]


def test_another_machines_temporary_file_is_swept_after_a_day(tmp_path: Path) -> None:
    other = tmp_path / ".run.h5.part-elsewhere-1-abc.h5"
    other.write_bytes(b"half")
    disk.sweep(tmp_path)
    assert other.exists()
    old = other.stat().st_mtime - 1.01 * disk._ABANDONED
    os.utime(other, (old, old))
    disk.sweep(tmp_path)
    assert not other.exists()


def test_a_file_is_read_up_to_its_bound_and_no_further(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    path.write_bytes(b"x" * 100)
    assert disk.read_bytes(path, "platform", most=100) == b"x" * 100
    with pytest.raises(InputError, match="is more than 99 bytes, must be at most 99 bytes"):
        disk.read_bytes(path, "platform", most=99)
    with pytest.raises(InputError, match="not readable"):
        disk.read_text(tmp_path, "platform")


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="no endless file here")
def test_an_endless_file_is_refused() -> None:
    with pytest.raises(InputError, match="more than 1,000,000 bytes"):
        disk.read_text(Path("/dev/zero"), "platform")


@pytest.mark.skipif(os.name != "posix", reason="there are no such files")
def test_a_device_or_pipe_is_not_replaced_by_a_file(tmp_path: Path) -> None:
    os.mkfifo(pipe := tmp_path / "pipe")
    with pytest.raises(disk.NotWritten, match="it is a device, a pipe or a socket"):
        disk.write_text(pipe, "text")
    assert pipe.is_fifo()
    assert [path.name for path in tmp_path.iterdir()] == ["pipe"]
