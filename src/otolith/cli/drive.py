"""`otolith drive`: drive a road with a virtual car, and write what its driver felt."""

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from otolith import files
from otolith.cli.output import print_json, screen, warn, working
from otolith.core.errors import InputError
from otolith.vehicle import Driver, drive
from otolith.vehicle.profile import Limits
from otolith.vehicle.roughness import roughened

_DEFAULTS = Limits()


def drive_(
    road: Annotated[
        str, typer.Argument(metavar="ROAD", help="A name of 'otolith list roads', or points (.csv, .gpx).")
    ],
    speed: Annotated[float, typer.Option(metavar="KMH", help="No faster than this [km/h].")] = 120.0,
    standing: Annotated[
        bool, typer.Option("--standing", help="Start from rest (default: flying, at the planned speed).")
    ] = False,
    car: Annotated[str, typer.Option(help="A shipped car's name or a car file (.toml).")] = "tesla-model-s",
    accelerate: Annotated[float, typer.Option(help="The driver's limit [m/s²].")] = _DEFAULTS.drive,
    brake: Annotated[float, typer.Option(help="The driver's limit [m/s²].")] = _DEFAULTS.brake,
    lateral: Annotated[float, typer.Option(help="The driver's limit [m/s²].")] = _DEFAULTS.lateral,
    gg: Annotated[
        float, typer.Option(help="How limits combine: 1 diamond, 2 ellipse, large: rectangle.")
    ] = _DEFAULTS.exponent,
    smoothing: Annotated[
        float | None,
        typer.Option(
            metavar="METRES",
            help="How far the road may keep from a file's points (RMS; default: 0.1 m, or as they scatter).",
        ),
    ] = None,
    closed: Annotated[
        bool | None,
        typer.Option("--closed/--open", help="Whether a file's road is a ring (default: found out)."),
    ] = None,
    roughness: Annotated[
        str | None, typer.Option(help="Road surface of ISO 8608, A (good) to E (default: smooth).")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the road surface.")] = 0,
    rate: Annotated[
        float,
        typer.Option(metavar="HZ", help="Samples of the record in a second: 1000 or a whole fraction of it."),
    ] = 100.0,
    out: Annotated[
        Path | None, typer.Option(help="File for the drive, .csv or .h5 (default: out/ROAD-KMH.csv).")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object on standard output.")] = False,
) -> None:
    """Drive a road and write specific force, rates and pose, with a map; `otolith run --log` cues it."""
    console = screen()
    if not 1.0 <= speed <= 500.0:
        raise InputError("--speed", f"{speed:g} km/h", "between 1 and 500 km/h")
    limits = Limits(drive=accelerate, brake=brake, lateral=lateral, exponent=gg)
    if smoothing is not None and not 0.0 <= smoothing <= 20.0:
        raise InputError("--smoothing", f"{smoothing:g} m", "between 0 and 20 m")
    way = files.read_road(road, smoothing=smoothing, closed=closed)
    for note in way.notes:
        warn(console, f"{way.source}: {note}")
    if roughness is not None:
        way = roughened(way, roughness, np.random.default_rng(seed))
    path = out or Path("out") / f"{way.name}-{speed:g}.csv"
    files.check_file(path, ".csv", ".h5")
    with working(console, "driving; the car is compiled on first use (10 to 20 s), then cached"):
        lap = drive(
            way.limited(speed / 3.6),
            files.read_car(car),
            Driver(limits=limits),
            standing=standing,
            rate_hz=rate,
        )
    from otolith.report.figures import save_figure
    from otolith.report.lap import lap_figure

    summary = lap.summary(limits)
    files.write_lap(lap, path)
    picture = path.with_name(f"{path.stem}-map.png")
    files.write_figure(picture, lambda temporary: save_figure(lap_figure(lap), temporary))
    if json:
        print_json(summary)
    console.print(_sentence(summary), highlight=False, soft_wrap=True)
    console.print(f"written to {path}, map in {picture.name}", highlight=False, soft_wrap=True)


def _sentence(summary: dict[str, Any]) -> str:
    """Return the key figures of a drive in one line."""
    ax, ay = summary["ax_mps2"], summary["ay_mps2"]
    excess = max(summary["limit_excess_percent"].values())
    return (
        f"{summary['road']}: {summary['length_m']:.0f} m in {summary['time_s']:.1f} s, "
        f"a_x {ax['min']:.2f} to {ax['max']:.2f}, a_y {ay['min']:.2f} to {ay['max']:.2f} m/s², "
        f"limits exceeded by {excess:.1f} %"
    )
