"""`otolith platform`: show a platform's legs, and find legs that have the reach of a data sheet."""

from pathlib import Path
from typing import Annotated, Final

import typer

from otolith import files
from otolith.cli.figures import write_figure
from otolith.cli.output import Force, group, print_json, progress_bar, screen
from otolith.cli.results import Figures
from otolith.core.errors import InputError, one_of
from otolith.platforms import Platform
from otolith.platforms.fit import as_toml, fit
from otolith.platforms.template import Name as TemplateName
from otolith.platforms.template import template

RIGS: Final[tuple[TemplateName, ...]] = ("cranks", "posts", "seat")
app = group("Begin a platform file, look at a platform, and fit legs to a data sheet.")

Name = Annotated[
    str, typer.Argument(metavar="PLATFORM", help="A shipped platform's name or a platform file (.toml).")
]
Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on standard output, nothing else there.")
]


@app.command("show")
def show(
    platform: Name,
    run: Annotated[Path | None, typer.Option(help="A run (run.h5) to show the platform move in.")] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results (default: out/platform-NAME).")
    ] = None,
    figures: Figures = False,
    force: Force = False,
    json: Json = False,
) -> None:
    """Draw a platform's legs, their reach, cuts across two axes and conditioning, as a page."""
    console = screen()
    shown = files.read_platform(platform)
    recorded = files.read_run(run) if run is not None else None
    if recorded is not None and (shown.hexapod is None or shown.hexapod.lent):
        bound = f"left out, for {shown.name} has no legs of its own to be moved"
        raise InputError("--run", "given", bound)
    folder = out or Path("out") / f"platform-{shown.name}"
    files.check_folder(folder, command="platform show", force=force)
    from otolith.report import platform_page as report

    summary, figure = report.platform_summary(shown), report.platform_figure(shown)
    with files.whole_folder(folder, command="platform show", force=force) as made:
        files.write_text(made / "platform.html", report.platform_page(shown, summary, figure, run=recorded))
        files.write_json(made / "platform.json", summary)
        if figures:
            write_figure(made, "platform", figure)
    if json:
        print_json(summary)
    for line in [*report.range_lines(summary), *report.sentences(summary)]:
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    console.print(f"written to {folder}: platform.html, platform.json", highlight=False, soft_wrap=True)


@app.command("new")
def new(
    legs: Annotated[bool, typer.Option("--legs", help="Of a machine that stands on six legs.")] = False,
    axes: Annotated[bool, typer.Option("--axes", help="Of a machine whose axes move one by one.")] = False,
    like: Annotated[
        str | None, typer.Option(metavar="NAME", help="Of a rig that people build: cranks, posts or seat.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to write (default: standard output).")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the file if there is one.")] = False,
) -> None:
    """Write a platform file to start from: each field explained, with numbers that load unchanged."""
    text = template(_template_of(legs=legs, axes=axes, like=like))
    if out is None:
        typer.echo(text, nl=False)
        return
    files.check_file(out, ".toml")
    if out.exists() and not force:
        raise InputError(f"file {out}", "there already", "another one, or --force")
    files.write_text(out, text)
    message = f"written to {out}: fill in your numbers, then otolith platform show {out}"
    screen().print(message, markup=False, highlight=False, soft_wrap=True)


def _template_of(*, legs: bool, axes: bool, like: str | None) -> TemplateName:
    """Return the name of the one template that is asked for."""
    if legs + axes + (like is not None) != 1:
        found = "missing" if like is None and not legs and not axes else "more than one given"
        raise InputError("--legs, --axes, --like", found, "one of the three")
    if like is None:
        return "legs" if legs else "axes"
    for name in RIGS:
        if name == like:
            return name
    raise InputError("--like", repr(like), one_of(RIGS, like))


@app.command("fit")
def fit_(
    platform: Name,
    leg: Annotated[
        str | None,
        typer.Option(metavar="SHORTEST,LONGEST", help="Lengths of a leg [m] (default: those of the file)."),
    ] = None,
    starts: Annotated[int, typer.Option(min=1, max=10_000, help="Random starts of the search.")] = 60,
    seed: Annotated[int, typer.Option(min=0, help="Of the random starts; equal seeds, equal answers.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="File for the geometry (default: standard output).")
    ] = None,
    json: Json = False,
) -> None:
    """Find legs that reach what the platform's file says of each axis alone. One of many answers."""
    console = screen()
    wanted = files.read_platform(platform)
    if out is not None:
        files.check_file(out)
    stroke = _stroke(leg) if leg is not None else _own_stroke(wanted)
    with progress_bar(console, f"fitting {wanted.name}") as progress:
        result = fit(wanted, stroke, starts=starts, seed=seed, progress=progress)
    text, best = as_toml(result, stroke), result.best
    if out is not None:
        files.write_text(out, text)
    if json:
        print_json(
            {
                "worst": best.worst,
                "errors": {axis: list(ends) for axis, ends in best.errors.items()},
                "condition": best.condition,
                "alike": len(result.alike),
                "starts": result.starts,
                "base_radius_m": [candidate.circles.base_radius_m for candidate in result.alike],
                "toml": text,
            }
        )
    elif out is None:
        typer.echo(text, nl=False)
    console.print(
        f"worst end {100 * best.worst:.2f} % off, condition number {best.condition:.2f}; one of many: "
        f"{len(result.alike)} of {starts} starts came as near within 1 %",
        highlight=False,
        soft_wrap=True,
    )


def _own_stroke(wanted: Platform) -> tuple[float, float]:
    """Return the lengths [m] of a platform's linear legs."""
    hexapod = wanted.six_legs()
    if hexapod.cranks is not None:
        bound = f"given: {wanted.name} is on cranks, and linear legs are what is fitted"
        raise InputError("--leg", "missing", bound)
    return hexapod.stroke


def _stroke(text: str) -> tuple[float, float]:
    parts = text.split(",")
    try:
        low, high = (float(part) for part in parts)
    except ValueError:
        raise InputError("--leg", repr(text), "SHORTEST,LONGEST in m, as in 1.297,1.937") from None
    if not 0.05 <= low < high <= 20.0:
        raise InputError("--leg", repr(text), "two lengths between 0.05 and 20 m, the shorter first")
    return low, high
