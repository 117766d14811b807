"""Numbers printed in the thesis, from the data file beside this module."""

import tomllib
from importlib.resources import files
from typing import Any


def published(table: str) -> tuple[str, list[dict[str, Any]]]:
    """Title and rows of one table, e.g. "table-5.2"; a row's keys are the file's."""
    text = (files("otolith.reproduce") / "published.toml").read_text(encoding="utf-8")
    entry = tomllib.loads(text)[table.replace(".", "-")]  # a dot would nest in TOML
    return entry["title"], entry["rows"]
