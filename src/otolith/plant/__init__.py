"""Plants: platforms that move as commanded."""

from otolith.plant.ideal import Ideal

__all__ = ["Ideal"]
