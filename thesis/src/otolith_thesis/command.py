"""`otolith reproduce`: the thesis's tables, figures and readings next to ours."""

import time
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table as Grid

from otolith import __version__, files
from otolith.cli.output import Force, Jobs, described_bar, print_json, screen
from otolith.core.jobs import number_of_jobs
from otolith_thesis import CHAPTERS, Outcome, chosen, reproduce


def command(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="ITEM...",
            help=f"table-5.5, figure-5.7, study-circle, …; {', '.join(CHAPTERS)}; quick; or all.",
        ),
    ],
    out: Annotated[Path, typer.Option(help="Folder for the report.")] = Path("out/reproduced"),
    jobs: Jobs = None,
    force: Force = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Compute tables and figures of the thesis again, and put the published numbers next to ours."""
    processes = number_of_jobs(jobs)
    items = chosen(names)
    files.check_folder(out, command="reproduce", force=force)
    console = screen()
    began = time.monotonic()
    outcomes = _reproduced(items, processes, console)
    seconds = time.monotonic() - began
    edition = {"version": __version__, "date": datetime.now().astimezone().date().isoformat()}
    document = {**edition, "seconds": round(seconds, 1), "items": {o.name: o.as_json() for o in outcomes}}
    plain = _without_curves(document)
    from otolith_thesis.report.page import page

    with files.whole_folder(out, command="reproduce", force=force) as made:
        files.write_text(made / "report.html", page(document))
        files.write_json(made / "reproduced.json", plain)
    if json:
        print_json(plain)
    else:
        screen(stderr=False, wide=True).print(_grid(outcomes))
    console.print(
        f"written to {out}: report.html, reproduced.json; {seconds:.0f} s",
        highlight=False,
        soft_wrap=True,
    )


def _reproduced(items: Sequence[str], processes: int, console: Console) -> list[Outcome]:
    with described_bar(console, "beginning") as progress:
        return reproduce(items, processes=processes, progress=progress)


def _without_curves(document: dict[str, Any]) -> dict[str, Any]:
    """Return the document without the points of diagrams, which make it a hundred times as long."""
    items = {
        name: {key: value for key, value in item.items() if key != "panels"}
        for name, item in document["items"].items()
    }
    return {**document, "items": items}


def _grid(outcomes: Sequence[Outcome]) -> Grid:
    grid = Grid(title="Agreement with the thesis", title_justify="left")
    for name in ("item", "title", "within 2 %", "within 10 %", "same order", "differs", "conclusion"):
        grid.add_column(name, justify="left" if name in ("item", "title") else "right")
    for outcome in outcomes:
        counts = [str(count) for count in outcome.counts().values()] if outcome.numbers else [""] * 4
        holds = sum(claim.holds for claim in outcome.claims)
        claims = f"{holds} of {len(outcome.claims)}" if outcome.claims else ""
        grid.add_row(outcome.name, outcome.title, *counts, claims)
    return grid
