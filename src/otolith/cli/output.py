"""What commands print."""

import json
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, Final, Protocol

import typer
from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bars
from rich.text import Text

if TYPE_CHECKING:
    from otolith.mpqp import Progress

_REPLACE: Final = "Replace an existing folder with all that it holds, also what this command did not write."
Force = Annotated[bool, typer.Option("--force", "--replace", help=_REPLACE)]
Replace = Annotated[bool, typer.Option("--replace", help=_REPLACE)]  # where --force is a force
EVERY: Final = 10.0  # [s] between lines about progress where there is no terminal


class Tell(Protocol):
    """Takes the text of the moment and, where it is known, the fraction done."""

    def __call__(self, text: str, fraction: float | None = None) -> None:
        """Keep both for the next line."""


def group(about: str) -> typer.Typer:
    """A group of commands, whose texts are shown as they are written: to rich, [km/h] would be markup."""
    return typer.Typer(help=about, no_args_is_help=True, rich_markup_mode=None)


def file_name(text: str) -> str:
    """A name as part of a path: nothing but letters, digits, dot, dash and underscore."""
    return re.sub(r"[^\w.-]+", "_", text).strip("._") or "unnamed"


def print_json(value: object) -> None:
    """One JSON object on standard output; NaN and infinity would not be JSON and are refused."""
    sys.stdout.write(json.dumps(value, indent=2, allow_nan=False) + "\n")


def screen(*, stderr: bool = True, wide: bool = False) -> Console:
    """A console that prints texts as they are: brackets are units and not markup, numbers keep their colour.

    `wide` makes it at least 120 columns: a table that is cut is no table.
    """
    made = Console(stderr=stderr, markup=False, highlight=False, emoji=False)
    if wide:
        made.width = max(made.width, 120)
    return made


@contextmanager
def progress_bar(console: Console, text: str) -> Iterator[Callable[[float], None]]:
    """Show on standard error how far a long work is, with an estimate of the time that is left.

    On a terminal this is a bar; elsewhere a line every 10 s. Yields what to call with the fraction done.
    """
    if not console.is_terminal:
        with lines(console, text) as tell:
            yield lambda fraction: tell(text, fraction)
        return
    with _bars(console) as bar:
        task = bar.add_task(text, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)


@contextmanager
def working(console: Console, text: str) -> Iterator[Callable[[str], None]]:
    """As `progress_bar` for work of unknown length: a spinner, or a line every 10 s with the time passed.

    Yields what to call with the text of the moment.
    """
    if not console.is_terminal:
        with lines(console, text) as tell:
            yield tell
        return
    with console.status(Text(text)) as status:
        yield lambda now: status.update(Text(now))


@contextmanager
def described_bar(console: Console, text: str) -> Iterator[Callable[[str, float], None]]:
    """As `progress_bar`, where the text changes with the work: call with both."""
    if not console.is_terminal:
        with lines(console, text) as tell:
            yield tell
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
) -> Iterator[Tell]:
    """Print a line every so many seconds, from a thread of its own, with the latest report.

    Parameters
    ----------
    every : seconds between lines; work that is done sooner prints none.
    now : clock [s].
    """
    told: tuple[str, float | None] = (text, None)
    began, done = now(), threading.Event()

    def tell(text: str, fraction: float | None = None) -> None:
        nonlocal told
        told = (text, fraction)

    def print_lines() -> None:
        while not done.wait(every):
            console.print(_progress_sentence(*told, now() - began), soft_wrap=True)

    printer = threading.Thread(target=print_lines, daemon=True)
    printer.start()
    try:
        yield tell
    finally:
        done.set()
        printer.join()


def _progress_sentence(text: str, fraction: float | None, seconds: float) -> str:
    """What is done, how far, and how long it will take if it goes on as it went."""
    if not fraction:
        return f"{text}; {seconds:.0f} s so far"
    left = seconds * (1.0 - fraction) / fraction
    return f"{text}: {100.0 * fraction:.0f} %, {seconds:.0f} s so far, about {left:.0f} s left"


def progress_line(now: "Progress") -> str:
    """How far an enumeration is."""
    rate = now.regions / max(now.seconds, 1e-9)
    return f"{now.regions} regions, {now.open} sets to examine, {rate:.0f} regions/s, {now.seconds:.1f} s"


def sentence(summary: dict[str, Any]) -> str:
    """One run in one line: its key figures, every decision that failed, every limit that was passed."""
    from otolith.metrics import MEASURES, between_nodes, breaches, failures

    known = [(measure.line, summary.get(measure.name)) for measure in MEASURES.values()]
    figures = ", ".join(line(value) for line, value in known if line is not None and value is not None)
    failed, passed = failures(summary), breaches(summary)
    said = [*(failed or ["no decision failed"]), *(passed or ["all limits kept at every node"])]
    return "; ".join(
        [f"{summary['cueing']} on {summary['scenario']}: {figures}", *said, *between_nodes(summary)]
    )
