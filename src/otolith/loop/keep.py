"""Where the record of a closed loop goes, part by part."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final, Protocol

import numpy as np

from otolith.loop.run import DECIDED, SAMPLED, Run

_WORDS: Final = ("status", "solver")


class Keeper(Protocol):
    """Keeps the parts of a run as they are made."""

    def add(self, part: Run) -> None:
        """Keep the next part."""

    def whole(self) -> Run:
        """Return all parts as one run."""


class InMemory:
    """Keeps a run in memory."""

    def __init__(self) -> None:
        self.parts: list[Run] = []

    def add(self, part: Run) -> None:
        """Keep the next part."""
        self.parts.append(part)

    def whole(self) -> Run:
        """Return all parts as one run."""
        if len(self.parts) > 1:
            self.parts = [joined(self.parts)]
        return self.parts[0]


def joined(parts: Sequence[Run]) -> Run:
    """Return consecutive parts as one run; what is said of a run as a whole is what the last of them says."""
    if len(parts) == 1:
        return parts[0]
    series: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in (*SAMPLED, *DECIDED)
        if name not in _WORDS and getattr(parts[0], name) is not None
    }
    series |= {name: tuple(itertools.chain(*(getattr(part, name) for part in parts))) for name in _WORDS}
    return replace(parts[-1], **series)


def kept(run: Run, keep: Keeper | None) -> Run:
    """Return a run that is in memory, or what a keeper makes of it."""
    if keep is None:
        return run
    for part in run.parts():
        keep.add(part)
    return keep.whole()
