"""An experiment in addition to the proof: adversaries try to drive axes out of their sets.

Random states of the set are driven by *adversaries*, one for each state. They ask for the largest command,
the smallest, the two alternately, one of the two for random times, any command, or the one that leaves the
fewest commands afterwards. The command is granted as far as the set allows, as an MPC would do. In every
period the commands that lead back into the set form an interval. Periods in which it is empty are counted,
and so are nodes outside the set.

Two axes that share a circle move together. The adversary's pair of commands is drawn back towards the pair
that leads both nearest to the centre, until the next node lies in the circle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import jit_inner, kernel
from otolith.safety.invariant.axis import Axis
from otolith.safety.invariant.certificate import AxisCertificate

ADVERSARIES: Final = 6
_LEHMER: Final = 2**31 - 1
_INSIDE: Final = 1e-9  # scaled; beyond it a node is outside, or an interval empty
_WITHIN: Final = (0.25, 0.5, 0.75)  # parts of every period after which place and speed are examined
State = tuple[float, float, float]  # p, v, a


class _Model(NamedTuple):
    """P axes for the kernels, each with its facets F x ≤ 1."""

    F: Mat  # (P, m, 3)
    F_A: Mat  # (P, m, 3) the facets' forms one period later: coefficients of the state,
    F_B: Mat  # (P, m) and of the command
    A: Mat  # (P, 3, 3)
    B: Mat  # (P, 3)
    z: Mat  # (P, 3) form of the wedge
    Z_A: Mat  # (P, 3) z one period later: coefficients of the state,
    Z_B: Vec  # (P,) and of the command
    bound: Vec  # (P,) U
    W_A: Mat  # (P, k, 3) place and speed within the period over their limits: coefficients of the state,
    W_B: Mat  # (P, k) and of the command


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """The result of an experiment."""

    states: int
    steps: int
    infeasible: int  # number of periods without a command that leads back inside
    violations: int  # number of nodes outside the set
    outermost: float  # largest share of a facet's bound that any node reached; 1 is on the facet
    between: float  # largest share of a limit on place or speed that was reached between nodes

    @property
    def passed(self) -> bool:
        """Return whether every state had a command in every period and no node lay outside."""
        return self.infeasible == 0 and self.violations == 0


def drive(
    axes: Sequence[tuple[Axis, AxisCertificate]],
    *,
    circle: float = np.inf,
    states: int,
    steps: int,
    rng: np.random.Generator,
) -> Trial:
    """Drive one axis, or two that share a circle, from random states.

    Half of the states lie on the boundary of the set.

    Parameters
    ----------
    circle : radius [m] of the circle in which the axes' z stay together.
    states : number of random states.
    steps : number of periods for which each is driven.
    """
    model = _model(axes)
    X = _states(axes, circle, states, rng)
    found = np.zeros(4)
    chances = rng.integers(1, _LEHMER, size=len(X))
    if len(axes) == 1:
        _drive_one(model, X, chances, steps, found)
    else:
        _drive_two(model, X, circle, chances, steps, found)
    infeasible, violations, outermost, between = found
    return Trial(
        states=len(X),
        steps=steps,
        infeasible=int(infeasible),
        violations=int(violations),
        outermost=float(outermost),
        between=float(between),
    )


def _model(axes: Sequence[tuple[Axis, AxisCertificate]]) -> _Model:
    each = [_of_axis(*one) for one in axes]
    return _Model(*(np.ascontiguousarray(np.stack(arrays)) for arrays in zip(*each, strict=True)))


def _of_axis(axis: Axis, proved: AxisCertificate) -> tuple[Mat, ...]:
    """Return the fields of `_Model` for one axis, without the first dimension."""
    F, z = facets(proved), proved.forms[-1]
    A, B = axis.dynamics()
    low, high = axis.limits.position
    V = axis.limits.velocity
    limits = np.array([[1 / high, 0, 0], [1 / low, 0, 0], [0, 1 / V, 0], [0, -1 / V, 0]])
    within = [replace(axis, period=axis.period * part).dynamics() for part in _WITHIN]
    by_x = np.vstack([limits @ A_part for A_part, _ in within])
    by_u = np.concatenate([limits @ B_part for _, B_part in within])
    return (F, F @ A, F @ B, A, B, z, z @ A, np.array(z @ B), np.array(axis.command), by_x, by_u)


def facets(proved: AxisCertificate) -> Mat:
    """Return F (2 r, 3) of the set {x : F x ≤ 1}."""
    upper, lower = (proved.forms / bound[:, None] for bound in (proved.upper, proved.lower))
    return np.vstack([upper, lower])


def _states(
    axes: Sequence[tuple[Axis, AxisCertificate]], circle: float, states: int, rng: np.random.Generator
) -> Mat:
    """Return random states (n, P, 3) of the set; every second one is moved outwards to its boundary."""
    found, missing = [], states
    boxes = [np.vstack([cell.vertices for cell in proved.cells]) for _, proved in axes]
    while missing > 0:
        X = np.stack([rng.uniform(box.min(axis=0), box.max(axis=0), (states, 3)) for box in boxes], axis=1)
        size = _size(axes, circle, X)
        inside = X[size <= 1.0][:missing]
        found.append(inside)
        missing -= len(inside)
    X = np.concatenate(found)
    X[::2] /= _size(axes, circle, X[::2])[:, None, None]
    return X


def _size(axes: Sequence[tuple[Axis, AxisCertificate]], circle: float, X: Mat) -> Vec:
    """Return the factor by which the set must grow to reach each state of X (n, P, 3)."""
    of_axes = [(X[:, i] @ facets(proved).T).max(axis=1) for i, (_, proved) in enumerate(axes)]
    z = np.stack([X[:, i] @ proved.forms[-1] for i, (_, proved) in enumerate(axes)])
    size: Vec = np.maximum(np.max(of_axes, axis=0), np.linalg.norm(z, axis=0) / circle)
    return size


@jit_inner
def _dot(form: Mat, i: int, x: State) -> float:
    value: float = form[i, 0] * x[0] + form[i, 1] * x[1] + form[i, 2] * x[2]
    return value


@jit_inner
def _form(forms: Mat, i: int, k: int, x: State) -> float:
    value: float = forms[i, k, 0] * x[0] + forms[i, k, 1] * x[1] + forms[i, k, 2] * x[2]
    return value


@jit_inner
def _interval(model: _Model, i: int, x: State) -> tuple[float, float]:
    """Return the commands that lead axis i from x back into its set; if there are none, low > high."""
    low, high = -model.bound[i], model.bound[i]
    for k in range(model.F.shape[1]):
        by_u, room = model.F_B[i, k], 1.0 - _form(model.F_A, i, k, x)
        if by_u > 0.0:
            high = min(high, room / by_u)
        elif by_u < 0.0:
            low = max(low, room / by_u)
    return low, high


@jit_inner
def _next(model: _Model, i: int, x: State, u: float) -> State:
    return (
        _form(model.A, i, 0, x) + model.B[i, 0] * u,
        _form(model.A, i, 1, x) + model.B[i, 1] * u,
        _form(model.A, i, 2, x) + model.B[i, 2] * u,
    )


@jit_inner
def _fewest(model: _Model, i: int, x: State, low: float, high: float) -> float:
    """Return the end of the interval after which fewer commands are left."""
    low_of_low, high_of_low = _interval(model, i, _next(model, i, x, low))
    low_of_high, high_of_high = _interval(model, i, _next(model, i, x, high))
    return low if high_of_low - low_of_low < high_of_high - low_of_high else high


@jit_inner
def _ask(adversary: int, step: int, chance: int, low: float, high: float) -> float:
    """Return the command for which an adversary asks; the last adversary uses `_fewest`."""
    if adversary == 0:
        return high
    if adversary == 1:
        return low
    if adversary == 2:
        return high if step % 2 else low
    if adversary == 3:
        return high if (step // (2 + chance % 38)) % 2 else low
    return low + (high - low) * (chance / _LEHMER)


@jit_inner
def _to_circle(model: _Model, x: tuple[State, State], ends: Mat, circle: float, u: Vec) -> bool:
    """Draw commands u (2,) back until the next node is in the circle; return False if that is impossible."""
    a, b, c = 0.0, 0.0, -circle * circle
    for i in range(2):
        then, by_u = _dot(model.Z_A, i, x[i]), model.Z_B[i]
        safe = min(ends[i, 1], max(ends[i, 0], -then / by_u))
        z, step = then + by_u * safe, by_u * (u[i] - safe)
        a, b, c = a + step * step, b + z * step, c + z * z
    if c > _INSIDE * circle * circle:
        return False
    if a + 2.0 * b + c > 0.0:
        share = (-b + np.sqrt(max(0.0, b * b - a * c))) / a
        for i in range(2):
            then, by_u = _dot(model.Z_A, i, x[i]), model.Z_B[i]
            safe = min(ends[i, 1], max(ends[i, 0], -then / by_u))
            u[i] = safe + share * (u[i] - safe)
    return True


@jit_inner
def _led(model: _Model, i: int, x: State, u: float, found: Vec) -> State:
    """Return the next node of axis i; record how far it and the way to it exceed the limits."""
    for k in range(model.W_A.shape[1]):
        found[3] = max(found[3], _form(model.W_A, i, k, x) + model.W_B[i, k] * u)
    after, outermost = _next(model, i, x, u), 0.0
    for k in range(model.F.shape[1]):
        outermost = max(outermost, _form(model.F, i, k, after))
    found[2] = max(found[2], outermost)
    found[1] += outermost > 1.0 + _INSIDE
    return after


@jit_inner
def _choose(model: _Model, i: int, x: State, by: tuple[int, int, int], ends: Mat, u: Vec) -> bool:
    """Write an adversary's choice for axis i and the interval of choices; return whether it is empty."""
    low, high = _interval(model, i, x)
    ends[i, 0], ends[i, 1] = min(low, high), max(low, high)
    adversary, step, chance = by
    if adversary == ADVERSARIES - 1:
        u[i] = _fewest(model, i, x, low, high)
    else:
        u[i] = _ask(adversary, step, chance, low, high)
    empty: bool = low > high + _INSIDE * max(1.0, abs(high))
    return empty


@jit_inner
def _chance(adversary: int, chance: int) -> int:
    """Return the next random number of the adversary that draws one in each period (Park & Miller, 1988)."""
    return chance * 48271 % _LEHMER if adversary == 4 else chance


@kernel
def _drive_one(model: _Model, X: Mat, chances: Ints, steps: int, found: Vec) -> None:
    """Drive every state of X (n, 1, 3) for `steps` periods; `found` (4,) holds the counts of a `Trial`."""
    ends, u = np.empty((1, 2)), np.empty(1)
    for n in range(len(X)):
        adversary, chance = n // 2 % ADVERSARIES, chances[n]
        x = (X[n, 0, 0], X[n, 0, 1], X[n, 0, 2])
        for step in range(steps):
            chance = _chance(adversary, chance)
            found[0] += _choose(model, 0, x, (adversary, step, chance), ends, u)
            x = _led(model, 0, x, u[0], found)


@kernel
def _drive_two(model: _Model, X: Mat, circle: float, chances: Ints, steps: int, found: Vec) -> None:
    """Drive every pair of states of X (n, 2, 3), which share a circle, as `_drive_one` does."""
    ends, u = np.empty((2, 2)), np.empty(2)
    for n in range(len(X)):
        adversary, chance = n // 2 % ADVERSARIES, chances[n]
        x, y = (X[n, 0, 0], X[n, 0, 1], X[n, 0, 2]), (X[n, 1, 0], X[n, 1, 1], X[n, 1, 2])
        for step in range(steps):
            chance = _chance(adversary, chance)
            empty = _choose(model, 0, x, (adversary, step, chance), ends, u)
            late = step + chance % 38  # the adversary asks the second axis for something else than the first
            empty = _choose(model, 1, y, (adversary, late, chance * 7 % _LEHMER), ends, u) or empty
            found[0] += not _to_circle(model, (x, y), ends, circle, u) or empty
            x, y = _led(model, 0, x, u[0], found), _led(model, 1, y, u[1], found)
            z = _dot(model.z, 0, x) ** 2 + _dot(model.z, 1, y) ** 2
            found[1] += z > circle * circle * (1.0 + _INSIDE)
