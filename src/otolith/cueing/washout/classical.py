"""The classical washout (thesis, section 2.2.1, after Reid & Nahon, 1985).

Notation as in `otolith.cueing.washout.filters` and `feedforward`; K is the slope of the scaling. For small
signals along an axis pair with tilt θ, translation and tilt obey

    g θ = K L(s) f + g R(s)/s · K_ω ω,    a = H(s) (K f − g θ),    felt: a + g θ,

because the frame transformation subtracts the tilt's contribution from the input of the translation. From f
to the felt force this is K (L + H (1 − L)), which is K wherever H or L is one: the two channels are
complementary.
"""

from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from otolith.core.arrays import Ints, Vec
from otolith.core.frames import AXES, GRAVITY, Dof, pairs_of
from otolith.core.jit import kernel
from otolith.core.lti import Complexes, StateSpace
from otolith.cueing.washout import tuning as tables
from otolith.cueing.washout.feedforward import PERIOD, Task, Washout, cued
from otolith.cueing.washout.filters import (
    Bank,
    at_period_ends,
    one_period_late,
    rotation,
    run,
    tilt,
    translation,
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
from otolith.cueing.washout.tuning import Corners, SecondOrder, Tuning

T = TypeVar("T", bound=SecondOrder)


class _Memory(NamedTuple):
    bank: Bank  # high-pass translations, high-pass rotations, low-pass tilts
    moved: Ints  # cued axes of x, y, z
    turned: Ints  # cued axes of roll, pitch, yaw
    pairs: Pairs


@kernel
def _filter(of: Any, fresh: int, demand: Vec, motion: Vec) -> int:
    """Filter one demand; see `otolith.cueing.washout.kernels.CHANNELS`."""
    bank, n = of.bank, 0
    if fresh == 1:
        bank.x[:] = 0.0
    motion[:] = 0.0
    for axis in of.moved:
        bank.u[0, n] = demand[ACCELERATION + axis]
        n += 1
    for axis in of.turned:
        bank.u[0, n] = demand[RATE + axis]
        n += 1
    for axis in of.pairs.translation:
        bank.u[0, n] = demand[FORCE + axis]
        n += 1
    run(bank)
    ends, n = bank.y[0], 0
    for axis in of.moved:
        motion[VELOCITY + axis] = ends[n]
        n += 1
    for axis in of.turned:
        motion[TURNING + axis] = ends[n]
        n += 1
    coordinate(motion, of.pairs, ends[len(of.moved) + len(of.turned) :])
    return 0


class ClassicalTask(Task, Protocol):
    """The description of the classical washout's task; `otolith.cueing.design.Design` is one."""

    @property
    def corners(self) -> Corners:
        """Return factors of the corner frequencies."""


def _moved_and_turned(task: Task) -> tuple[Ints, Ints]:
    """Return the cued axes of x, y, z and those of roll, pitch, yaw."""
    mask = cued(task)
    return np.flatnonzero(mask[:3]), np.flatnonzero(mask[3:])


def _systems(task: ClassicalTask, period: float) -> list[StateSpace]:
    """Return the filters: high-pass translations, high-pass rotations, low-pass tilts."""
    of, by, (moved, turned) = task.tuning.of(tables.Classical), task.corners, _moved_and_turned(task)
    along = [_faster(getattr(of, AXES[i]), by.high_pass) for i in moved]
    around, tilted = _faster(of.rotation, by.high_pass), _faster(of.tilt, by.low_pass)
    systems = [at_period_ends(translation(one), period) for one in along]
    systems += [one_period_late(rotation(around), period) for _ in turned]
    return systems + [at_period_ends(tilt(tilted), period) for _ in pairs_of(task.dofs)]


def _faster(table: T, factor: float) -> T:
    """Return a filter's table with its corner frequencies times a factor."""
    corners = [name for name in type(table).model_fields if name.endswith("_radps")]
    return table.model_copy(update={name: factor * getattr(table, name) for name in corners})


class Classical(Washout):
    """The classical washout, whose corner frequencies may change while it is at work."""

    def __init__(self, task: ClassicalTask) -> None:
        moved, turned = _moved_and_turned(task)
        self._bank = Bank.of(_systems(task, PERIOD))
        memory = _Memory(self._bank, moved, turned, Pairs.of(pairs_of(task.dofs)))
        super().__init__(task, CHANNELS.bind(_filter, memory))

    def retune(self, task: ClassicalTask) -> None:
        """Use the corner frequencies of a task with the same axes from the next decision on.

        What the filters have reached stays, so velocities, tilt and tilt rate go on without a jump.
        """
        self._bank.take(_systems(task, self.period))


def classical(task: ClassicalTask) -> Washout:
    """Make the classical washout."""
    return Classical(task)


def force_response(tuning: Tuning, pair: Dof, omega: Vec) -> Complexes:
    """Return the continuous response from wanted to felt force along a pair, K (L + H (1 − L)).

    It holds for small signals: below the tilt's rate limit, with the slope of the scaling.

    Parameters
    ----------
    omega : (n,) [rad/s].

    Returns
    -------
    (n,) complex.
    """
    s = 1j * np.asarray(omega, dtype=np.float64)
    of = tuning.of(tables.Classical)
    H = s * translation(getattr(of, AXES[pair.translation])).frequency_response(omega)[:, 0, 0]
    L = tilt(of.tilt).frequency_response(omega)[:, 0, 0]
    response: Complexes = tuning.scaling.force.slope * (L + H * (1.0 - L))
    return response


def rate_response(tuning: Tuning, omega: Vec) -> Complexes:
    """Return the continuous response from wanted to commanded angular rate, K_ω R; (n,) complex."""
    R: Complexes = rotation(tuning.of(tables.Classical).rotation).frequency_response(omega)[:, 0, 0]
    return tuning.scaling.rate.slope * R


def cross_response(tuning: Tuning, pair: Dof, omega: Vec) -> Complexes:
    """Return the response from wanted angular rate to felt force along a pair [m/s² per rad/s], (n,) complex.

    The translation compensates the tilt that the rotation brings as far as H reaches: g θ (1 − H).
    """
    s = 1j * np.asarray(omega, dtype=np.float64)
    of = tuning.of(tables.Classical)
    H = s * translation(getattr(of, AXES[pair.translation])).frequency_response(omega)[:, 0, 0]
    response: Complexes = pair.sign * GRAVITY * rate_response(tuning, omega) / s * (1.0 - H)
    return response


def hold_response(omega: Vec, period: float = PERIOD, *, late: bool = False) -> Complexes:
    """Return the effect of sampling on the response to force or, if `late`, to rate; (n,) complex.

    With sinc x = sin x / x: force is held, and the acceleration is held at its mean, e^(−jωT/2) sinc³(ωT/2).
    Rate is linear between samples and reached at the end of the period, e^(−jωT) sinc⁴(ωT/2). So the delay is
    half a period or one period, with no other effect below a tenth of the sampling frequency. The plant's own
    lag is added to it.
    """
    half = 0.5 * period * np.asarray(omega, dtype=np.float64)
    sinc = np.sinc(half / np.pi)
    response: Complexes = np.exp(-2j * half) * sinc**4 if late else np.exp(-1j * half) * sinc**3
    return response
