"""The thesis's tables and figures, computed again and put beside the published numbers."""

from otolith_thesis.catalog import CHAPTERS, ITEMS, QUICK, chosen, reproduce
from otolith_thesis.outcome import Outcome

__all__ = ["CHAPTERS", "ITEMS", "QUICK", "Outcome", "chosen", "reproduce"]
