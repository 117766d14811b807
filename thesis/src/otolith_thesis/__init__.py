"""The tables and figures of the thesis, computed again and compared with the published numbers."""

from otolith_thesis.catalog import CHAPTERS, ITEMS, QUICK, chosen, reproduce
from otolith_thesis.outcome import Outcome

__all__ = ["CHAPTERS", "ITEMS", "QUICK", "Outcome", "chosen", "reproduce"]
