"""What commands print."""

import json
import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bars

from otolith.metrics import between_nodes, breaches, failures
from otolith.mpqp import Progress


def print_json(value: object) -> None:
    """One JSON object on standard output; NaN and infinity would not be JSON and are refused."""
    sys.stdout.write(json.dumps(value, indent=2, allow_nan=False) + "\n")


def wide_console(*, stderr: bool = False) -> Console:
    """A console of at least 120 columns: a table that is cut is no table."""
    console = Console(stderr=stderr)
    console.width = max(console.width, 120)
    return console


@contextmanager
def progress_bar(console: Console, text: str) -> Iterator[Any]:
    """Show a bar with an estimate on standard error; yields what to call with the fraction done."""
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn())
    with Bars(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(text, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)


def progress_line(now: Progress) -> str:
    """How far an enumeration is."""
    rate = now.regions / max(now.seconds, 1e-9)
    return f"{now.regions} regions, {now.open} sets to examine, {rate:.0f} regions/s, {now.seconds:.1f} s"


def sentence(summary: dict[str, Any]) -> str:
    """One run in one line: its key figures, every decision that failed, every limit that was passed."""
    changes, micro = summary["changes"], summary["step_time_us"]
    errors = [] if summary["rmse"] is None else [f"{summary['rmse']:.4f} m/s²"]
    errors += [
        f"{axis} {math.degrees(error):.3f} deg/s" for axis, error in summary.get("rate_rmse", {}).items()
    ]
    figures = (
        f"{summary['cueing']} on {summary['scenario']}: RMSE {', '.join(errors)}, "
        f"changes {changes['mean']:.2f} mean / {changes['p99']:.0f} p99 / {changes['max']:.0f} max, "
        f"step {micro['median']:.0f} us median"
    )
    failed, passed = failures(summary), breaches(summary)
    said = [*(failed or ["no decision failed"]), *(passed or ["all limits kept at every node"])]
    return "; ".join([figures, *said, *between_nodes(summary)])
