"""How motion is felt: models of the vestibular organs, and thresholds of perception."""

from otolith.perception import canals, otoliths
from otolith.perception.models import Vestibular, sense, sensing
from otolith.perception.thresholds import TILT_THRESHOLDS, TiltThreshold

__all__ = ["TILT_THRESHOLDS", "TiltThreshold", "Vestibular", "canals", "otoliths", "sense", "sensing"]
