"""Decides for the moment at which a command takes effect, on a platform whose timing may be imprecise.

Notation: T lag, d dead time, Δ period; q = p + T v and w = v + T a as in `otolith.safety.stopping`.

*Dead time.* A decision at t takes effect at t + d. Until then the earlier commands act. The estimated state
is propagated exactly under them, and from there the algorithm decides as if there were no dead time (a Smith
predictor in state space; Smith, 1957).

*Estimated state.* Measured motion is not adopted directly. If the real lag or dead time differs from the
file, the measured motion and the effect of the commands differ for a moment, by up to (T + d) |u| in w and (T
+ d) |v| in q, and then agree again, because ẇ = u whatever the lag. A controller that adopts the momentary
difference corrects what would have passed by itself, and oscillates. So the model's own state is kept, and
drawn towards the measured state with the time constant `SETTLING`. A difference that the timing cannot
explain (another start, a supervisor that held the legs, a push) is adopted at once.
"""

import math
from collections import deque
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.interfaces import Command, Cueing, PlatformState, Reference
from otolith.safety.law import HUGE, move

LONGEST: Final = 1.0  # [s] longest dead time
SETTLING: Final = 0.3  # [s] time constant with which a difference that the timing may explain is adopted
_LASTING: Final = 5.0  # time for which a command still has an effect, in lags


@kernel
def correct(believed: Mat, measured: Mat, commands: Mat, T: float, delay: float, share: float) -> None:
    """Draw the estimated motion (3, 6) towards the measured one, in place.

    Parameters
    ----------
    commands : (K, 6) commands whose effects may still show.
    delay : T + d [s], the largest error of the timing.
    share : share, 0 to 1, of a difference that timing may explain which is adopted now.
    """
    for i in range(6):
        largest = np.max(np.abs(commands[:, i]))
        of_w = (measured[1, i] + T * measured[2, i]) - (believed[1, i] + T * believed[2, i])
        of_p = measured[0, i] - believed[0, i]
        shown_w = min(delay * largest, max(-delay * largest, of_w))
        room = delay * (abs(believed[1, i]) + delay * largest)
        shown_p = min(room, max(-room, of_p))
        believed[1, i] += share * shown_w + (of_w - shown_w)
        believed[0, i] += share * shown_p + (of_p - shown_p)


class Ahead:
    """Any algorithm on a platform whose commands take effect late, or not exactly as its file states.

    Pose and twist of its commands are those at the end of the period in which they act.

    Parameters
    ----------
    lag : T [s] between commanded and actual acceleration.
    dead_time : d [s] before a command takes effect.

    Raises
    ------
    InputError : the dead time is not between 0 and 1 s.
    """

    def __init__(self, cueing: Cueing, *, lag: float, dead_time: float) -> None:
        if not 0.0 <= dead_time <= LONGEST:
            raise InputError("dead time", dead_time, f"between 0 and {LONGEST:g} s")
        self._cueing, self._lag, self._dead_time = cueing, lag, dead_time
        self._count = math.ceil(dead_time / cueing.period - 1e-9)  # commands not yet fully in effect
        shown = self._count + 1 + math.ceil((dead_time + _LASTING * lag) / cueing.period)
        self._given: deque[Vec] = deque(maxlen=shown)  # oldest first
        self._share = 1.0 - math.exp(-cueing.period / SETTLING)
        self._believed = np.zeros((3, 6))
        self.reset(PlatformState())
        self._observe(PlatformState())  # compiled now, so that no decision waits for the compiler
        self.reset(PlatformState())

    @property
    def period(self) -> float:
        """Return the time between two decisions [s]."""
        return self._cueing.period

    @property
    def soft(self) -> frozenset[str]:
        """Return the limits that the algorithm may pass with a penalty."""
        return frozenset(getattr(self._cueing, "soft", ()))

    def reset(self, state: PlatformState) -> None:
        """Start from `state`, with no pending command."""
        self._given.extend(np.zeros(6) for _ in range(self._given.maxlen or 0))
        self._believed[:] = np.stack([state.pose, state.twist, state.acceleration])
        self._fresh = True
        self._cueing.reset(self._ahead(state))

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide for one dead time from now."""
        if not self._fresh:
            self._pass()
        self._fresh = False
        known = self._observe(state)
        ahead = self._ahead(state) if known else _unknown()
        command = self._cueing.step(ahead, replace(reference, age=reference.age + self._dead_time))
        self._given.append(command.acceleration)
        return command

    def _pass(self) -> None:
        """Advance the estimated state by the period since the last decision."""
        second = self._count * self.period - self._dead_time  # [s] for which the later of two commands acted
        given = list(self._given)
        before, after = given[-1 - self._count], given[-self._count] if self._count else given[-1]
        move(self._believed, before, self._lag, self.period - second)
        move(self._believed, after, self._lag, second)

    def _observe(self, state: PlatformState) -> bool:
        """Correct the estimated state by a measurement; return False if the measurement is invalid."""
        measured = np.stack([state.pose, state.twist, state.acceleration])
        if not np.abs(measured).max() <= HUGE:  # a NaN fails every comparison
            return False
        delay = self._lag + self._dead_time
        correct(self._believed, measured, np.stack(self._given), self._lag, delay, self._share)
        return True

    def _ahead(self, state: PlatformState) -> PlatformState:
        """Return the state that the pending commands will have led to."""
        motion = self._believed.copy()
        first = self._dead_time - (self._count - 1) * self.period
        for i in range(self._count):
            move(motion, self._given[i - self._count], self._lag, self.period if i else first)
        return replace(state, pose=motion[0], twist=motion[1], acceleration=motion[2])


def _unknown() -> PlatformState:
    return PlatformState(pose=np.full(6, np.nan))
