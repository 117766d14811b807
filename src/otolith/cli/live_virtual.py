"""`otolith live faults` and `live bench`: live operation in virtual time."""

from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from otolith import files, registry
from otolith.cli.options import CUEING_HELP, Dofs, PlatformName
from otolith.cli.output import print_json, progress_bar, screen, working
from otolith.core.errors import InputError
from otolith.core.frames import dofs_named
from otolith.cueing.design import Design
from otolith.interfaces import Cueing, PlatformState, Reference
from otolith.platforms import Platform
from otolith.platforms.machines import check_machine

CueingName = Annotated[str, typer.Option(help=CUEING_HELP)]
Tuning = Annotated[
    str | None,
    typer.Option(help="Tuning of a conventional washout: a name or a file (default: the platform's)."),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")]


def faults(
    rows: Annotated[
        list[str] | None, typer.Argument(metavar="[ROW]...", help="Rows to play, e.g. 2 8 13 (default: all).")
    ] = None,
    cueing: CueingName = "predictive",
    platform: PlatformName = "davsi-4dof",
    dofs: Dofs = "surge-pitch,sway-roll",
    tuning: Tuning = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the chances in the virtual world.")] = 0,
    json: Json = False,
) -> None:
    """Play the matrix of faults in virtual time, and say what followed; exit code 1 if anything is wrong."""
    from otolith.live.faults import CASES, ROWS, row_of, run_matrix

    chosen = tuple(case for case in CASES if not rows or any(_is_of(case.row, row) for row in rows))
    if not chosen:
        raise InputError("ROW", " ".join(rows or []), "numbers of the matrix, e.g. 2 or 13")
    algorithm, machine = prepared(cueing, platform, dofs, tuning)
    console = screen()
    results = []
    with progress_bar(console, "playing faults") as bar:
        for result in run_matrix(algorithm, machine, chosen, seed=seed):
            results.append(result)
            bar(len(results) / len(chosen))
    wrong = [result for result in results if not result.right]
    if json:
        print_json(
            {
                "cases": [
                    {
                        "row": result.case.row,
                        "fault": result.case.fault,
                        "expected": result.case.expected,
                        "seen": result.seen,
                        "right": result.right,
                    }
                    for result in results
                ],
                "wrong": len(wrong),
            }
        )
    else:
        _show(results)
    played = len({row_of(result.case) for result in results})
    console.print(
        f"{len(results) - len(wrong)} of {len(results)} as expected, of {played} of {ROWS} rows",
        highlight=False,
    )
    if wrong:
        raise typer.Exit(1)


def _is_of(row: str, asked: str) -> bool:
    """Return whether a row of the matrix is the one asked for, or a part of it: 13 has 13b and 13.8000."""
    return row == asked or (row.startswith(asked) and not row[len(asked)].isdigit())


def _show(results: list[Any]) -> None:
    table = Table(box=None, pad_edge=False)
    for column in ("row", "fault", "expected", "seen", "", "s"):
        table.add_column(column, overflow="fold")
    for result in results:
        table.add_row(
            result.case.row,
            result.case.fault,
            result.case.expected,
            result.seen,
            "ok" if result.right else "WRONG",
            f"{result.seconds:.1f}",
        )
    screen(stderr=False, wide=True).print(table)


def machine_named(platform: str, dofs: str) -> Platform:
    """Return a platform that may be driven, and that has the degrees of freedom.

    Raises
    ------
    InputError : it is the profile `thesis`, or lacks one.
    """
    machine = files.read_platform(platform)
    check_machine(machine, "--platform")
    for dof in dofs_named(dofs.split(",")):
        machine.limits(dof)
    return machine


def prepared(cueing: str, platform: str, dofs: str, tuning: str | None) -> tuple[Cueing, Platform]:
    """Return an algorithm that has decided once, so that all is compiled, and its platform."""
    from otolith.cueing.washout.tuning import load_tuning

    machine = machine_named(platform, dofs)
    washout = None if tuning is None else load_tuning(tuning)
    design = Design(platform=machine, dofs=dofs_named(dofs.split(",")), washout=washout)
    with working(screen(), "compiling what is not cached, up to a minute"):
        algorithm = registry.make_cueing(cueing, design)
        algorithm.reset(PlatformState())
        algorithm.step(PlatformState(), Reference(specific_force=np.zeros(3)))
    return algorithm, machine
