"""One decision of the MPC, compiled: from a measured motion and what is wanted to a command.

The kernel predicts, writes the problem, solves it, takes the certified plan and checks its first command.
Without a certified plan, or if the check fails, the stopping law (`otolith.safety.law`) commands. Both the
controller's `step` and a closed loop that is compiled as a whole call this kernel.

What only Python can do is requested (`otolith.compiled`), in the order of the numbers below. The kernel
returns the number of the request, and continues from there when it is called again.
"""

from typing import Any, Final, NamedTuple

import numpy as np

from otolith.compiled import (
    CHANGES,
    DECIDED,
    FALLBACK,
    INFEASIBLE,
    INVALID,
    MISSED,
    NOTHING,
    OPTIMAL,
    PREDICT,
    REFUSED,
    RESIDUAL,
    SOLVER,
    STATUS,
)
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_inlined, kernel
from otolith.core.methods import INTEGER, VECTOR, Method, call_at
from otolith.cueing.mpc import kernels
from otolith.cueing.mpc.kernels import Given
from otolith.cueing.mpc.motion import read
from otolith.qp.engines import SOLVE, Entrance, StageMemory
from otolith.qp.structured.generate import CODES, INFO, OFFERS, PENDING
from otolith.safety.law import HUGE, allowed, to_rest
from otolith.safety.stopping import Belief, follow, observe, rest

AHEAD: Final = 1  # request for what is wanted, in `wanted`
GUESS: Final = 2  # request for a guess of the controls, in `about` and `guess`
HINT: Final = 3  # request for a hint to the structured engine
EXACT: Final = 4  # request for the answer to a problem that the structured engine has given up
ENGINE: Final = 5  # request for the answer of an engine that kernels cannot call

CONVERGED: Final = 1e-9  # Gauss-Newton steps end when no control changes by more
_REQUEST, ROUND, _CHANGES, GUESS_MISSED, GUESSED, RELAXED = range(6)  # what `Program.at` holds

_ahead = PREDICT.call
_solve = call_at(INTEGER, VECTOR)
_solve_own = SOLVE.call
_ON_REQUEST: Final = float(OFFERS.index("ON_REQUEST"))
_ASKING: Final = (CODES + PENDING).index("ASKING")
_LIMIT: Final = CODES.index("LIMIT")
_CODE, _RESIDUAL, _COUNT = (INFO.index(name) for name in ("STATUS", "RESIDUAL", "CHANGES"))


class Program(NamedTuple):
    """Everything that a decision reads and remembers: N steps, M blocks, C channels, nu commands."""

    given: Given
    memory: StageMemory
    engine: Entrance
    words: Ints  # solver status in `result` for each code of the structured engine
    predict: Method
    period: float  # [s]
    lengths: Ints  # (M,) steps of every block
    belief: Belief
    base: Belief  # of the base, if the platform has one that moves
    based: bool  # whether there is such a base
    checked: bool  # whether the first command must leave the platform able to stop
    guessing: bool  # whether there is a guess
    hinting: bool  # whether there is a hint
    rounds: int  # largest number of Gauss-Newton steps
    settled: float  # they end when no control changes by more; with legs, when less of the cost is misjudged
    firm: float  # multiplier from which a row of the body's firm blocks is violated
    x: Vec  # (nx,) the measured motion
    wanted: Mat  # (N, C)
    plan: Mat  # (N, nu) controls of the last decision
    about: Mat  # (N, nu) controls about which the problem is linearised
    guess: Mat  # (N, nu) reference of the controls in the cost, if at[GUESSED]
    U: Mat  # (M, nu) the solution of an engine that kernels cannot call
    answer: Vec  # (3,) solver status, changes and residual of that engine, as in `result`
    certified: Vec  # (2,) residual of the Gauss-Newton step before, and whether it violates firm rows
    at: Ints  # (6,) progress of the decision


@jit_inlined
def _predict(p: Any, now: Vec, preview: Mat, age: float) -> None:
    """Predict what will be wanted from the time of the state on, which is `age` [s] after `now`."""
    late = age / p.period
    coming = np.empty((len(p.wanted) + int(np.ceil(late)), 6))
    _ahead(p.predict, (now, preview, coming))
    kernels.want(p.given.felt, coming, late, p.wanted)


@jit_inlined
def _copy(of: Mat, first: int, into: Mat) -> None:
    """Copy the rows from the `first` on, and the last one again where there are no more.

    Entry by entry, since numba needs a second to compile an assignment of whole arrays.
    """
    for k in range(of.shape[0]):
        for j in range(of.shape[1]):
            into[k, j] = of[min(k + first, of.shape[0] - 1), j]


@jit_inlined
def _plausible(values: Mat) -> bool:
    """Return whether all values are finite numbers of at most `HUGE` in SI units; False for a NaN."""
    for k in range(values.shape[0]):
        for c in range(values.shape[1]):
            if not abs(values[k, c]) <= HUGE:
                return False
    return True


@jit_inlined
def _write(p: Any) -> None:
    """Write the problem about `about`; if there is a guess, it becomes the cost's reference."""
    referred = p.guess if p.guessing and p.at[GUESSED] == 1 else p.guess[:0]
    kernels.write(p.given, p.memory, p.x, p.about, p.wanted, referred)


@jit_inlined
def _run(p: Any, result: Vec) -> int:
    """Solve the problem in memory, or continue; return the request, or NOTHING if it is solved."""
    if p.engine.own[0] != 0:
        code = _solve_own(p.engine.own, (p.engine.info,))
    elif p.engine.solve != 0:
        code = _solve(p.engine.solve, (p.engine.workspace,))
    else:
        return ENGINE
    if code == _ASKING:
        return HINT
    if code == _LIMIT:
        return EXACT
    result[SOLVER] = p.words[code]
    result[RESIDUAL] = p.engine.info[_RESIDUAL] if result[SOLVER] == OPTIMAL else np.inf
    p.at[_CHANGES] += int(p.engine.info[_COUNT])
    p.at[RELAXED] = _reaches(p.engine.y, p.firm)
    return NOTHING


@jit_inlined
def _reaches(y: Mat, bound: float) -> int:
    """Return 1 if the size of a multiplier reaches a bound, else 0."""
    found = 0
    for m in range(y.shape[0]):
        for i in range(y.shape[1]):
            found |= abs(y[m, i]) >= bound
    return found


@jit_inlined
def _take(p: Any, result: Vec) -> None:
    """Take a solution that Python has found."""
    result[SOLVER], result[RESIDUAL] = p.answer[0], p.answer[2]
    p.at[_CHANGES] += int(p.answer[1])


@jit_inlined
def _spread(p: Any) -> float:
    """Write the solution's inputs of every step to `about`; return the largest change."""
    U = p.engine.U if p.engine.solve != 0 or p.engine.own[0] != 0 else p.U
    step, farthest = 0, 0.0
    for block in range(len(p.lengths)):
        for _ in range(p.lengths[block]):
            for j in range(U.shape[1]):
                farthest = max(farthest, abs(U[block, j] - p.about[step, j]))
                p.about[step, j] = U[block, j]
            step += 1
    return farthest


@jit_inlined
def _solve_all(p: Any, request: int, result: Vec) -> int:
    """Take Gauss-Newton steps until the plan converges, their number is reached, or a request arises."""
    while True:
        if request <= GUESS:
            _write(p)
            if p.hinting and p.at[ROUND] == 0 and p.engine.solve != 0:
                p.engine.offered[0] = _ON_REQUEST
        if request in (EXACT, ENGINE):
            _take(p, result)
        else:
            request = _run(p, result)
            if request != NOTHING:
                return request
        request = NOTHING
        p.at[ROUND] += 1
        if result[SOLVER] != OPTIMAL:
            if p.at[ROUND] > 1:  # the plan of the step before, in `about`, is certified
                result[SOLVER], result[RESIDUAL] = OPTIMAL, p.certified[0]
                p.at[RELAXED] = int(p.certified[1])
            return NOTHING
        p.certified[0], p.certified[1] = result[RESIDUAL], p.at[RELAXED]
        left = _spread(p)
        if p.at[ROUND] >= p.rounds:
            return NOTHING
        if p.given.judge[0] != 0:
            left = kernels.misjudged(p.given, p.memory, p.x, p.about)
        if left < p.settled:
            return NOTHING


@jit_inlined
def _stops(p: Any, command: Vec) -> bool:
    """Return whether the platform, and its base, can still stop after a command."""
    if not allowed(p.belief.believed, command, p.belief.reach):
        return False
    return not p.based or allowed(p.base.believed, command[6:], p.base.reach)


@jit_inlined
def _rest(p: Any, command: Vec) -> None:
    """Brake, platform and base alike, and forget the plan."""
    p.plan[:] = 0.0
    rest(p.belief, command)
    if p.based:
        rest(p.base, command[6:])


@jit_inlined
def _conclude(p: Any, command: Vec, result: Vec) -> None:
    """Follow the plan if it is certified and the platform can stop after its first command; else brake."""
    result[CHANGES], result[MISSED] = p.at[_CHANGES], p.at[GUESS_MISSED]
    result[STATUS] = DECIDED if result[SOLVER] == OPTIMAL else FALLBACK
    if result[STATUS] == DECIDED:
        command[:] = 0.0
        axes = p.given.axes
        for i in range(len(axes.axis)):
            command[axes.axis[i]] = axes.sign[i] * p.about[0, i]
        if p.checked and not _stops(p, command):
            result[STATUS] = REFUSED
    if result[STATUS] == DECIDED:
        if p.at[RELAXED] == 1:  # a command there is, but no plan that holds all rows of the next nodes
            result[SOLVER] = INFEASIBLE
        _copy(p.about, 0, p.plan)
        follow(p.belief, command)
        if p.based:
            follow(p.base, command[6:])
    else:
        _rest(p, command)


@kernel
def planned(p: Any, of_base: bool, result: Vec, room: Mat) -> int:
    """Write the last decision's plan and the commands that come to rest after it; return their number.

    Parameters
    ----------
    of_base : whether those of the base are wanted, instead of the platform's.
    room : (K, 6) as of `otolith.safety.stopping.Stopping.room`.
    """
    axes, given = p.given.axes, 0
    belief, first = (p.base, 6) if of_base else (p.belief, 0)
    if result[STATUS] == DECIDED:
        given = p.plan.shape[0]
        for k in range(given):
            room[k, :] = 0.0
            for i in range(len(axes.axis)):
                if first <= axes.axis[i] < first + 6:
                    room[k, axes.axis[i] - first] = axes.sign[i] * p.plan[k, i]
    return to_rest(belief.before, belief.reach, given, room)


@jit_inlined
def _observe(p: Any, motion: Mat) -> bool:
    """Adopt the state and let the drivers feel it; return False if it or what is wanted is not plausible."""
    if not (observe(p.belief, motion) and _plausible(p.wanted)):
        return False
    if p.based and not observe(p.base, motion[3:]):
        return False
    read(p.given.axes, motion, p.x)
    if len(p.given.organs.here) > 0:
        kernels.sense(p.given, p.x, p.wanted)
    # About where a plan leads, legs are misjudged least; the thesis linearises its problems without a shift.
    _copy(p.plan, 1 if p.given.judge[0] != 0 else 0, p.about)
    return True


@kernel
def decide(
    p: Any, motion: Mat, now: Vec, preview: Mat, age: float, again: int, command: Vec, result: Vec
) -> int:
    """Decide one command (6,) or, with a base, (12,), or return a request; see `otolith.compiled.DECIDE`."""
    request = p.at[_REQUEST] if again == 1 else NOTHING
    if request == NOTHING:
        p.at[:] = 0
        result[:] = 0.0
        if p.predict[0] == 0:
            p.at[_REQUEST] = AHEAD
            return AHEAD
        _predict(p, now, preview, age)
    if request <= AHEAD:
        if not _observe(p, motion):
            result[STATUS], result[RESIDUAL] = INVALID, np.inf
            _rest(p, command)
            return NOTHING
        if p.guessing:
            p.at[_REQUEST] = GUESS
            return GUESS
    request = _solve_all(p, request, result)
    p.at[_REQUEST] = request
    if request == NOTHING:
        _conclude(p, command, result)
    return request
