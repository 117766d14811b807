"""The adaptive washout (thesis, section 2.2.3; Parrish et al., 1975; Nahon & Reid, 1990).

This is the classical washout with high-passes whose input gains P adapt, while the tilt's low-pass stays
fixed. Notation: a, q wanted acceleration and rate of an axis, s its travel, P its gain, P₀ = 1; primes are
time derivatives. Per axis

    s'' = P a − 2ζω_n s' − ω_n² s,    rotation R(s) P q,    P' = −K ∂J/∂P within [P_min, P_max],
    2 J = W₁ (a − s'')² + W₃ s'² + W₄ s² + W₇ (P − P₀)²,    for rotations W₂ (q − φ')² + W₈ (P − P₀)².

The derivatives of s and φ with respect to P obey the same filters with the input a or q (as if P were
constant, which is the usual approximation). Eq. 2.6 sums its last term over i = 1, 2 and eq. 2.7 counts i = 1
… 6. Both hold if the sum is over the two gains of one axis pair and the count over all axes, 2 + 2 + 1 + 1.
The pull back to P₀ that the literature adds to eq. 2.7 is the gradient of that last term. The motion is
bounded whatever the adaptation does: it is the output of stable linear filters with inputs bounded by P_max
a.
"""

from typing import Any, NamedTuple

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.core.frames import AXES, pairs_of
from otolith.core.jit import kernel
from otolith.core.lti import StateSpace
from otolith.cueing.washout import tuning as tables
from otolith.cueing.washout.feedforward import PERIOD, Task, Washout, cued
from otolith.cueing.washout.filters import (
    Bank,
    at_period_ends,
    denominator,
    one_period_late,
    outputs,
    rotation,
    run,
    tilt,
)
from otolith.cueing.washout.kernels import (
    ACCELERATION,
    CHANNELS,
    FORCE,
    RATE,
    TURNING,
    VELOCITY,
    Pairs,
    coordinate,
)
from otolith.cueing.washout.tuning import SecondOrder

NEUTRAL = 1.0  # P₀


def _travel(tuning: SecondOrder) -> StateSpace:
    """Return the system from acceleration to high-passed travel, velocity and acceleration."""
    return outputs([[1.0], [1.0, 0.0], [1.0, 0.0, 0.0]], denominator(tuning))


class Memory(NamedTuple):
    """High-passes with adapting gains, the same with a gain of one, low-pass tilts."""

    travel: Bank
    travel_by_gain: Bank
    turn: Bank
    turn_by_gain: Bank
    tilt: Bank
    moved: Ints  # cued axes of x, y, z
    turned: Ints  # cued axes of roll, pitch, yaw
    pairs: Pairs
    gains: Vec  # P of every translation
    rate_gains: Vec  # P of every rotation
    bounds: Vec  # (2,) least and largest gain
    weights: Vec  # (6,) W₁ force, velocity, position, gain, W₂ rate, and T
    speeds: Vec  # (2,) K of translations and of rotations


@kernel
def _adapted(of: Any, P: float, fall: float) -> float:
    """Return a gain after one Euler step down the gradient, within the bounds."""
    adapted: float = min(of.bounds[1], max(of.bounds[0], P - of.weights[5] * fall))
    return adapted


@kernel
def _translate(of: Any, demand: Vec, motion: Vec) -> None:
    """Filter the accelerations wanted, and adapt their gains."""
    W = of.weights
    for i in range(len(of.moved)):
        a = demand[ACCELERATION + of.moved[i]]
        of.travel.u[0, i], of.travel_by_gain.u[0, i] = of.gains[i] * a, a
    run(of.travel)
    run(of.travel_by_gain)
    for i in range(len(of.moved)):
        a, P = demand[ACCELERATION + of.moved[i]], of.gains[i]
        s, v, acceleration = of.travel.y[0, 3 * i], of.travel.y[0, 3 * i + 1], of.travel.y[0, 3 * i + 2]
        s_P, v_P = of.travel_by_gain.y[0, 3 * i], of.travel_by_gain.y[0, 3 * i + 1]
        slope = -W[0] * (a - acceleration) * of.travel_by_gain.y[0, 3 * i + 2] + W[1] * v * v_P
        slope += W[2] * s * s_P + W[3] * (P - NEUTRAL)
        of.gains[i] = _adapted(of, P, of.speeds[0] * slope)
        motion[VELOCITY + of.moved[i]] = v


@kernel
def _rotate(of: Any, demand: Vec, motion: Vec) -> None:
    """Filter the rates wanted, and adapt their gains."""
    W = of.weights
    for i in range(len(of.turned)):
        q = demand[RATE + of.turned[i]]
        of.turn.u[0, i], of.turn_by_gain.u[0, i] = of.rate_gains[i] * q, q
    run(of.turn)
    run(of.turn_by_gain)
    for i in range(len(of.turned)):
        q, P, turning = demand[RATE + of.turned[i]], of.rate_gains[i], of.turn.y[0, i]
        slope = -W[4] * (q - turning) * of.turn_by_gain.y[0, i] + W[3] * (P - NEUTRAL)
        of.rate_gains[i] = _adapted(of, P, of.speeds[1] * slope)
        motion[TURNING + of.turned[i]] = turning


@kernel
def step(of: Any, fresh: int, demand: Vec, motion: Vec) -> int:
    """Filter one demand and adapt the gains; see `otolith.cueing.washout.kernels.CHANNELS`."""
    if fresh == 1:
        for bank in (of.travel, of.travel_by_gain, of.turn, of.turn_by_gain, of.tilt):
            bank.x[:] = 0.0
        of.gains[:] = NEUTRAL
        of.rate_gains[:] = NEUTRAL
    motion[:] = 0.0
    _translate(of, demand, motion)
    _rotate(of, demand, motion)
    for p in range(len(of.pairs.translation)):
        of.tilt.u[0, p] = demand[FORCE + of.pairs.translation[p]]
    run(of.tilt)
    coordinate(motion, of.pairs, of.tilt.y[0])
    return 0


def memory(task: Task, period: float) -> Memory:
    """Return the filters of a task, at rest, with neutral gains."""
    of, mask, pairs = task.tuning.of(tables.Adaptive), cued(task), pairs_of(task.dofs)
    moved, turned = np.flatnonzero(mask[:3]), np.flatnonzero(mask[3:])
    travels = [at_period_ends(_travel(getattr(of, AXES[i])), period) for i in moved]
    turns = [one_period_late(rotation(of.rotation), period) for _ in turned]
    weights = (of.force_weight, of.velocity_weight, of.position_weight, of.gain_weight, of.rate_weight)
    return Memory(
        travel=Bank.of(travels),
        travel_by_gain=Bank.of(travels),
        turn=Bank.of(turns),
        turn_by_gain=Bank.of(turns),
        tilt=Bank.of([at_period_ends(tilt(of.tilt), period) for _ in pairs]),
        moved=moved,
        turned=turned,
        pairs=Pairs.of(pairs),
        gains=np.full(len(moved), NEUTRAL),
        rate_gains=np.full(len(turned), NEUTRAL),
        bounds=np.array([of.least_gain, of.largest_gain]),
        weights=np.array([*weights, period]),
        speeds=np.array([of.speed, of.rate_speed]),
    )


def adaptive(task: Task) -> Washout:
    """Make the adaptive washout."""
    return Washout(task, CHANNELS.bind(step, memory(task, PERIOD)))
