"""Who is alive: silence is measured in the watcher's own time, so that a stall of the machine kills nobody.

Three watchdogs use it. The output watches the controller, which gives a sign when a decision begins and
another when its plan is published: a decision may therefore take up to two periods, and only a hung or dead
one takes longer. The supervisor watches the output, whose sign is the report of every tick. Where a page
alone commands the session, the output also watches that page.

A machine that is held up, as virtual ones are for some 10 ms now and then, holds up watcher and watched. When
it goes on, the watcher must not believe that the other alone was silent: of the time between two looks only a
bounded part counts.
"""

from typing import Final

from otolith.live.core.ladder import LATE_MOST, NO_REACTION, Reaction
from otolith.live.messages import Plan, Rung

MS: Final = 1_000_000  # [ns]
DEAD: Final = 2  # periods without a sign of life after which the controller is dead
LOOK_NS: Final = 2 * MS  # between two looks of the supervisor
OUTPUT_NS: Final = 15 * MS  # silence of the output that is a fault
PAGE_NS: Final = 5000 * MS  # silence of a page that alone commands, after which cueing ends
PAGE_LOOK_NS: Final = 100 * MS  # of the time between two looks at it that counts
OUTPUT_LATE_NS: Final = 60 * MS  # the same where the system grants no real-time scheduling


class Silence:
    """How long somebody has given no sign of life.

    Parameters
    ----------
    counts_ns : [ns] of the time between two looks that counts at most.
    """

    def __init__(self, counts_ns: int) -> None:
        self._counts_ns = counts_ns
        self._signs: tuple[int, ...] | None = None
        self._looked_ns = 0
        self._silent_ns = 0

    def look(self, now_ns: int, *signs: int) -> int:
        """Take in what was counted by now of every kind of sign; return the silence [ns] up to now."""
        if signs != self._signs:
            self._signs, self._silent_ns = signs, 0
        else:
            self._silent_ns += min(self._counts_ns, now_ns - self._looked_ns)
        self._looked_ns = now_ns
        return self._silent_ns


class ControllerWatch:
    """The output's look at the controller: it is alive, and its plans come."""

    def __init__(self) -> None:
        self._silence: Silence | None = None
        self._latest = -1  # sequence of the latest plan …
        self._since_ns = 0  # … and when it came

    def look(self, now_ns: int, beats: int, plan: Plan | None) -> Reaction:
        """Return the reaction to what came until now.

        Parameters
        ----------
        beats : number of decisions that the controller has begun.
        plan : the latest that counts.
        """
        if plan is None:
            return Reaction(Rung.RETURN, "the controller has not spoken yet")
        if self._silence is None:
            self._silence = Silence(plan.period_ns)
        if plan.sequence != self._latest:
            self._latest, self._since_ns = plan.sequence, now_ns
        silent = self._silence.look(now_ns, beats, plan.sequence)
        if silent > DEAD * plan.period_ns:
            return Reaction(Rung.RETURN, f"no sign of the controller for {silent // MS} ms")
        if now_ns - self._since_ns > LATE_MOST * plan.period_ns:
            age = (now_ns - self._since_ns) // MS
            return Reaction(Rung.RETURN, f"no plan from the controller for {age} ms")
        return NO_REACTION


class PageWatch:
    """The output's look at the page that alone commands a session: without it nobody could say stop."""

    def __init__(self) -> None:
        self._silence = Silence(PAGE_LOOK_NS)

    def look(self, now_ns: int, signs: int | None) -> Reaction:
        """Return the reaction to what came until now.

        Parameters
        ----------
        signs : of life that the page gave; None where others command, too.
        """
        if signs is None or self._silence.look(now_ns, signs) <= PAGE_NS:
            return NO_REACTION
        return Reaction(Rung.RETURN, f"no sign of the page that commands for {PAGE_NS // (1000 * MS)} s")
