"""Progress is told on a terminal and without one; an estimate follows from the fraction done."""

import io
import time

from rich.console import Console

from otolith.cli.output import _progress_sentence, lines, progress_bar, progress_line, screen, working
from otolith.mpqp.enumerate import Progress


def awaited(console: Console, text: str, seconds: float = 20.0) -> list[str]:
    """The lines that were printed when one of them holds the text, or when the time is up."""
    end = time.monotonic() + seconds
    file = console.file
    assert isinstance(file, io.StringIO)
    while time.monotonic() < end and "\n" not in file.getvalue():
        time.sleep(0.001)
    return file.getvalue().splitlines()


def test_without_a_terminal_a_line_comes_every_few_seconds_with_an_estimate() -> None:
    clock = iter([0.0, *[20.0] * 10_000])
    console = screen()
    console.file = io.StringIO()
    with lines(console, "hybrid-all on [1]", every=0.01, now=lambda: next(clock)) as progress:
        progress("hybrid-all on [1]", 0.25)
        line = awaited(console, "25 %")
    assert "hybrid-all on [1]: 25 %, 20 s so far, about 60 s left" in line


def test_what_is_unknown_is_not_estimated() -> None:
    assert _progress_sentence("preparing", None, 12.3) == "preparing; 12 s so far"
    assert _progress_sentence("running", 0.0, 12.3) == "running; 12 s so far"


def test_an_enumeration_that_is_done_is_not_told_while_other_work_goes_on() -> None:
    """A first run compiles for a minute after the law is there; "0 sets to examine" looked like a hang."""
    under_way, done = Progress(regions=30, open=4, seconds=0.5), Progress(regions=90, open=0, seconds=1.5)
    text = "explicit law: 30 regions, 4 sets to examine, 60 regions/s, 0.5 s"
    assert progress_line(under_way, after="compiling") == text
    assert progress_line(done, after="compiling") == "compiling"
    assert progress_line(done) == "explicit law: 90 regions, 0 sets to examine, 60 regions/s, 1.5 s"


def test_short_work_says_nothing_and_its_thread_ends_with_it() -> None:
    console = screen()
    console.file = io.StringIO()
    with progress_bar(console, "quick") as progress:
        progress(0.5)
    with working(console, "quick") as progress:
        progress("quicker")
    assert console.file.getvalue() == ""


def test_a_terminal_shows_a_bar() -> None:
    console = Console(file=io.StringIO(), force_terminal=True, width=80)
    with progress_bar(console, "cueing [m/s]") as progress:
        progress(0.5)
    assert "cueing [m/s]" in console.file.getvalue()  # type: ignore[attr-defined]
