"""A design as plain JSON values, and back: the settings that a run's file stores.

Numbers are restored bit for bit, because Python writes the shortest text that reads as the same number.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, fields, replace
from typing import Any, Final

import numpy as np

from otolith import registry
from otolith.core.frames import dofs_named
from otolith.core.lti import StateSpace
from otolith.cueing.design import Design
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.predictive import DERIVED
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.mpc.six_axis import Generator
from otolith.cueing.mpc.washout_weights import WashoutWeight
from otolith.cueing.prediction.named import Prediction, prediction_named, prediction_to_record
from otolith.cueing.washout.tuning import Corners, Tuning
from otolith.perception import Vestibular
from otolith.platforms import Platform

_ALWAYS: Final = ("period", "lag")  # logs are resampled to this period, whatever the algorithm
_MATRICES: Final = ("A", "B", "C", "D")


def design_to_record(design: Design, reads: Collection[str] | None = None) -> dict[str, Any]:
    """Return plain values of a design, without platform, degrees of freedom, laws and hints.

    Parameters
    ----------
    reads : options that the algorithm reads, see `otolith.registry.Entry`; options that it ignores are left
        out, so that none seems to have had an effect. None if this is unknown; then all are kept.
    """
    mpc, explicit = _mpc_to_record(design.mpc), asdict(design.explicit)
    record: dict[str, Any] = {"mpc": mpc}
    if reads is not None and "solver" not in reads:
        record["mpc"] = {name: mpc[name] for name in _ALWAYS}
    elif reads is not None and "liveliness" in reads:
        record["mpc"] = {name: value for name, value in mpc.items() if name not in DERIVED}
    if reads is None or "liveliness" in reads:
        record["liveliness"] = design.liveliness
    if reads is None or "high_pass" in reads:
        record["corners"] = asdict(design.corners)
    if reads is None or "second_blocks" in reads:
        record["second_blocks"] = list(design.second_blocks)
    if reads is None or "generator" in reads:
        record["generator"] = design.generator.value
    if reads is None or "law" in reads:
        record["explicit"] = explicit | {"state_weights": list(design.explicit.state_weights)}
    if reads is None or "guess_entry" in reads:
        record["guess_entry"] = design.entry.value
    if design.washout is not None and (reads is None or "tuning" in reads):
        record["tuning"] = design.washout.model_dump(mode="json")
    return record


def design_from_record(record: Mapping[str, Any], platform: Platform, dofs: tuple[str, ...]) -> Design:
    """Return the design of a record, for a platform and degrees of freedom by name.

    Raises
    ------
    KeyError, TypeError, ValueError, OtolithError : the record is of another version, or damaged.
    """
    values: dict[str, Any] = {"mpc": _mpc_from_record(record["mpc"])}
    if "explicit" in record:
        explicit = dict(record["explicit"])
        explicit["braking"] = BrakingRows(explicit["braking"])
        explicit["state_weights"] = tuple(explicit["state_weights"])
        values["explicit"] = ExplicitSettings(**explicit)
    if "liveliness" in record:
        values["liveliness"] = record["liveliness"]
    if "corners" in record:
        values["corners"] = Corners(**record["corners"])
    if "second_blocks" in record:
        values["second_blocks"] = tuple(record["second_blocks"])
    if "generator" in record:
        values["generator"] = Generator(record["generator"])
    if "guess_entry" in record:
        values["entry"] = Entry(record["guess_entry"])
    if "tuning" in record:
        values["washout"] = Tuning.model_validate(record["tuning"])
    return Design(platform=platform, dofs=dofs_named(dofs), **values)


def _mpc_to_record(settings: MpcSettings) -> dict[str, Any]:
    values = {one.name: getattr(settings, one.name) for one in fields(settings)}
    senses = settings.objective.senses
    organs = senses and {
        "otolith": _system_to_record(senses.otolith),
        "canal": _system_to_record(senses.canal),
    }
    prediction = settings.prediction
    return values | {
        "prediction": None if prediction is None else prediction_to_record(prediction),
        "objective": {
            **asdict(replace(settings.objective, senses=None)),
            "senses": organs,
        },
        "washout": [
            {**asdict(weight), "coefficients": list(weight.coefficients)} for weight in settings.washout
        ],
        "braking": settings.braking.value,
        "soft": dict(settings.soft),
        "blocks": list(settings.blocks),
        "engine": _engine_name(settings.engine),
    }


def _mpc_from_record(record: Mapping[str, Any]) -> MpcSettings:
    typed = {name: _TYPED[name](value) if name in _TYPED else value for name, value in record.items()}
    return MpcSettings(**typed)


def _objective(record: Mapping[str, Any]) -> Objective:
    organs = record["senses"]
    senses = (
        None if organs is None else Vestibular(**{name: _system(organ) for name, organ in organs.items()})
    )
    return Objective(**{**record, "senses": senses})


def _washout(record: Sequence[Mapping[str, Any]]) -> tuple[WashoutWeight, ...]:
    return tuple(WashoutWeight(**{**one, "coefficients": tuple(one["coefficients"])}) for one in record)


def _system_to_record(system: StateSpace) -> dict[str, Any]:
    return {name: getattr(system, name).tolist() for name in _MATRICES} | {"period": system.period}


def _system(record: Mapping[str, Any]) -> StateSpace:
    matrices = {name: np.array(record[name], dtype=np.float64) for name in _MATRICES}
    return StateSpace(**matrices, period=record["period"])


def _engine_name(engine: Any) -> str:
    """Return the name of a QP engine; one from outside is named "module:attribute" and not loaded again."""
    target = f"{getattr(engine, '__module__', '')}:{getattr(engine, '__qualname__', '')}"
    return next((name for name, entry in registry.SOLVERS.items() if entry.target == target), target)


def _engine(name: str) -> Any:
    """Return the engine of a record; code from outside is not started because a file names it."""
    return registry.lookup(registry.SOLVERS, "QP engine of the run", name).load()


def _prediction(record: Mapping[str, Any] | None) -> Prediction | None:
    return None if record is None else prediction_named(record)


# Fields of `MpcSettings` that are not plain values, and the functions that make them from plain values.
_TYPED: Final[Mapping[str, Callable[[Any], Any]]] = {
    "objective": _objective,
    "washout": _washout,
    "braking": BrakingRows,
    "blocks": tuple,
    "prediction": _prediction,
    "engine": _engine,
}
