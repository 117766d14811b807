"""Explicit laws, hints and terminal sets as sealed HDF5 files (`otolith.core.hdf5`)."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from otolith.core.errors import damage_reported
from otolith.core.hdf5 import Content, read_sealed, write_sealed

if TYPE_CHECKING:  # laws, hints and sets are imported on use, because most commands read only runs
    from otolith.cueing.hints.stored import StoredHint
    from otolith.cueing.mpc.terminal import TerminalSets
    from otolith.mpqp import Law

LAW_KIND, LAW_VERSION = "otolith-law", 2
HINT_KIND, HINT_VERSION = "otolith-hint", 5
SETS_KIND, SETS_VERSION = "otolith-terminal-sets", 1


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
