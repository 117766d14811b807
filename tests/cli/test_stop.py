"""Ctrl-C and SIGTERM, sent to real processes: one sentence, the shell's exit code, nothing half-written."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

PROGRAM = [sys.executable, "-c", "from otolith.cli import main; main()"]
CAUGHT = 1 << (signal.SIGTERM - 1)  # bit of SIGTERM in the mask of caught signals


def hearing() -> None:
    """A test run in the background ignores SIGINT, and its children would; the program respects that."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def started(folder: Path, *words: str) -> subprocess.Popen[str]:
    """The program, as soon as it has taken its signals over."""
    process = subprocess.Popen(
        [*PROGRAM, *words], cwd=folder, text=True, stderr=subprocess.PIPE, preexec_fn=hearing
    )
    status, deadline = Path(f"/proc/{process.pid}/status"), time.monotonic() + 60.0
    while time.monotonic() < deadline:
        caught = next(line for line in status.read_text().splitlines() if line.startswith("SigCgt"))
        if int(caught.split()[1], 16) & CAUGHT:
            return process
        time.sleep(0.005)
    raise AssertionError("the program never took its signals over")


def stopped(process: subprocess.Popen[str], number: signal.Signals) -> tuple[int, str]:
    """Exit code and what was said."""
    process.send_signal(number)
    output = process.communicate(timeout=60.0)[1]
    return process.returncode, output


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the moment is read from /proc")
@pytest.mark.parametrize(
    ("number", "code", "word"),
    [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")],
)
@pytest.mark.parametrize("delay", [0.0, 0.3, 2.0])
def test_a_signal_at_any_moment_ends_the_program_with_one_sentence(
    tmp_path: Path, number: signal.Signals, code: int, word: str, delay: float
) -> None:
    """While it imports, prepares, or simulates; the drive is so long that it never ends by itself."""
    long = ["run", "sine:duration=3000", "--cueing", "classical", "--out", "out/deep"]
    process = started(tmp_path, *long)
    time.sleep(delay)
    assert stopped(process, number) == (code, f"otolith: {word}; nothing half-written was left\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "then",
    [
        "time.sleep(60)",
        "raise RuntimeError('C failed of it')",
        "sys.excepthook(stop.Stopped, stop.Stopped(2), None); raise ImportError('C printed it first')",
    ],
)
def test_a_signal_that_is_lost_in_a_callback_of_c_is_heard_all_the_same(tmp_path: Path, then: str) -> None:
    """Python can only report an exception in a ctypes callback, as the compiler has some."""
    script = (
        "import ctypes, signal, sys, time\n"
        "from otolith.cli import app, main, stop\n"
        "def run(line=None):\n"
        "    ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))()\n"
        f"    {then}\n"
        "app.run_program = run\n"
        "main()\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
        preexec_fn=hearing,
    )
    assert (ended.returncode, ended.stderr) == (130, "otolith: interrupted; nothing half-written was left\n")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="POSIX only")
def test_while_results_are_written_the_old_ones_stay(tmp_path: Path) -> None:
    """The program waits, in the middle of writing a folder, for the signal."""
    script = (
        "import pathlib, sys, time\n"
        "from otolith import files\n"
        "from otolith.cli import app, main\n"
        "def write(line=None):\n"
        "    for text in ('old', 'new'):\n"
        "        with files.whole_folder(pathlib.Path('out'), command='run') as made:\n"
        "            files.write_text(made / 'run.h5', text)\n"
        "            if text == 'new':\n"
        "                print('now', flush=True)\n"
        "                time.sleep(60)\n"
        "app.run_program = write\n"
        "main()\n"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        preexec_fn=hearing,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "now\n"
    assert stopped(process, signal.SIGINT) == (130, "otolith: interrupted; nothing half-written was left\n")
    assert (tmp_path / "out" / "run.h5").read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["out"]
