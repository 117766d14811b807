"""Runs, explicit laws, hints and terminal sets as sealed HDF5 files (`otolith.core.hdf5`)."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.arrays import frozen_array
from otolith.core.errors import damage_reported
from otolith.core.frames import DOFS
from otolith.core.hdf5 import Content, read_sealed, write_sealed
from otolith.loop import Run
from otolith.platforms import Platform
from otolith.safety.supervisor import Intervention, Reason

if TYPE_CHECKING:  # laws, hints and sets are imported on use, because most commands read only runs
    from otolith.cueing.hints.stored import StoredHint
    from otolith.cueing.mpc.terminal import TerminalSets
    from otolith.mpqp import Law

RUN_KIND, RUN_VERSION = "otolith-run", 4
LAW_KIND, LAW_VERSION = "otolith-law", 2
HINT_KIND, HINT_VERSION = "otolith-hint", 5
SETS_KIND, SETS_VERSION = "otolith-terminal-sets", 1
# Shapes of a run's series: n plant samples, m decisions.
_SERIES: Final[dict[str, tuple[Any, ...]]] = {
    "time": ("n",),
    "reference_force": ("n", 3),
    "reference_rate": ("n", 3),
    "felt_force": ("n", 3),
    "pose": ("n", 6),
    "twist": ("n", 6),
    "acceleration": ("n", 6),
    "command_time": ("m",),
    "command": ("m", 6),
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
    attributes = {name: getattr(run, name) for name in (*_TEXTS, *_PERIODS)}
    attributes["platform"] = run.platform.model_dump_json()
    attributes |= {name: json.dumps(getattr(run, name)) for name in ("dofs", "soft", "settings")}
    attributes["interventions"] = json.dumps([asdict(one) for one in run.interventions])
    arrays = {name: np.asarray(getattr(run, name)) for name in _SERIES if name not in _WORDS}
    arrays |= {name: np.array(getattr(run, name), dtype="S16") for name in _WORDS}
    write_sealed(path, attributes, arrays, kind=RUN_KIND, version=RUN_VERSION)


def read_run(path: Path) -> Run:
    """Read a run that equals the one written.

    Raises
    ------
    InputError : there is no such file.
    CorruptFile : the file is not a run of this version, is damaged, or its series do not belong together.
    """
    content = read_sealed(path, kind=RUN_KIND, version=RUN_VERSION)
    with damage_reported(f"{path} is no sound {RUN_KIND} file"):
        return _run(content)


def _run(content: Content) -> Run:
    stored, arrays = content.attributes, content.arrays
    plain: dict[str, Any] = {name: str(stored[name]) for name in _TEXTS}
    plain |= {name: float(stored[name]) for name in _PERIODS}
    _check_series(arrays, period=plain["period"], plant_period=plain["plant_period"])
    series: dict[str, Any] = {name: frozen_array(arrays[name], dtype=None) for name in _SERIES}
    series |= {name: tuple(value.decode() for value in series[name]) for name in _WORDS}
    run = Run(
        **plain,
        **series,
        platform=Platform.model_validate_json(stored["platform"]),
        dofs=tuple(json.loads(stored["dofs"])),
        soft=tuple(map(str, json.loads(stored["soft"]))),
        settings=json.loads(stored["settings"]),
        interventions=tuple(
            Intervention(**{**one, "reason": Reason(one["reason"])})
            for one in json.loads(stored["interventions"])
        ),
    )
    if not (set(run.dofs) <= set(DOFS) and run.dofs):
        raise ValueError(f"it names the degrees of freedom {run.dofs}")
    if not isinstance(run.settings, dict):
        raise ValueError("its settings are not a table of names and values")
    return run


def _check_series(arrays: Mapping[str, NDArray[Any]], *, period: float, plant_period: float) -> None:
    """Check that every series has the type and shape that follow from the two clocks.

    Raises
    ------
    ValueError : a series has not; the message names it.
    """
    n, m = len(arrays["time"]), len(arrays["command_time"])
    if not (0.0 < plant_period <= period < np.inf and n == m * round(period / plant_period) > 0):
        raise ValueError(
            f"{n} samples every {plant_period:g} s do not belong to {m} decisions every {period:g} s"
        )
    for name, letters in _SERIES.items():
        shape = tuple({"n": n, "m": m}.get(letter, letter) for letter in letters)
        found, kind = arrays[name], _KINDS.get(name, "f")
        if found.shape != shape or found.dtype.kind != kind:
            raise ValueError(
                f"{name} has shape {found.shape} of {found.dtype}, must be {shape} of kind {kind}"
            )
    for name, step in (("time", plant_period), ("command_time", period)):
        if not np.allclose(np.diff(arrays[name]), step, rtol=1e-6, atol=1e-9):
            raise ValueError(f"{name} does not run in steps of {step:g} s")


def write_laws(laws: Sequence["Law"], path: Path) -> None:
    """Store explicit laws, one group of arrays each."""
    arrays = {
        f"part-{number}/{name}": array
        for number, law in enumerate(laws)
        for name, array in law.to_arrays().items()
    }
    write_sealed(path, {"parts": len(laws)}, arrays, kind=LAW_KIND, version=LAW_VERSION)


def read_laws(path: Path) -> tuple["Law", ...]:
    """Read explicit laws, at least one.

    Raises
    ------
    InputError : there is no such file.
    CorruptFile : the file holds no laws of this version, is damaged, or its arrays do not belong together.
    """
    content = read_sealed(path, kind=LAW_KIND, version=LAW_VERSION)
    with damage_reported(f"{path} is no sound {LAW_KIND} file"):
        return _laws(content)


def _laws(content: Content) -> tuple["Law", ...]:
    from otolith.mpqp import Law

    groups: dict[str, dict[str, NDArray[Any]]] = {}
    for name, array in content.arrays.items():
        group, _, own = name.partition("/")
        groups.setdefault(group, {})[own] = array
    parts = int(content.attributes["parts"])
    if not 1 <= parts == len(groups) or set(groups) != {f"part-{number}" for number in range(len(groups))}:
        raise ValueError(f"it declares {parts} laws and holds {len(groups)}")
    return tuple(Law.from_arrays(groups[f"part-{number}"]) for number in range(parts))


def write_hint(hint: "StoredHint", path: Path) -> None:
    """Store a hint with the model to which it belongs."""
    attributes = {"model": json.dumps(hint.model), "training": json.dumps(hint.training)}
    write_sealed(path, attributes, hint.to_arrays(), kind=HINT_KIND, version=HINT_VERSION)


def read_hint(path: Path) -> "StoredHint":
    """Read a hint.

    Raises
    ------
    InputError : there is no such file.
    CorruptFile : the file is not a hint of this version, is damaged, or its arrays do not belong together.
    """
    content = read_sealed(path, kind=HINT_KIND, version=HINT_VERSION)
    with damage_reported(f"{path} is no sound {HINT_KIND} file"):
        return _hint(content)


def _hint(content: Content) -> "StoredHint":
    from otolith.cueing.hints.stored import StoredHint

    model, training = (json.loads(content.attributes[name]) for name in ("model", "training"))
    if not (isinstance(model, dict) and isinstance(training, dict)):
        raise ValueError("its model or training is not a table of names and values")
    return StoredHint.from_arrays(content.arrays, model, training)


def write_sets(sets: "TerminalSets", path: Path) -> None:
    """Store the certified sets of a platform, one group of arrays for each axis."""
    write_sealed(path, sets.attributes(), sets.to_arrays(), kind=SETS_KIND, version=SETS_VERSION)


def read_sets(path: Path) -> "TerminalSets":
    """Read the certified sets of a platform; they prove nothing before `TerminalSets.check` has passed them.

    Raises
    ------
    InputError : there is no such file.
    CorruptFile : the file holds no sets of this version, is damaged, or its arrays do not belong together.
    """
    from otolith.cueing.mpc.terminal import TerminalSets

    content = read_sealed(path, kind=SETS_KIND, version=SETS_VERSION)
    with damage_reported(f"{path} is no sound {SETS_KIND} file"):
        return TerminalSets.restored(content.attributes, content.arrays)
