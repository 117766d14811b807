"""The lamps of a live session: what its processes count, as long as it is fresh.

What a process has not said anew for half a second is unknown, and shown as such: a lamp never shows an old
value as if it were the present.
"""

from collections import deque
from collections.abc import Sequence
from typing import Any, Final

from otolith.live.messages import Plan, Vitals
from otolith.live.recorder import lamp
from otolith.live.ring import Ring

FRESH: Final = 500_000_000  # [ns] for which a value counts as the present
LATELY: Final = 10_000_000_000  # [ns] over which a lamp judges what is counted
JUMP: Final = 1_000_000_000  # [ns] of the sender's clock from which it is another clock
DECIDED: Final = ("", "decided")  # outcomes of a plan that the algorithm itself decided


class Lamps:
    """Keeps what is shown as lamps.

    Parameters
    ----------
    rings : of the log; none if the session is not logged.
    """

    def __init__(self, rings: Sequence[Ring] = ()) -> None:
        self._rings = rings
        self._vitals: Vitals | None = None
        self._plan: Plan | None = None
        self._refused = 0  # plans that the algorithm did not decide itself
        self._counted: deque[tuple[int, int, int]] = deque()  # time, missed, refused
        self._clock = _Clock()

    def vitals(self, vitals: Vitals) -> None:
        """Take what the controller shows."""
        self._vitals = vitals
        self._clock.take(vitals.time_ns, vitals.clock_ns)

    def plan(self, plan: Plan) -> None:
        """Take a plan."""
        self._plan = plan
        self._refused += len(plan.stages) > 0 and plan.outcome not in DECIDED

    def shown(self, now_ns: int) -> dict[str, Any]:
        """Return the lamps now; None is what is not known, or not known any more.

        `missed` and `gate_refused` count since the session began, `missed_lately` and `refused_lately` over
        the last 10 s. `clock` is how much later than the quickest of the last 10 to 20 s the newest packet
        came [s]. `log` is what is wrong with it, empty if nothing is.
        """
        vitals, plan = self._vitals, self._plan
        fresh = vitals is not None and now_ns - vitals.time_ns <= FRESH
        counts = {"missed": None, "gate_refused": None, "missed_lately": None, "refused_lately": None}
        heard = None if plan is None or not plan.telemetry_ns else now_ns - plan.telemetry_ns
        return {
            "telemetry_age_s": _seconds(heard),
            **(self._counts(now_ns) if fresh else counts),
            "clock": _seconds(self._clock.late) if fresh else None,
            "log": lamp(self._rings, now_ns) if self._rings else None,
        }

    def _counts(self, now_ns: int) -> dict[str, int]:
        missed = 0 if self._vitals is None else self._vitals.missed
        self._counted.append((now_ns, missed, self._refused))
        while now_ns - self._counted[0][0] > LATELY:
            self._counted.popleft()
        _, missed_before, refused_before = self._counted[0]
        return {
            "missed": missed,
            "gate_refused": self._refused,
            "missed_lately": missed - missed_before,
            "refused_lately": self._refused - refused_before,
        }


class _Clock:
    """How late packets come, by the sender's clock: against the quickest in the last 10 to 20 s.

    So neither the difference of the two clocks counts nor their drift (100 ppm are 2 ms in 20 s).
    """

    def __init__(self) -> None:
        self.late: int | None = None  # [ns]
        self._least: tuple[int, int] = (0, 0)  # [ns] of the 10 s before, and of the present ones
        self._since = 0  # [ns] the present ones

    def take(self, now_ns: int, offset: int | None) -> None:
        """Take the difference of the clocks as the newest packet came [ns]; None if the sender has none."""
        if offset is None:
            self.late = None
            return
        before, least = self._least
        if self.late is None or abs(offset - min(before, least)) > JUMP:
            before, least, self._since = offset, offset, now_ns
        elif now_ns - self._since > LATELY:
            before, least, self._since = least, offset, now_ns
        self._least = before, min(least, offset)
        self.late = offset - min(self._least)


def _seconds(time_ns: int | None) -> float | None:
    return None if time_ns is None else round(1e-9 * time_ns, 3)
