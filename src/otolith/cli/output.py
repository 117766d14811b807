"""The output of commands: progress, notes, JSON and summary lines."""

import json
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, TYPE_CHECKING, Annotated, Any, Final, Protocol

import typer
from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bars
from rich.text import Text

if TYPE_CHECKING:
    from otolith.mpqp import Progress

_REPLACE: Final = "Replace an existing folder with all that it holds, also what this command did not write."
Force = Annotated[bool, typer.Option("--force", "--replace", help=_REPLACE)]
Jobs = Annotated[
    int | None,
    typer.Option("--jobs", help="Processes that work at once; 1: this one (default: as many as help)."),
]
Replace = Annotated[bool, typer.Option("--replace", help=_REPLACE)]  # for a command whose --force is a force
EVERY: Final = 10.0  # [s] between progress lines if there is no terminal


class OnProgress(Protocol):
    """Receives the current text and, if it is known, the fraction done."""

    def __call__(self, text: str, fraction: float | None = None) -> None:
        """Keep both for the next line of progress."""


def group(about: str) -> typer.Typer:
    """Return a group of commands whose texts are shown literally; rich would interpret [km/h] as markup."""
    return typer.Typer(help=about, no_args_is_help=True, rich_markup_mode=None)


def file_name(text: str) -> str:
    """Turn a name into a part of a path: only letters, digits, dot, dash and underscore remain."""
    return re.sub(r"[^\w.-]+", "_", text).strip("._") or "unnamed"


def print_json(value: object) -> None:
    """Print one JSON object on standard output; NaN and infinity are refused, as JSON requires."""
    sys.stdout.write(json.dumps(value, indent=2, allow_nan=False) + "\n")


def screen(*, stderr: bool = True, wide: bool = False, file: IO[str] | None = None) -> Console:
    """Return a console that prints texts literally: brackets are units and not markup.

    Parameters
    ----------
    wide : whether it has at least 120 columns, so that a wide table is not cut.
    file : where it prints to, in place of the terminal.
    """
    made = Console(stderr=stderr, file=file, markup=False, highlight=False, emoji=False)
    if wide:
        made.width = max(made.width, 120)
    return made


def warn(console: Console, note: str) -> None:
    """Print a note that the user should know but need not act on."""
    console.print(f"note: {note}", style="yellow", markup=False, highlight=False, soft_wrap=True)


@contextmanager
def progress_bar(console: Console, text: str) -> Iterator[Callable[[float], None]]:
    """Show on standard error how far a long task is, with an estimate of the remaining time.

    On a terminal this is a bar, otherwise a line every 10 s. Yields a function to call with the fraction
    done.
    """
    if not console.is_terminal:
        with lines(console, text) as progress:
            yield lambda fraction: progress(text, fraction)
        return
    with _bars(console) as bar:
        task = bar.add_task(text, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)


@contextmanager
def working(console: Console, text: str) -> Iterator[Callable[[str], None]]:
    """Show on standard error that a task of unknown length is running.

    On a terminal this is a spinner, otherwise a line every 10 s with the time spent. Yields a function to
    call with the current text.
    """
    if not console.is_terminal:
        with lines(console, text) as progress:
            yield progress
        return
    with console.status(Text(text)) as status:
        yield lambda now: status.update(Text(now))


@contextmanager
def described_bar(console: Console, text: str) -> Iterator[Callable[[str, float], None]]:
    """Show progress as `progress_bar` does, with a text that changes.

    Yields a function to call with the current text and the fraction done.
    """
    if not console.is_terminal:
        with lines(console, text) as progress:
            yield progress
        return
    with _bars(console) as bar:
        task = bar.add_task(text, total=1.0)
        yield lambda now, fraction: bar.update(task, completed=fraction, description=now)


def _bars(console: Console) -> Bars:
    text = TextColumn("{task.description}", markup=False)
    return Bars(
        text, BarColumn(), TaskProgressColumn(), TimeRemainingColumn(), console=console, transient=True
    )


@contextmanager
def lines(
    console: Console, text: str, *, every: float = EVERY, now: Callable[[], float] = time.monotonic
) -> Iterator[OnProgress]:
    """Print a line of progress at regular intervals, from a separate thread, with the latest report.

    Parameters
    ----------
    every : seconds between lines; shorter tasks print none.
    now : clock [s].
    """
    latest: tuple[str, float | None] = (text, None)
    began, done = now(), threading.Event()

    def progress(text: str, fraction: float | None = None) -> None:
        nonlocal latest
        latest = (text, fraction)

    def print_lines() -> None:
        while not done.wait(every):
            console.print(_progress_sentence(*latest, now() - began), soft_wrap=True)

    printer = threading.Thread(target=print_lines, daemon=True)
    printer.start()
    try:
        yield progress
    finally:
        done.set()
        printer.join()


def _progress_sentence(text: str, fraction: float | None, seconds: float) -> str:
    """Return the task, how far it is, and the remaining time at the same rate."""
    if not fraction:
        return f"{text}; {seconds:.0f} s so far"
    left = seconds * (1.0 - fraction) / fraction
    return f"{text}: {100.0 * fraction:.0f} %, {seconds:.0f} s so far, about {left:.0f} s left"


def progress_line(now: "Progress", *, after: str = "") -> str:
    """Return how far an enumeration is, or the text `after` once it is done and other work goes on."""
    if after and not now.open:
        return after
    rate = now.regions / max(now.seconds, 1e-9)
    found = f"{now.regions} regions, {now.open} sets to examine"
    return f"explicit law: {found}, {rate:.0f} regions/s, {now.seconds:.1f} s"


def sentence(summary: dict[str, Any]) -> str:
    """Summarise one run in one line: its key figures, failed decisions and passed limits."""
    from otolith.metrics import MEASURES, best_in_words, between_nodes, breaches, failures

    known = [(measure.line, summary.get(measure.name)) for measure in MEASURES.values()]
    figures = ", ".join(line(value) for line, value in known if line is not None and value is not None)
    failed, passed = failures(summary), breaches(summary)
    verdicts = [*(failed or ["no decision failed"]), *(passed or ["all limits kept at every node"])]
    best = [best_in_words(summary)] if "times" in summary.get("optimum", {}) else []
    return "; ".join(
        [
            f"{summary['cueing']} on {summary['scenario']}: {figures}",
            *best,
            *verdicts,
            *between_nodes(summary),
        ]
    )
