"""Every file that Otolith reads and writes, by what it holds: platforms, roads, logs, runs, laws, reports.

What is written appears whole or not at all. What is read is bounded in size and checked before it is used.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from otolith.core.disk import TABLE_BYTES, read_text, whole, write_text
from otolith.core.errors import CorruptFile, InputError, one_of
from otolith.core.folders import PICTURES, check_file, check_folder, enlist, whole_folder
from otolith.core.hdf5 import read_sealed, write_sealed
from otolith.platforms import catalog, load
from otolith.recordings.settings import PLAIN, LogSettings, settings_from_toml
from otolith.sealed import (
    read_hint,
    read_laws,
    read_sets,
    write_hint,
    write_laws,
    write_sets,
)
from otolith.stored import RunFile, open_run, read_run, run_file, write_run

if TYPE_CHECKING:  # what a file holds is imported on use: no command reads files of every kind
    from otolith.cueing.washout.tuning import Tuning
    from otolith.platforms import Platform
    from otolith.recordings import Log
    from otolith.recordings.recorded import Columns, Recorded, Signal
    from otolith.recordings.understanding import Understanding
    from otolith.vehicle import Car, Lap, Road

__all__ = [
    "PICTURES",
    "RunFile",
    "check_file",
    "check_folder",
    "enlist",
    "open_run",
    "read_car",
    "read_hint",
    "read_laws",
    "read_log",
    "read_platform",
    "read_road",
    "read_run",
    "read_sets",
    "read_text",
    "read_tuning",
    "run_file",
    "whole",
    "whole_folder",
    "write_figure",
    "write_hint",
    "write_json",
    "write_lap",
    "write_laws",
    "write_run",
    "write_sets",
    "write_tables",
    "write_text",
]

LAP_KIND, LAP_VERSION = "otolith-lap", 2
TABLES_KIND, TABLES_VERSION = "otolith-tables", 1


def read_platform(name_or_path: str) -> "Platform":
    """Read a shipped platform by name, or a platform file by its path."""
    if name_or_path in catalog():
        return load(name_or_path)
    path = Path(name_or_path)
    if path.suffix != ".toml" and not path.exists():
        raise InputError("platform", repr(name_or_path), "a .toml file or " + one_of(catalog(), name_or_path))
    from otolith.platforms import parse_platform

    return parse_platform(read_text(path, "platform"), path.name)


def read_road(text: str, *, smoothing: float | None = None, closed: bool | None = None) -> "Road":
    """Read a shipped road by name and parameters, or a centreline (.csv, .txt, .tsv) or GPX file by path.

    `smoothing` and `closed` are those of `otolith.vehicle.centreline.road_through`.

    Raises
    ------
    InputError : no such road or file, or one of the two options for a road that is none of a file.
    """
    from otolith.vehicle import parse_centreline, parse_gpx, road

    path = Path(text)
    ending = path.suffix.lower()
    if ending == ".gpx":
        return parse_gpx(
            read_text(path, "GPX file", most=TABLE_BYTES), path.name, smoothing=smoothing, closed=closed
        )
    if ending in (".csv", ".txt", ".tsv"):
        return parse_centreline(
            read_text(path, "centreline", most=TABLE_BYTES), path.name, smoothing=smoothing, closed=closed
        )
    for option, value in (("--smoothing", smoothing), ("--closed or --open", closed)):
        if value is not None:
            raise InputError(option, "given", f"left out, for {text!r} is not a file of points")
    return road(text)


def read_car(name_or_path: str) -> "Car":
    """Read a shipped car by name, or a car file by its path."""
    from otolith.vehicle import load_car, parse_car

    path = Path(name_or_path)
    if path.suffix != ".toml":
        return load_car(name_or_path)
    return parse_car(read_text(path, "car"), path.name)


def write_lap(lap: "Lap", path: Path) -> None:
    """Store a drive as CSV, or as HDF5 with one data set per column; `read_log` reads either."""
    from otolith.vehicle.lap import COLUMNS

    check_file(path, ".csv", ".h5")
    data = lap.columns()
    if path.suffix.lower() == ".csv":
        with whole(path) as temporary:
            np.savetxt(temporary, data, fmt="%.9g", delimiter=",", header=",".join(COLUMNS), comments="")
        return
    attributes = {"road": lap.road.name, "source": lap.road.source, "car": lap.car.model_dump_json()}
    columns = dict(zip(COLUMNS, data.T, strict=True))
    write_sealed(path, attributes, columns, kind=LAP_KIND, version=LAP_VERSION)


def read_tuning(name_or_path: str) -> "Tuning":
    """Read a shipped tuning of washouts by name, or a tuning file by its path."""
    from otolith.cueing.washout.tuning import load_tuning, parse_tuning, tunings

    path = Path(name_or_path)
    if name_or_path in tunings() or path.suffix != ".toml":
        return load_tuning(name_or_path)
    return parse_tuning(read_text(path, "tuning"), path.name)


def read_log(
    path: Path, columns: Mapping[str, str], *, needs: Sequence[str] = (), settings: LogSettings = PLAIN
) -> "Log":
    """Read a recorded drive: text, JSON, CarMaker's .erg, MDF, a ROS bag or a lap; the name's ending decides.

    `columns` maps quantities to columns, `needs` names those that will be cued; both come on top of
    `settings`, what the user states in addition: see `logs.log_from`.
    """
    from otolith.recordings import log_from

    combined = replace(settings, columns={**settings.columns, **columns}, needs=[*settings.needs, *needs])
    return log_from(_columns(path, combined), settings=combined)


def understand_log(path: Path, settings: LogSettings) -> "Understanding":
    """Return what is understood of a recorded drive, whether or not it is accepted."""
    from otolith.recordings.understanding import understand

    return understand(_columns(path, settings), settings)


def _columns(path: Path, settings: LogSettings) -> "Recorded":
    from otolith.logfiles import recorded

    if path.suffix.lower() == ".h5":
        return _read_lap(path)
    return recorded(path, settings.columns, header=settings.header, units=settings.units)


def read_log_settings(path: Path) -> LogSettings:
    """Read from a mapping file how a log is to be read."""
    return settings_from_toml(read_text(path, "mapping"), path.name)


def _read_lap(path: Path) -> "Columns":
    from otolith.recordings.channels import Layout
    from otolith.recordings.recorded import Columns
    from otolith.vehicle.lap import COLUMNS

    arrays = read_sealed(path, kind=LAP_KIND, version=LAP_VERSION).arrays
    lengths = {arrays[name].shape if name in arrays else None for name in COLUMNS}
    if len(lengths) != 1 or None in lengths:
        raise CorruptFile(f"{path} is no sound {LAP_KIND} file: its columns are not of one length")
    return Columns(
        source=path.name,
        names=COLUMNS,
        units=("",) * len(COLUMNS),
        values=tuple(arrays[name] for name in COLUMNS),
        layout=Layout(form="a lap of otolith drive", rows=len(arrays[COLUMNS[0]])),
    )


def write_tables(
    path: Path, tables: "Mapping[str, Sequence[Signal]]", attributes: Mapping[str, str], *, table: str
) -> None:
    """Store tables as HDF5 (a group for each) or MDF 4 (a group of channels for each), or one of them as CSV.

    Parameters
    ----------
    attributes : what is said beside them; an MDF and a CSV file have no room for it.
    table : the one that a CSV file holds.

    Raises
    ------
    InputError : there is no such table.
    """
    ending = path.suffix.lower()
    if ending == ".csv":
        if table not in tables:
            raise InputError("table", repr(table), one_of(tables, table))
        with whole(path) as temporary:
            _write_csv(temporary, tables[table])
        return
    if ending == ".mf4":
        from otolith import registry

        write = registry.WRITERS["mdf"].load()
        with whole(path) as temporary:
            write(temporary, tables)
        return
    arrays = {f"{name}/time": signals[0].t for name, signals in tables.items()}
    units = dict.fromkeys(arrays, "s")
    for name, signals in tables.items():
        arrays |= {f"{name}/{one.name}": one.values for one in signals}
        units |= {f"{name}/{one.name}": one.unit for one in signals}
    write_sealed(path, attributes, arrays, kind=TABLES_KIND, version=TABLES_VERSION, units=units)


def _write_csv(path: Path, signals: "Sequence[Signal]") -> None:
    """Write signals of one clock; numbers are written so that they come back bit for bit."""
    import csv

    names = ["time [s]", *(f"{one.name} [{one.unit}]" if one.unit else one.name for one in signals)]
    columns = [signals[0].t, *(one.values for one in signals)]
    texts = [map(bytes.decode, one) if one.dtype.kind == "S" else map(repr, one.tolist()) for one in columns]
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(zip(*texts, strict=True))


def write_json(path: Path, value: object) -> None:
    """Write plain JSON values, whole or not at all."""
    write_text(path, json.dumps(value, indent=2, allow_nan=False) + "\n")


def write_figure(path: Path, save: Callable[[Path], None]) -> None:
    """Let `save` write a figure to a path of the same ending, whole or not at all."""
    with whole(path) as temporary:
        save(temporary)
