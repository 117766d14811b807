"""`otolith live run` as its own process: signals, a closed terminal, its death, no rights, a second one."""

import ctypes
import fcntl
import os
import pty
import signal
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from otolith.live.devices.emulator import ENGAGED, FAULT_2, IDLE
from otolith.live.permits import keep_axis_test
from otolith.live.shell.supervise import Occupied, only_session
from tests.live.shell.rig import Rig, until

PROGRAM = [sys.executable, "-c", "from otolith.cli import main; main()", "live", "run"]
WASHOUT = ["--cueing", "classical", "--tuning", "davsi"]
_DROP_FROM_BOUNDS, _RAISE_PRIORITIES = 24, 23  # PR_CAPBSET_DROP, CAP_SYS_NICE


def without_rights() -> None:
    """Take from this process, and from what it starts, the right to real-time scheduling."""
    ctypes.CDLL(None).prctl(_DROP_FROM_BOUNDS, _RAISE_PRIORITIES)


def hearing() -> None:
    """A test run in the background ignores SIGINT, one under nohup SIGHUP, and so would their children; the
    program respects that.
    """
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


@pytest.fixture
def rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    """A driver and a base, whose axes are tested."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    with Rig() as made:
        keep_axis_test(made.session(), ["surge"])
        yield made


class Program:
    """A session that arms and engages by itself, on a terminal of its own or with its words in a file."""

    def __init__(
        self, rig: Rig, folder: Path, prepare: Callable[[], None] = hearing, *, terminal: bool = False
    ) -> None:
        incoming, outgoing = rig.urls
        self._words = folder / f"{time.monotonic_ns()}.txt"
        self.master, slave = (
            pty.openpty() if terminal else (-1, os.open(self._words, os.O_CREAT | os.O_WRONLY))
        )

        def begin() -> None:
            prepare()
            if terminal:
                os.setsid()
                fcntl.ioctl(slave, termios.TIOCSCTTY, 0)

        self.process = subprocess.Popen(
            [*PROGRAM, "--in", incoming, "--out", outgoing, "--seconds", "600", *WASHOUT, "--allow-jitter"],
            stdin=slave if terminal else subprocess.DEVNULL,
            stdout=slave,
            stderr=slave,
            preexec_fn=begin,
            env={**os.environ, "TMPDIR": str(folder)},  # where locks are
        )
        os.close(slave)

    @property
    def said(self) -> str:
        return " ".join(self._words.read_text().split())

    def children(self) -> list[int]:
        """Processes that this one has started."""
        listed = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return [int(number) for number in listed.read_text().split()]


def is_running(number: int) -> bool:
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def order(rig: Rig) -> list[int]:
    """States of the base without those that it only passes through."""
    return [state for state in rig.states if state in {IDLE, ENGAGED, FAULT_2}]


def test_a_session_that_is_terminated_parks_and_a_second_one_is_refused_by_its_number(
    tmp_path: Path, rig: Rig
) -> None:
    first = Program(rig, tmp_path)
    rig.moves()
    second = Program(rig, tmp_path)
    assert second.process.wait(60.0) != 0
    assert f"is driven by process {first.process.pid} already" in second.said
    children = first.children()
    first.process.send_signal(signal.SIGTERM)
    until(lambda: "asked to end" in first.said, "it has begun to end")
    first.process.send_signal(signal.SIGINT)  # of somebody impatient
    assert first.process.wait(60.0) == 128 + signal.SIGTERM
    until(lambda: not any(map(is_running, children)), "its processes have ended", 20.0)
    rig.is_at_home()
    assert rig.base.faults == 0
    assert "parked: parked" in first.said


def test_a_session_without_rights_says_so_and_ends_parked_or_in_a_fault(tmp_path: Path, rig: Rig) -> None:
    """On a busy machine it is late so often that its watchdogs, or the base's, may end it first."""
    session = Program(rig, tmp_path, without_rights)
    until(lambda: ENGAGED in rig.states, "the base has engaged")
    session.process.send_signal(signal.SIGTERM)
    assert session.process.wait(60.0) == 128 + signal.SIGTERM
    until(lambda: rig.base.state in {IDLE, FAULT_2}, "the base has parked, or is in a fault", 30.0)
    until(lambda: bool(np.abs(rig.base.position).max() < 1e-3), "the base is at home", 30.0)
    assert "real-time scheduling refused" in session.said
    assert "@otolith - rtprio 30" in session.said


def test_a_session_whose_terminal_is_closed_returns_parks_and_ends(tmp_path: Path, rig: Rig) -> None:
    session = Program(rig, tmp_path, terminal=True)
    rig.moves()
    children = session.children()
    os.close(session.master)
    session.process.wait(60.0)
    rig.is_at_home()
    assert rig.base.faults == 0
    assert order(rig) == [IDLE, ENGAGED, IDLE]
    until(lambda: not any(map(is_running, children)), "its processes have ended", 20.0)


def test_a_supervisor_that_is_killed_leaves_an_output_that_parks_and_a_lock_that_is_taken_over(
    tmp_path: Path, rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    session = Program(rig, tmp_path)
    rig.moves()
    children = session.children()
    session.process.kill()
    session.process.wait()
    device, told = ("127.0.0.1", rig.device), list[str]()
    with pytest.raises(Occupied, match=f"by what process {session.process.pid} left behind"):
        only_session(device).__enter__()
    rig.is_at_home()
    assert rig.base.faults == 0
    assert order(rig) == [IDLE, ENGAGED, IDLE]
    until(lambda: not any(map(is_running, children)), "its processes have ended", 20.0)
    for _ in range(2):  # the second time the first has let it go in order
        with only_session(device, told.append):
            pass
    assert [f"taken over from process {session.process.pid}" in line for line in told] == [True]
