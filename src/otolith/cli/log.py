"""`otolith log`: show how a recorded drive is understood before it moves anything."""

import functools
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from otolith import files
from otolith.cli.output import group, print_json, screen
from otolith.cli.reading import Axes, Columns, Events, Header, MappingFile, Offsets, Units, log_settings
from otolith.recordings.checks.orientation import AXES
from otolith.recordings.settings import settings_to_toml

app = group("Recorded drives: see what is understood of a file, and save how it is read.")

LISTED = 12  # largest number of events, and of unused columns, that are named


@app.callback()
def log() -> None:
    """Recorded drives: see what is understood of a file, and save how it is read."""


@app.command("check")
def check(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="A recorded drive: CSV, JSON, ERG, MDF, ROS bag, lap.")
    ],
    column: Columns = None,
    header: Header = None,
    units: Units = None,
    axes: Axes = None,
    events: Events = None,
    offsets: Offsets = None,
    mapping: MappingFile = None,
    dofs: Annotated[
        str, typer.Option(help="What will be cued, as for 'otolith run': only that is required of the file.")
    ] = "",
    save_mapping: Annotated[
        Path | None, typer.Option(metavar="TOML", help="Write how the file is read, for --mapping.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="PICTURE", help="A .png, .pdf or .svg (default: out/FILE-check.png)."),
    ] = None,
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
    ] = False,
) -> None:
    """Show what is understood of a recorded drive: columns, axes, proofs, events; exit 2 if refused."""
    console = screen()
    chosen: dict[str, Any] = {
        "column": column,
        "header": header,
        "units": units,
        "axes": axes,
        "events": events,
    }
    chosen |= {"offsets": offsets, "mapping": mapping, "dofs": dofs}
    picture = out or Path("out") / f"{file.stem}-check.png"
    files.check_file(picture, *files.PICTURES)
    if save_mapping is not None:
        files.check_file(save_mapping, ".toml")
    understood = files.understand_log(file, log_settings(chosen))
    from otolith.report.drive_log import log_figure, log_summary
    from otolith.report.figures import save_figure

    summary = log_summary(understood)
    files.write_figure(picture, functools.partial(save_figure, log_figure(understood)))
    if json:
        print_json(summary)
    else:
        _print_summary(summary, screen(stderr=False, wide=True))
    if save_mapping is not None:
        files.write_text(save_mapping, settings_to_toml(understood.mapping(), file.name))
        console.print(f"mapping written to {save_mapping}", highlight=False, soft_wrap=True)
    console.print(f"picture written to {picture}", highlight=False, soft_wrap=True)
    if understood.refusal:
        console.print(
            f"otolith: {understood.refusal}", style="red", markup=False, highlight=False, soft_wrap=True
        )
        sys.exit(2)


def _print_summary(summary: dict[str, Any], console: Console) -> None:
    layout = summary["layout"]
    places = [("names", layout["names"]), ("units", layout["units"]), ("data from", layout["data_from"])]
    form = "; ".join([layout["form"], *(f"{what} {where}" for what, where in places if where)])
    length = "" if summary["duration_s"] is None else f", {summary['duration_s']:.6g} s"
    _print_line(console, f"{summary['file']}: {form}; {layout['rows']} rows{length}")
    _print_line(console, f"clock: {layout['clock'] or 'each channel its own'}")
    console.print(_channels(summary["channels"]))
    _print_line(console, f"axes: {_axes(summary)}")
    if summary["relations"]:
        console.print(_relations(summary["relations"]))
    for event in summary["events"][:LISTED]:
        doubt = "" if event["sure"] else ", which may be driving"
        times = f"from {event['start_s']:.5g} s to {event['end_s']:.5g} s"
        _print_line(console, f"event: {event['kind']} {times} ({event['size']}){doubt}")
    if len(summary["events"]) > LISTED:
        _print_line(console, f"and {len(summary['events']) - LISTED} more events, which --json lists")
    if layout["unused"]:
        more = f" and {len(layout['unused']) - LISTED} more" if len(layout["unused"]) > LISTED else ""
        _print_line(console, f"not used: {', '.join(layout['unused'][:LISTED])}{more}")
    for note in summary["notes"]:
        if note.split(":")[0] in {"t", *summary["channels"]} and ": column '" in note:
            continue  # the table says it
        _print_line(console, f"note: {note}", "yellow")
    _print_line(console, "accepted" if summary["accepted"] else "refused in its present form", "bold")


def _print_line(console: Console, line: str, style: str = "") -> None:
    console.print(Text(line, style=style), soft_wrap=True)


def _axes(summary: dict[str, Any]) -> str:
    if not summary["accepted"]:
        return "as the file writes them; nothing is turned in a drive that is refused"
    turned, proof = summary["axes"]["turned"], summary["axes"]["left_and_right_proven_by"]
    how = f"{', '.join(turned)} turned" if turned else "nothing turned"
    return f"{AXES['iso']}, {how}; left and right {f'proven by {proof}' if proof else 'not proven'}"


def _channels(channels: dict[str, Any]) -> Table:
    table = Table(box=None, pad_edge=False)
    numbers = ("Hz", "samples", "from [s]", "to [s]", "least", "most")
    for name in ("quantity", "column", "unit", "sign", *numbers, ""):
        right = name in numbers
        table.add_column(Text(name), justify="right" if right else "left")
    for key, one in channels.items():
        unit = one["unit"] if one["unit_stated"] else f"{one['unit']} (taken)"
        sign = "turned" if one["sign"] < 0 else ""
        values = [f"{one[k]:.4g}" for k in ("from_s", "to_s", "least", "most")]
        hertz = "" if one["rate_hz"] is None else f"{one['rate_hz']:.4g}"
        cells = [key, one["column"], unit, sign, hertz, str(one["samples"]), *values, one["si_unit"]]
        table.add_row(*map(Text, cells))
    return table


def _relations(relations: list[dict[str, Any]]) -> Table:
    table = Table(box=None, pad_edge=False)
    for name in ("proof", "against", "correlation", "slope", "windows", "verdict"):
        right = name in ("correlation", "slope", "windows")
        table.add_column(Text(name), justify="right" if right else "left")
    for one in relations:
        numbers = [f"{one['correlation']:.3f}", f"{one['slope']:.3f}", str(one["windows"])]
        table.add_row(*map(Text, [one["quantity"], one["with"], *numbers, one["verdict"]]))
    return table
