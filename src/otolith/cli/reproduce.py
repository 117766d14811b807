"""`otolith reproduce`: the thesis's tables beside ours."""

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table as Grid

from otolith import files
from otolith.cli.output import print_json, wide_console
from otolith.core.errors import InputError, one_of
from otolith.reproduce import TABLES, Table, reproduce


def reproduce_(
    names: Annotated[list[str], typer.Argument(metavar="TABLE...", help="table-5.2, table-c.1, … or all.")],
    out: Annotated[Path, typer.Option(help="Folder for tables.json.")] = Path("out/reproduced"),
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Compute tables of the thesis again and put the published numbers beside ours."""
    chosen = list(TABLES) if names == ["all"] else names
    for name in chosen:
        if name not in TABLES:
            raise InputError("TABLE", repr(name), one_of([*TABLES, "all"], name))
    console = Console(stderr=True)
    tables = [reproduce(name, lambda case, name=name: _tell(console, name, case)) for name in chosen]  # type: ignore[misc]
    as_json = {table.name: {"title": table.title, "rows": table.rows} for table in tables}
    files.write_json(out / "tables.json", as_json)
    if json:
        print_json(as_json)
    else:
        for table in tables:
            wide_console().print(_grid(table))
    console.print(f"written to {out / 'tables.json'}", highlight=False, soft_wrap=True)


def _tell(console: Console, name: str, case: str) -> None:
    console.print(f"{name}: {case}", highlight=False, soft_wrap=True)


def _grid(table: Table) -> Grid:
    keys = [key for key in dict.fromkeys(key for row in table.rows for key in row) if key != "tolerance"]
    grid = Grid(title=table.title, title_justify="left")
    for key in keys:
        grid.add_column(key.replace("_", " "), justify="right")
    for row in table.rows:
        grid.add_row(*(_cell(row.get(key)) for key in keys))
    return grid


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value)
