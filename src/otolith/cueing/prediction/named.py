"""Predictions by name, for the command line and for records of runs."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Final, Protocol

from otolith.core.errors import InputError, one_of
from otolith.core.formula import arguments
from otolith.cueing.prediction.adaptive import Adaptive
from otolith.cueing.prediction.road import Road
from otolith.cueing.prediction.simple import Decay, Hold, Oracle
from otolith.interfaces import Predictor


class Prediction(Protocol):
    """Parameters of a prediction, as a frozen dataclass of plain numbers."""

    @property
    def foresees(self) -> float:
        """Return how far ahead the loop must give forces [s]; 0 where none are needed."""

    def begin(self) -> Predictor:
        """Make a predictor without a past."""


PREDICTIONS: Final[Mapping[str, type[Any]]] = {
    "hold": Hold,
    "decay": Decay,
    "adaptive": Adaptive,
    "road": Road,
    "oracle": Oracle,
}


def parse_prediction(text: str) -> Prediction:
    """Read "name" or "name:parameter=value,…", e.g. "decay:time=0.8".

    Raises
    ------
    InputError : there is no such prediction or parameter, or a value is out of bounds.
    """
    name, _, parameters = text.partition(":")
    kind = _kind(name)
    prediction: Prediction = kind(**arguments(parameters, name, kind))
    return prediction


def prediction_to_record(prediction: Prediction) -> dict[str, Any]:
    """Return plain values of a prediction; errors are those of `parse_prediction` if it has no name here."""
    for name, kind in PREDICTIONS.items():
        if type(prediction) is kind:
            return {"name": name, **asdict(prediction)}  # type: ignore[call-overload]
    raise InputError("prediction", type(prediction).__name__, one_of(PREDICTIONS, ""))


def prediction_named(record: Mapping[str, Any]) -> Prediction:
    """Return the prediction of a record; errors are those of `parse_prediction`."""
    values = dict(record)
    prediction: Prediction = _kind(values.pop("name"))(**values)
    return prediction


def _kind(name: str) -> type[Any]:
    """Return the class of a prediction."""
    if name not in PREDICTIONS:
        raise InputError("--prediction", repr(name), one_of(PREDICTIONS, name))
    return PREDICTIONS[name]
