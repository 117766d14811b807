"""The thesis's tables, computed again and put beside the published numbers."""

from otolith.reproduce.tables import TABLES, Table, reproduce

__all__ = ["TABLES", "Table", "reproduce"]
