"""Runs as sealed HDF5 files (`otolith.core.hdf5`): read into memory, or written and read part by part."""

import contextlib
import functools
import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import frozen_array
from otolith.core.disk import whole
from otolith.core.errors import damage_reported
from otolith.core.frames import DOFS
from otolith.core.hdf5 import GrowingFile, attributes_of, open_sealed, read_sealed
from otolith.loop import Run
from otolith.loop.keep import kept
from otolith.loop.run import OF_BASE, PART
from otolith.platforms import Platform
from otolith.safety.supervisor import Intervention, Reason

if TYPE_CHECKING:
    import h5py  # imported on use, so that commands without such files start faster

RUN_KIND, RUN_VERSION = "otolith-run", 4
# Shapes of a run's series: n plant samples, m decisions; those of a base are in a file only if there is one.
SERIES: Final[dict[str, tuple[Any, ...]]] = {
    "time": ("n",),
    "reference_force": ("n", 3),
    "reference_rate": ("n", 3),
    "felt_force": ("n", 3),
    "pose": ("n", 6),
    "twist": ("n", 6),
    "acceleration": ("n", 6),
    "base": ("n", 18),
    "command_time": ("m",),
    "command": ("m", 6),
    "base_command": ("m", 6),
    "status": ("m",),
    "solver": ("m",),
    "changes": ("m",),
    "residual": ("m",),
    "guess_missed": ("m",),
    "step_time": ("m",),
}
_KINDS: Final = {
    "status": "S",
    "solver": "S",
    "changes": "i",
    "guess_missed": "b",
}  # kinds of numbers; all others: "f"
_WORDS: Final = ("status", "solver")
_TEXTS: Final = ("scenario", "cueing", "plant")
_PERIODS: Final = ("period", "plant_period")


def write_run(run: Run, path: Path) -> None:
    """Store a run: one data set per series, attributes for the rest."""
    with run_file(path) as file:
        kept(run, file)


def read_run(path: Path) -> Run:
    """Read a run that equals the one written.

    Raises
    ------
    InputError : there is no such file.
    CorruptFile : the file is not a run of this version, is damaged, or its series do not belong together.
    """
    content = read_sealed(path, kind=RUN_KIND, version=RUN_VERSION)
    with damage_reported(f"{path} is no sound {RUN_KIND} file"):
        plain, arrays = _plain(content.attributes), content.arrays
        _check_series(arrays, period=plain["period"], plant_period=plain["plant_period"])
        series: dict[str, Any] = {
            name: frozen_array(arrays[name], dtype=None) for name in SERIES if name in arrays
        }
        return Run(**plain, **series | {name: _words(series[name]) for name in _WORDS})


@contextlib.contextmanager
def run_file(path: Path) -> Iterator["RunFile"]:
    """Yield a keeper that stores a run part by part while it is made; see `otolith.loop.Keeper`.

    The file appears at `path` at the end of the block. If the block fails, or is interrupted, nothing is
    left. The run that the keeper returns is read from the file, and only within the block.

    Raises
    ------
    NotWritten : the folder is not writable, or the disk is full.

    Examples
    --------
    >>> with files.run_file(Path("run.h5")) as file:
    ...     run = simulate(cueing, plant, scenario, platform=platform, dofs=dofs, keep=file)
    ...     summary = summarise(run)
    """
    with whole(path) as temporary, contextlib.closing(RunFile(temporary)) as file:
        yield file
        file.whole()


@contextlib.contextmanager
def open_run(path: Path) -> Iterator[Run]:
    """Yield a run whose series are read from its file when they are asked for, within the block.

    Errors are those of `read_run`.
    """
    file = open_sealed(path, kind=RUN_KIND, version=RUN_VERSION)
    with file:
        with damage_reported(f"{path} is no sound {RUN_KIND} file"):
            plain = _plain(attributes_of(file))
            _check_series(file, period=plain["period"], plant_period=plain["plant_period"])
        yield StoredRun(file, plain, 0, len(file["command_time"]))


class RunFile:
    """The file of a run while it is written; `run_file` makes it and puts it into its place."""

    def __init__(self, path: Path) -> None:
        self._path, self._file = path, GrowingFile(path)
        self._attributes: dict[str, Any] = {}
        self._run: StoredRun | None = None

    def add(self, part: Run) -> None:
        """Append a part."""
        series = {name: getattr(part, name) for name in SERIES if name not in _WORDS}
        arrays = {name: np.asarray(values) for name, values in series.items() if values is not None}
        self._file.append(arrays | {name: np.array(getattr(part, name), dtype="S16") for name in _WORDS})
        self._attributes = _attributes(part)

    def whole(self) -> Run:
        """Return the run of all parts; no other can be added then."""
        if self._run is None:
            self._file.seal(self._attributes, kind=RUN_KIND, version=RUN_VERSION)
            file = open_sealed(self._path, kind=RUN_KIND, version=RUN_VERSION)
            self._run = StoredRun(file, _plain(self._attributes), 0, len(file["command_time"]))
        return self._run

    def close(self) -> None:
        """Close the file; the run can no longer be read."""
        self._file.close()
        if self._run is not None:
            self._run.close()


class StoredRun(Run):
    """A run, or a part of one, whose series are read from its file each time they are asked for."""

    __slots__ = ("_file", "_first", "_last")
    _file: "h5py.File"
    _first: int  # control steps of the file: those of the run are from here
    _last: int  # up to here

    def __init__(self, file: "h5py.File", plain: Mapping[str, Any], first: int, last: int) -> None:
        for name, value in {**plain, "_file": file, "_first": first, "_last": last}.items():
            object.__setattr__(self, name, value)

    @property
    def decisions(self) -> int:
        """Return the number of control steps, m."""
        return self._last - self._first

    @property
    def samples(self) -> int:
        """Return the number of plant samples, n."""
        return self.decisions * round(self.period / self.plant_period)

    def part(self, first: int, last: int) -> Run:
        """Return a part as a run of its own, which is read from the same file."""
        plain = {one.name: getattr(self, one.name) for one in fields(Run) if one.name not in SERIES}
        return StoredRun(self._file, plain, self._first + first, self._first + last)

    def close(self) -> None:
        """Close the file of the run."""
        self._file.close()

    def _read(self, name: str) -> Any:
        """Read a series from the file."""
        if name in OF_BASE and name not in self._file:
            return None
        every = round(self.period / self.plant_period) if SERIES[name][0] == "n" else 1
        rows = self._file[name][self._first * every : self._last * every]
        return _words(rows) if name in _WORDS else rows


for _name in SERIES:  # these take the place of the fields that `Run` has in memory
    setattr(StoredRun, _name, property(functools.partial(lambda name, run: run._read(name), _name)))


def _attributes(run: Run) -> dict[str, Any]:
    """Return everything of a run but its series, as attributes of a file."""
    attributes = {name: getattr(run, name) for name in (*_TEXTS, *_PERIODS)}
    attributes["platform"] = run.platform.model_dump_json()
    attributes |= {name: json.dumps(getattr(run, name)) for name in ("dofs", "soft", "settings")}
    attributes["interventions"] = json.dumps([asdict(one) for one in run.interventions])
    return attributes


def _plain(stored: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a run that are not series, from the attributes of its file."""
    plain: dict[str, Any] = {name: str(stored[name]) for name in _TEXTS}
    plain |= {name: float(stored[name]) for name in _PERIODS}
    plain |= {
        "platform": Platform.model_validate_json(stored["platform"]),
        "dofs": tuple(json.loads(stored["dofs"])),
        "soft": tuple(map(str, json.loads(stored["soft"]))),
        "settings": json.loads(stored["settings"]),
        "interventions": tuple(
            Intervention(**{**one, "reason": Reason(one["reason"])})
            for one in json.loads(stored["interventions"])
        ),
    }
    if not (set(plain["dofs"]) <= set(DOFS) and plain["dofs"]):
        raise ValueError(f"it names the degrees of freedom {plain['dofs']}")
    if not isinstance(plain["settings"], dict):
        raise ValueError("its settings are not a table of names and values")
    return plain


def _words(stored: NDArray[Any]) -> tuple[str, ...]:
    """Return words as text; equal words are one object, for a run has many of them."""
    known = {word: word.decode() for word in set(stored.tolist())}
    return tuple(known[word] for word in stored.tolist())


def _check_series(arrays: Mapping[str, Any], *, period: float, plant_period: float) -> None:
    """Check that every series has the type and shape that follow from the two clocks.

    Parameters
    ----------
    arrays : arrays, or data sets of an open file.

    Raises
    ------
    ValueError : a series has not; the message names it.
    """
    n, m = len(arrays["time"]), len(arrays["command_time"])
    if not (0.0 < plant_period <= period < np.inf and n == m * round(period / plant_period) > 0):
        raise ValueError(
            f"{n} samples every {plant_period:g} s do not belong to {m} decisions every {period:g} s"
        )
    absent = [name for name in OF_BASE if name not in arrays]
    if absent and len(absent) < len(OF_BASE):
        raise ValueError(f"it has no {absent[0]}")
    for name, letters in SERIES.items():
        if name in absent:
            continue
        shape = tuple({"n": n, "m": m}.get(letter, letter) for letter in letters)
        found, kind = arrays[name], _KINDS.get(name, "f")
        if found.shape != shape or found.dtype.kind != kind:
            raise ValueError(
                f"{name} has shape {found.shape} of {found.dtype}, must be {shape} of kind {kind}"
            )
    for name, step in (("time", plant_period), ("command_time", period)):
        for first in range(0, len(arrays[name]), PART):
            if not np.allclose(np.diff(arrays[name][first : first + PART + 1]), step, rtol=1e-6, atol=1e-9):
                raise ValueError(f"{name} does not run in steps of {step:g} s")
