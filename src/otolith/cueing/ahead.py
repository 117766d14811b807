"""Decides for the moment at which a command takes effect, on a platform whose timing may be imprecise.

Notation: T lag, d dead time, Δ period; q = p + T v and w = v + T a as in `otolith.safety.law`.

*Dead time.* A decision at t takes effect at t + d. Until then the earlier commands act. The estimated state
is propagated exactly under them, and from there the algorithm decides as if there were no dead time (a Smith
predictor in state space; Smith, 1957).

*Estimated state.* Measured motion is not adopted directly. If the real lag or dead time differs from the
file, the measured motion and the effect of the commands differ for a moment, by up to (T + d) |u| in w and (T
+ d) |v| in q, and then agree again, because ẇ = u whatever the lag. A controller that adopts the momentary
difference corrects what would have passed by itself, and oscillates. So the model's own state is kept, and
drawn towards the measured state with the time constant `SETTLING`. A difference that the timing cannot
explain (another start, a supervisor that held the legs, a push) is adopted at once.

A base below the platform has an estimate of its own, with its own lag and the platform's dead time.
"""

import math
from dataclasses import replace
from typing import Any, Final, NamedTuple, cast

import numpy as np

from otolith.compiled import DECIDE, NOTHING, CompiledCueing, offered
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.core.methods import NO_METHOD, Bound, Method, hold
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


class _Estimate(NamedTuple):
    """The estimated state, and what leads from it to the moment at which a command takes effect."""

    lag: float  # T [s]
    dead_time: float  # d [s]
    period: float  # Δ [s]
    waiting: int  # commands given and not yet wholly in effect
    share: float  # as of `correct`
    given: Mat  # (K, 6) commands whose effects may still show, the latest last
    believed: Mat  # (3, 6)
    ahead: Mat  # (3, 6) where the commands on their way will have led
    fresh: Ints  # (1,) one before the first decision


class _Both(NamedTuple):
    """The estimates of a platform and of its base, and the algorithm at work."""

    inner: Method
    own: _Estimate
    base: _Estimate
    based: bool  # whether the algorithm moves a base
    ahead: Mat  # (3, 6), or with a base (6, 6): the memory of `ahead` of both estimates


@kernel
def _pass(of: Any) -> None:
    """Propagate the estimate by the period since the last decision."""
    second = of.waiting * of.period - of.dead_time  # [s] for which the later of two commands acted
    latest = len(of.given) - 1
    before, after = of.given[latest - of.waiting], of.given[latest - max(0, of.waiting - 1)]
    move(of.believed, before, of.lag, of.period - second)
    move(of.believed, after, of.lag, second)


@kernel
def _estimate(of: Any, motion: Mat) -> int:
    """Correct the estimate by a measured motion (3, 6), and propagate it; NaN if it is not plausible."""
    if of.fresh[0] == 0:
        _pass(of)
    of.fresh[0] = 0
    plausible = True
    for row in range(3):
        for axis in range(6):
            plausible = plausible and abs(motion[row, axis]) <= HUGE  # a NaN fails every comparison
            of.ahead[row, axis] = np.nan if row == 0 else 0.0
    if not plausible:
        return 0
    correct(of.believed, motion, of.given, of.lag, of.lag + of.dead_time, of.share)
    _propagate(of)
    return 0


@kernel
def _propagate(of: Any) -> None:
    """Write where the commands on their way will have led."""
    for row in range(3):
        for axis in range(6):
            of.ahead[row, axis] = of.believed[row, axis]
    first = of.dead_time - (of.waiting - 1) * of.period
    for i in range(of.waiting):
        move(of.ahead, of.given[len(of.given) - of.waiting + i], of.lag, of.period if i > 0 else first)


@kernel
def _remember(of: Any, command: Vec) -> int:
    """Append a command (6,) to those given, and drop the oldest."""
    last = len(of.given) - 1
    for axis in range(6):
        for k in range(last):
            of.given[k, axis] = of.given[k + 1, axis]
        of.given[last, axis] = command[axis]
    return 0


_inner = DECIDE.call


@kernel
def _estimate_both(of: Any, motion: Mat) -> int:
    """Estimate the motion of the platform, and that of its base if it moves."""
    _estimate(of.own, motion)
    if of.based:
        _estimate(of.base, motion[3:])
    return 0


@kernel
def _remember_both(of: Any, command: Vec) -> int:
    """Remember a command (6,) of the platform or, with a base, (12,) of both."""
    _remember(of.own, command)
    if of.based:
        _remember(of.base, command[6:])
    return 0


@kernel
def _decide(
    of: Any, motion: Mat, now: Vec, preview: Mat, age: float, again: int, command: Vec, result: Vec
) -> int:
    """Decide for a dead time from now; see `otolith.compiled.DECIDE`."""
    if again == 0:
        _estimate_both(of, motion)
    request = _inner(of.inner, (of.ahead, now, preview, age + of.own.dead_time, again, command, result))
    if request == NOTHING:
        _remember_both(of, command)
    done: int = request
    return done


class Ahead:
    """Any algorithm on a platform whose commands take effect late, or not exactly as its file states.

    Pose and twist of its commands are those at the end of the period in which they act.

    Parameters
    ----------
    lag : T [s] between commanded and actual acceleration.
    dead_time : d [s] before a command takes effect.
    base_lag : [s] that of the base, if the algorithm moves one; else it does not matter.

    Raises
    ------
    InputError : the dead time is not between 0 and 1 s.
    """

    def __init__(self, cueing: Cueing, *, lag: float, dead_time: float, base_lag: float = 0.0) -> None:
        if not 0.0 <= dead_time <= LONGEST:
            raise InputError("dead time", dead_time, f"between 0 and {LONGEST:g} s")
        self.inner, self._dead_time = cueing, dead_time
        self.carriers: int = getattr(cueing, "carriers", 1)
        ahead = np.zeros((6, 6))
        self._both = _Both(
            inner=NO_METHOD,
            own=self._estimate_of(ahead[:3], lag),
            base=self._estimate_of(ahead[3:], base_lag),
            based=self.carriers > 1,
            ahead=ahead[: 3 * self.carriers],
        )
        self._believed, self._motion = self._both.own.believed, np.zeros((3 * self.carriers, 6))
        self._held, _ = hold(self._both)
        _estimate_both(self._held, self._motion)  # compiled now, so that no decision waits for the compiler
        _remember_both(self._held, np.zeros(6 * self.carriers))
        self.reset(PlatformState())

    def _estimate_of(self, ahead: Mat, lag: float) -> _Estimate:
        """Return the estimate of one carrier at rest, whose motion a dead time from now is in `ahead`."""
        period, dead_time = self.period, self._dead_time
        count = math.ceil(dead_time / period - 1e-9)
        shown = count + 1 + math.ceil((dead_time + _LASTING * lag) / period)
        return _Estimate(
            lag=lag,
            dead_time=dead_time,
            period=period,
            waiting=count,
            share=1.0 - math.exp(-period / SETTLING),
            given=np.zeros((shown, 6)),
            believed=np.zeros((3, 6)),
            ahead=ahead,
            fresh=np.ones(1, dtype=np.int64),
        )

    @property
    def period(self) -> float:
        """Return the time between two decisions [s]."""
        return self.inner.period

    @property
    def soft(self) -> frozenset[str]:
        """Return the limits that the algorithm may pass with a penalty."""
        return frozenset(getattr(self.inner, "soft", ()))

    def reset(self, state: PlatformState) -> None:
        """Start from `state`, with no command on its way."""
        motion = np.zeros((6, 6))
        state.write(motion)
        for of, rows in ((self._both.own, motion[:3]), (self._both.base, motion[3:])):
            of.given[:], of.fresh[:], of.believed[:] = 0.0, 1, rows
            _propagate(of)
        self.inner.reset(PlatformState.of_motion(self._both.ahead, state.specific_force))

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide for a dead time from now."""
        state.write(self._motion)
        _estimate_both(self._held, self._motion)
        ahead = PlatformState.of_motion(self._both.ahead, state.specific_force)
        command = self.inner.step(ahead, self._later(reference))
        _remember_both(self._held, command.accelerations(self.carriers))
        return command

    def compiled(self) -> Bound | None:
        """Return the method of this algorithm; None if the one at work offers none."""
        inner = offered(self.inner)
        if inner is None:
            return None
        self._inner = inner  # keeps its data alive
        return DECIDE.bind(_decide, self._both._replace(inner=inner.method))

    def answer(self, request: int, reference: Reference) -> None:
        """Pass the request of the algorithm's kernel on to the algorithm."""
        cast(CompiledCueing, self.inner).answer(request, self._later(reference))

    def _later(self, reference: Reference) -> Reference:
        """Return the reference, older by the dead time: it is for a state that much later."""
        return replace(reference, age=reference.age + self._dead_time)
