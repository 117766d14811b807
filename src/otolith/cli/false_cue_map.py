"""`otolith map`: where along a recorded drive the simulator's driver was misled."""

from pathlib import Path
from typing import Annotated, Any, Final

import numpy as np
import typer
from rich.table import Table

from otolith import files
from otolith.cli.output import print_json, screen
from otolith.core.arrays import Mat
from otolith.core.errors import InputError
from otolith.experiment import Wanted
from otolith.loop import Run
from otolith.metrics.false_cues import THRESHOLD, FalseCue, false_cues
from otolith.recordings import Log

WORST: Final = 10  # number of false cues in the table


def map_(
    run: Annotated[Path, typer.Argument(metavar="RUN.H5", help="A run of a recorded drive.")],
    log: Annotated[
        Path | None, typer.Option(help="The drive, if it is no longer where the run found it.")
    ] = None,
    threshold: Annotated[
        float, typer.Option(help="Least mismatch that counts as a false cue [m/s²].")
    ] = THRESHOLD,
    out: Annotated[Path | None, typer.Option(help="Figure (default: map.png next to the run).")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Show false cues on the map of the drive, and where the worst of them are."""
    with files.open_run(run) as result:
        drive = _drive(result, log)
        cues = sorted(false_cues(result, threshold=threshold), key=lambda cue: -cue.integral)
    picture = out or run.with_name("map.png")
    files.check_file(picture, *files.PICTURES)
    from otolith.report.figures import save_figure
    from otolith.report.lap import Marked, false_cue_map

    marks = [Marked(cue.kind, cue.start, cue.end) for cue in cues]
    figure = false_cue_map(drive.t, _place(drive), marks, numbered=WORST)
    files.write_figure(picture, lambda temporary: save_figure(figure, temporary))
    files.enlist(picture)  # next to the run, it counts as one of its results
    found = located(cues, drive)
    if json:
        print_json({"run": str(run), "threshold_mps2": threshold, "false_cues": found})
    console = screen(wide=True)
    console.print(_table(found), markup=False)
    console.print(f"{len(found)} false cues; map written to {picture}", highlight=False, soft_wrap=True)


def located(cues: list[FalseCue], drive: Log) -> list[dict[str, Any]]:
    """Return false cues with the distance along the path [m] and the position [m] where each begins."""
    place = _place(drive)
    way = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(place, axis=0), axis=1))]
    return [
        {
            "dof": cue.dof,
            "kind": cue.kind,
            "start_s": cue.start,
            "duration_s": cue.duration,
            "peak_mps2": cue.peak,
            "integral_mps": cue.integral,
            "way_m": float(np.interp(cue.start, drive.t, way)),
            "x_m": float(np.interp(cue.start, drive.t, place[:, 0])),
            "y_m": float(np.interp(cue.start, drive.t, place[:, 1])),
        }
        for cue in cues
    ]


def _drive(run: Run, log: Path | None) -> Log:
    """Read the drive from which the run was made, in the same way as the run did."""
    if "wanted" not in run.settings:
        return Wanted(log=log).drive()
    return Wanted.from_record(run.settings["wanted"], log=log, check=log is None).drive()


def _place(drive: Log) -> Mat:
    if drive.place is None:
        raise InputError(f"place of {drive.source}", "missing", "in columns such as x_m and y_m for a map")
    return drive.place


def _table(found: list[dict[str, Any]]) -> Table:
    table = Table(box=None, pad_edge=False)
    for name in ("", "at [m]", "at [s]", "for [s]", "axis", "kind", "peak [m/s²]", "integral [m/s]"):
        table.add_column(name, justify="left" if name in ("axis", "kind") else "right")
    for number, cue in enumerate(found[:WORST], 1):
        numbers = [f"{cue['way_m']:.0f}", f"{cue['start_s']:.1f}", f"{cue['duration_s']:.2f}"]
        graver = [f"{cue['peak_mps2']:.2f}", f"{cue['integral_mps']:.2f}"]
        table.add_row(str(number), *numbers, cue["dof"], cue["kind"], *graver)
    return table
