"""The ladder of reactions: which causes are present, how strong the reaction is, and what only a person ends.

Causes below R3 end by themselves. R3 and R4 are kept until the operator re-arms, whatever happens to their
cause: a platform that has stopped for a reason moves again when a person says so.
"""

from dataclasses import dataclass
from typing import Final

from otolith.live.messages import Rung

FAILURES: Final = 10  # decisions without an answer in a row that end cueing
LATE: Final = 3  # periods missed in a row after which only the fallback decides …
LATE_MOST: Final = 10  # … and after which cueing ends


@dataclass(frozen=True, slots=True)
class Reaction:
    """A rung, and the sentence that says why."""

    rung: Rung = Rung.NONE
    reason: str = ""


NO_REACTION: Final = Reaction()


def strongest(*reactions: Reaction) -> Reaction:
    """Return the reaction of the highest rung; of equals the first."""
    return max(reactions, key=lambda reaction: reaction.rung, default=NO_REACTION)


class Ladder:
    """Keeps what only the operator ends."""

    def __init__(self) -> None:
        self._kept = NO_REACTION

    def react(self, *reactions: Reaction) -> Reaction:
        """Keep the strongest of the present reactions if only the operator ends it; return it, or what is
        kept already and is stronger.
        """
        now = strongest(self._kept, *reactions)
        if now.rung >= Rung.RETURN:
            self._kept = now
        return now

    @property
    def kept(self) -> Reaction:
        """Return the reaction that waits for the operator; none if there is none."""
        return self._kept

    def rearm(self) -> None:
        """Forget what was kept: the operator's word."""
        self._kept = NO_REACTION


class InARow:
    """Counts how often something happened in a row.

    Parameters
    ----------
    most : count from which it is a reaction.
    """

    def __init__(self, most: int, rung: Rung, words: str) -> None:
        self.count = 0
        self._most, self._rung, self._words = most, rung, words

    def note(self, happened: bool, times: int = 1) -> Reaction:
        """Take note of one occasion on which it did or did not happen; return the reaction."""
        self.count = self.count + times if happened else 0
        return self.reaction

    @property
    def reaction(self) -> Reaction:
        """Return the reaction to the present count."""
        if self.count < self._most:
            return NO_REACTION
        return Reaction(self._rung, f"{self.count} {self._words} in a row")


class Lasting:
    """Reacts to a condition that has lasted without a break.

    Parameters
    ----------
    limit_ns : [ns] for how long it may last.
    """

    def __init__(self, limit_ns: int, rung: Rung, words: str) -> None:
        self._limit_ns, self._rung, self._words = limit_ns, rung, words
        self._since: int | None = None

    def note(self, present: bool, now_ns: int) -> Reaction:
        """Take note of whether the condition holds now; return the reaction."""
        if not present:
            self._since = None
        elif self._since is None:
            self._since = now_ns
        if self._since is None or now_ns - self._since < self._limit_ns:
            return NO_REACTION
        return Reaction(self._rung, f"{self._words} for {1e-6 * (now_ns - self._since):.0f} ms")
