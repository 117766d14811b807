"""Predictors: what an MPC assumes about the future of what should be felt."""

from otolith.cueing.prediction.adaptive import Adaptive
from otolith.cueing.prediction.named import PREDICTIONS, Prediction, parse_prediction, prediction_named
from otolith.cueing.prediction.road import Road
from otolith.cueing.prediction.simple import Decay, Hold, Oracle

__all__ = [
    "PREDICTIONS",
    "Adaptive",
    "Decay",
    "Hold",
    "Oracle",
    "Prediction",
    "Road",
    "parse_prediction",
    "prediction_named",
]
