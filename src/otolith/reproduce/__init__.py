"""The thesis's tables and figures, computed again and put beside the published numbers."""

from otolith.reproduce.catalog import CHAPTERS, ITEMS, QUICK, chosen, reproduce
from otolith.reproduce.outcome import Outcome

__all__ = ["CHAPTERS", "ITEMS", "QUICK", "Outcome", "chosen", "reproduce"]
