"""Every read and write of runs, laws, hints, platforms, logs and reports.

Files appear whole or not at all: they are written beside their place and renamed into it. What is
read is checked before it is used: kind, version, checksum.
"""

import contextlib
import hashlib
import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, Final

import h5py
import numpy as np

from otolith.core.arrays import frozen_array
from otolith.core.errors import CorruptFile, InputError, one_of
from otolith.logfiles import recorded
from otolith.mpc.hint.stored import StoredHint, digest
from otolith.mpqp import Law
from otolith.platforms import Platform, catalog, load, parse_platform
from otolith.platforms.tuning import Tuning, load_tuning, parse_tuning, tunings
from otolith.scenarios import Log, log_from
from otolith.scenarios.channels import Layout
from otolith.scenarios.recorded import Columns
from otolith.simulate import Run
from otolith.vehicle import Car, Lap, Road, load_car, parse_car, parse_centreline, parse_gpx, road
from otolith.vehicle.lap import COLUMNS

RUN_KIND, RUN_VERSION = "otolith-run", 2
_RUN_WITHOUT_RATE: Final = 1  # version that kept neither single axes nor the rates to be felt
LAW_KIND, LAW_VERSION = "otolith-law", 1
HINT_KIND, HINT_VERSION = "otolith-hint", 2
LAP_KIND, LAP_VERSION = "otolith-lap", 1
_RUN_ATTRIBUTES: Final = ("scenario", "cueing", "plant", "period", "plant_period")
_RUN_SPECIAL: Final = (*_RUN_ATTRIBUTES, "platform", "pairs", "singles", "soft", "settings", "status")


def read_text(path: Path, what: str) -> str:
    """Text of a UTF-8 file the user named; `what` it should be goes into the error's sentence."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{what} {path}", f"not UTF-8 at byte {error.start}", "a UTF-8 text file") from error
    except OSError as error:
        raise InputError(f"{what} {path}", f"not readable ({error.strerror})", "a readable file") from error


def read_platform(name_or_path: str) -> Platform:
    """A shipped platform by name, or a platform file by its path."""
    if name_or_path in catalog():
        return load(name_or_path)
    path = Path(name_or_path)
    if path.suffix != ".toml" and not path.exists():
        raise InputError("platform", repr(name_or_path), "a .toml file or " + one_of(catalog(), name_or_path))
    return parse_platform(read_text(path, "platform"), path.name)


def read_road(text: str, *, smoothing: float | None = None, closed: bool | None = None) -> Road:
    """A shipped road by name and parameters, or a centreline (.csv, .txt, .tsv) or GPX file by its path.

    `smoothing` and `closed` are those of `otolith.vehicle.centreline.road_through`.

    Raises
    ------
    InputError : no such road or file, or one of the two options for a road that is none of a file.
    """
    path = Path(text)
    ending = path.suffix.lower()
    if ending == ".gpx":
        return parse_gpx(read_text(path, "GPX file"), path.name, smoothing=smoothing, closed=closed)
    if ending in (".csv", ".txt", ".tsv"):
        return parse_centreline(read_text(path, "centreline"), path.name, smoothing=smoothing, closed=closed)
    for option, value in (("--smoothing", smoothing), ("--closed or --open", closed)):
        if value is not None:
            raise InputError(option, "given", f"left out, for {text!r} is not a file of points")
    return road(text)


def read_car(name_or_path: str) -> Car:
    """A shipped car by name, or a car file by its path."""
    path = Path(name_or_path)
    if path.suffix != ".toml":
        return load_car(name_or_path)
    return parse_car(read_text(path, "car"), path.name)


def check_lap_name(path: Path) -> None:
    """Refuse, before any work, a name that `write_lap` could not use."""
    if path.suffix.lower() not in (".csv", ".h5"):
        raise InputError("file for the drive", path.name, "a name that ends in .csv or .h5")


def write_lap(lap: Lap, path: Path) -> None:
    """Store a drive as CSV, or as HDF5 with one data set per column; `read_log` reads either."""
    check_lap_name(path)
    data = lap.columns()
    with whole(path) as temporary:
        if path.suffix.lower() == ".csv":
            np.savetxt(temporary, data, fmt="%.9g", delimiter=",", header=",".join(COLUMNS), comments="")
            return
        with h5py.File(temporary, "w") as file:
            file.attrs.update(kind=LAP_KIND, version=LAP_VERSION, road=lap.road.name, source=lap.road.source)
            file.attrs["car"] = lap.car.model_dump_json()
            for name, column in zip(COLUMNS, data.T, strict=True):
                file.create_dataset(name, data=column, compression="gzip")


def read_tuning(name_or_path: str) -> Tuning:
    """A shipped tuning of washouts by name, or a tuning file by its path."""
    path = Path(name_or_path)
    if name_or_path in tunings() or path.suffix != ".toml":
        return load_tuning(name_or_path)
    return parse_tuning(read_text(path, "tuning"), path.name)


def read_log(
    path: Path,
    columns: Mapping[str, str],
    *,
    needs: Sequence[str] = (),
    header: int | None = None,
    units: int | None = None,
) -> Log:
    """A recorded drive: delimited text, CarMaker's .erg, MDF, a ROS bag or a lap; the name's ending tells.

    `columns` maps quantities to columns, `needs` names those that will be cued: see `reading.recording`.
    `header` and `units` are the lines of a text that hold names and units, where they are not found.
    """
    if path.suffix.lower() == ".h5":
        return log_from(_read_lap(path), columns=columns, needs=needs)
    return log_from(recorded(path, columns, header=header, units=units), columns=columns, needs=needs)


def _read_lap(path: Path) -> Columns:
    with _hdf5(path, LAP_KIND, LAP_VERSION) as file:
        return Columns(
            source=path.name,
            names=COLUMNS,
            units=("",) * len(COLUMNS),
            values=tuple(file[name][()] for name in COLUMNS),
            layout=Layout(form="a lap of otolith drive", rows=len(file[COLUMNS[0]])),
        )


@contextlib.contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Give a temporary path to write; on success it becomes `path`, on any failure it vanishes."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=path.suffix)
    except OSError as error:
        raise InputError(
            f"output {path}", f"not writable ({error.strerror})", "in a writable folder"
        ) from error
    os.close(handle)
    temporary = Path(name)
    temporary.chmod(0o644)  # mkstemp makes it private
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file, whole or not at all."""
    with whole(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, value: object) -> None:
    """Write plain JSON values, whole or not at all."""
    write_text(path, json.dumps(value, indent=2, allow_nan=False) + "\n")


def write_figure(path: Path, save: Callable[[Path], None]) -> None:
    """Let `save` write a figure to a path of the same ending, whole or not at all."""
    with whole(path) as temporary:
        save(temporary)


def write_run(run: Run, path: Path) -> None:
    """Store a run as HDF5: one compressed data set per series, attributes for the rest."""
    with whole(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs.update(kind=RUN_KIND, version=RUN_VERSION)
        file.attrs.update({name: getattr(run, name) for name in _RUN_ATTRIBUTES})
        file.attrs["platform"] = run.platform.model_dump_json()
        file.attrs["pairs"], file.attrs["singles"] = json.dumps(run.pairs), json.dumps(run.singles)
        file.attrs["soft"], file.attrs["settings"] = json.dumps(run.soft), json.dumps(run.settings)
        file.create_dataset("status", data=np.array(run.status, dtype="S16"), compression="gzip")
        for field in fields(run):
            if field.name not in _RUN_SPECIAL:
                file.create_dataset(field.name, data=getattr(run, field.name), compression="gzip")


def read_run(path: Path) -> Run:
    """Read a run back, equal to the one written; the rates to be felt are NaN in files of version 1.

    Raises
    ------
    CorruptFile : not a run of a known version, or damaged.
    """
    with _hdf5(path, RUN_KIND, RUN_VERSION, _RUN_WITHOUT_RATE) as file:
        old = file.attrs["version"] == _RUN_WITHOUT_RATE
        names = {f.name for f in fields(Run)} - {*_RUN_SPECIAL, *(["reference_rate"] if old else [])}
        series: dict[str, Any] = {name: frozen_array(file[name][()], dtype=None) for name in names}
        if old:
            series["reference_rate"] = frozen_array(np.full_like(series["reference_force"], np.nan))
        plain = {name: file.attrs[name] for name in ("scenario", "cueing", "plant")}
        return Run(
            **plain,
            **series,
            period=float(file.attrs["period"]),
            plant_period=float(file.attrs["plant_period"]),
            platform=Platform.model_validate_json(file.attrs["platform"]),
            pairs=tuple(json.loads(file.attrs["pairs"])),
            singles=() if old else tuple(json.loads(file.attrs["singles"])),
            soft=tuple(json.loads(file.attrs.get("soft", "[]"))),  # earlier files did not tell
            settings=json.loads(file.attrs["settings"]),
            status=tuple(value.decode() for value in file["status"][()]),
        )


def write_laws(laws: Sequence[Law], path: Path) -> None:
    """Store explicit laws as HDF5, one group each, with the hashes that bind content and model."""
    with whole(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs.update(kind=LAW_KIND, version=LAW_VERSION, parts=len(laws))
        for number, law in enumerate(laws):
            arrays = law.to_arrays()
            group = file.create_group(f"part-{number}")
            group.attrs.update(model=law.problem.digest, sha256=_digest(arrays))
            for name, array in arrays.items():
                options = {"compression": "gzip"} if np.ndim(array) else {}
                group.create_dataset(name, data=array, **options)


def read_laws(path: Path) -> tuple[Law, ...]:
    """Read explicit laws.

    Raises
    ------
    CorruptFile : not laws of this version, or content or model does not match its hash.
    """
    with _hdf5(path, LAW_KIND, LAW_VERSION) as file:
        return tuple(_law(file[f"part-{number}"], path) for number in range(file.attrs["parts"]))


def _law(group: h5py.Group, path: Path) -> Law:
    arrays = {name: group[name][()] for name in group}
    if _digest(arrays) != group.attrs["sha256"]:
        raise CorruptFile(f"{path} was altered: its content does not match its SHA-256")
    law = Law.from_arrays(arrays)
    if law.problem.digest != group.attrs["model"]:
        raise CorruptFile(f"{path} was altered: its model does not match its hash")
    return law


def write_hint(hint: StoredHint, path: Path) -> None:
    """Store a hint as HDF5, with the hashes that bind content and model."""
    arrays = hint.to_arrays()
    with whole(path) as temporary, h5py.File(temporary, "w") as file:
        file.attrs.update(kind=HINT_KIND, version=HINT_VERSION)
        file.attrs.update(model=json.dumps(hint.model), training=json.dumps(hint.training))
        file.attrs.update(model_sha256=digest(hint.model), sha256=_digest(arrays))
        for name, array in arrays.items():
            options = {"compression": "gzip"} if np.ndim(array) else {}
            file.create_dataset(name, data=array, **options)


def read_hint(path: Path) -> StoredHint:
    """Read a hint.

    Raises
    ------
    CorruptFile : not a hint of this version, or content or model does not match its hash.
    """
    with _hdf5(path, HINT_KIND, HINT_VERSION) as file:
        arrays = {name: file[name][()] for name in file}
        if _digest(arrays) != file.attrs["sha256"]:
            raise CorruptFile(f"{path} was altered: its content does not match its SHA-256")
        model = json.loads(file.attrs["model"])
        if digest(model) != file.attrs["model_sha256"]:
            raise CorruptFile(f"{path} was altered: its model does not match its hash")
        return StoredHint.from_arrays(arrays, model, json.loads(file.attrs["training"]))


def _digest(arrays: Mapping[str, Any]) -> str:
    sha = hashlib.sha256()
    for name in sorted(arrays):
        array = np.ascontiguousarray(arrays[name])
        sha.update(f"{name} {array.dtype.str} {array.shape};".encode())
        sha.update(array.tobytes())
    return sha.hexdigest()


@contextlib.contextmanager
def _hdf5(path: Path, kind: str, version: int, *older: int) -> Iterator[h5py.File]:
    """Open an HDF5 file of the given kind and of one of the versions; damage becomes one sentence."""
    if not path.exists():
        raise InputError(f"file {path}", "absent", "an existing file")
    try:
        with h5py.File(path, "r") as file:
            if file.attrs.get("kind") != kind:
                raise CorruptFile(f"{path} is not an {kind} file")
            if file.attrs.get("version") not in (version, *older):
                raise CorruptFile(
                    f"{path} has version {file.attrs.get('version')} of {kind}, this program reads {version}"
                )
            yield file
    except (OSError, KeyError, ValueError, TypeError) as error:  # what h5py and json raise on damage
        raise CorruptFile(f"{path} is damaged or no {kind} file: {error}") from error
