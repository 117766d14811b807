"""A design as plain JSON values, and back: what a run's file keeps of the settings that were meant.

Numbers come back bit for bit, since Python writes the shortest text that reads as the same number.
"""

from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from typing import Any, Final

import numpy as np

from otolith import registry
from otolith.core.frames import dofs_named
from otolith.core.lti import StateSpace
from otolith.core.plugins import load_target
from otolith.cueing.design import Design
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.mpc.washout_weights import WashoutWeight
from otolith.cueing.washout.tuning import Tuning
from otolith.perception import Vestibular
from otolith.platforms import Platform

_MATRICES: Final = ("A", "B", "C", "D")


def design_to_record(design: Design) -> dict[str, Any]:
    """Plain values of a design; the platform, the degrees of freedom, laws and hints are kept elsewhere."""
    return {
        "mpc": _mpc_to_record(design.mpc),
        "explicit": {**asdict(design.explicit), "state_weights": list(design.explicit.state_weights)},
        "guess_entry": design.entry.value,
        "tuning": None if design.washout is None else design.washout.model_dump(mode="json"),
    }


def design_from_record(record: Mapping[str, Any], platform: Platform, dofs: tuple[str, ...]) -> Design:
    """The design that a record describes, for a platform and degrees of freedom by name.

    Raises
    ------
    KeyError, TypeError, ValueError, OtolithError : the record is of another version, or damaged.
    """
    explicit = dict(record["explicit"])
    explicit["braking"] = BrakingRows(explicit["braking"])
    explicit["state_weights"] = tuple(explicit["state_weights"])
    return Design(
        platform=platform,
        dofs=dofs_named(dofs),
        explicit=ExplicitSettings(**explicit),
        mpc=_mpc_from_record(record["mpc"]),
        entry=Entry(record["guess_entry"]),
        washout=None if record["tuning"] is None else Tuning.model_validate(record["tuning"]),
    )


def _mpc_to_record(settings: MpcSettings) -> dict[str, Any]:
    told = {one.name: getattr(settings, one.name) for one in fields(settings)}
    senses = settings.objective.senses
    organs = senses and {
        "otolith": _system_to_record(senses.otolith),
        "canal": _system_to_record(senses.canal),
    }
    return told | {
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
    objective = dict(record["objective"])
    organs = objective.pop("senses")
    senses = (
        None if organs is None else Vestibular(**{name: _system(organ) for name, organ in organs.items()})
    )
    weights = [
        WashoutWeight(**{**one, "coefficients": tuple(one["coefficients"])}) for one in record["washout"]
    ]
    found: dict[str, Any] = {
        **record,
        "objective": Objective(senses=senses, **objective),
        "washout": tuple(weights),
        "braking": BrakingRows(record["braking"]),
        "blocks": tuple(record["blocks"]),
        "engine": _engine(record["engine"]),
    }
    return MpcSettings(**found)


def _system_to_record(system: StateSpace) -> dict[str, Any]:
    return {name: getattr(system, name).tolist() for name in _MATRICES} | {"period": system.period}


def _system(record: Mapping[str, Any]) -> StateSpace:
    matrices = {name: np.array(record[name], dtype=np.float64) for name in _MATRICES}
    return StateSpace(**matrices, period=record["period"])


def _engine_name(engine: Any) -> str:
    """Name of a QP engine, or "module:attribute" of one from outside."""
    target = f"{getattr(engine, '__module__', '')}:{getattr(engine, '__qualname__', '')}"
    return next((name for name, entry in registry.SOLVERS.items() if entry.target == target), target)


def _engine(name: str) -> Any:
    return registry.SOLVERS[name].load() if name in registry.SOLVERS else load_target("engine", name)
