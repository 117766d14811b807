"""The classical washout (thesis, section 2.2.1, after Reid & Nahon, 1985).

Notation as in `otolith.cueing.washout.filters` and `feedforward`; K is the slope of the scaling. For small
signals along an axis pair with tilt θ, translation and tilt obey

    g θ = K L(s) f + g R(s)/s · K_ω ω,    a = H(s) (K f − g θ),    felt: a + g θ,

because the frame transformation subtracts the tilt's contribution from the input of the translation. From f
to the felt force this is K (L + H (1 − L)), which is K wherever H or L is one: the two channels are
complementary.
"""

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.frames import AXES, GRAVITY, Dof, pairs_of
from otolith.core.lti import Complexes
from otolith.cueing.washout import tuning as tables
from otolith.cueing.washout.feedforward import PERIOD, Demand, Motion, Task, Washout, cued, tilt_for
from otolith.cueing.washout.filters import Bank, at_period_ends, one_period_late, rotation, tilt, translation
from otolith.cueing.washout.tuning import Tuning


class ClassicalChannels:
    """High-pass translations, low-pass tilts and high-pass rotations in one bank of filters."""

    def __init__(self, task: Task, period: float) -> None:
        of, mask = task.tuning.of(tables.Classical), cued(task)
        self._pairs = pairs_of(task.dofs)
        self._moved, self._turned = np.flatnonzero(mask[:3]), np.flatnonzero(mask[3:])
        systems = [at_period_ends(translation(getattr(of, AXES[i])), period) for i in self._moved]
        systems += [one_period_late(rotation(of.rotation), period) for _ in self._turned]
        systems += [at_period_ends(tilt(of.tilt), period) for _ in self._pairs]
        self._bank = Bank(systems, period)

    def reset(self) -> None:
        """Discard the past."""
        self._bank.reset()

    def step(self, demand: Demand) -> Motion:
        """Filter one demand."""
        pairs, moved, turned = self._pairs, self._moved, self._turned
        low = [demand.force_driver[pair.translation] for pair in pairs]
        ends = self._bank.step(
            np.concatenate([demand.acceleration_world[moved], demand.rate_world[turned], low])
        )
        motion = Motion()
        motion.velocity[moved] = ends[: len(moved)]
        motion.turning[turned] = ends[len(moved) : len(moved) + len(turned)]
        coordinate(motion, pairs, ends[len(moved) + len(turned) :])
        return motion


def coordinate(motion: Motion, pairs: tuple[Dof, ...], low: Vec) -> None:
    """Write the tilts for low-passed forces and their derivatives, which alternate by pair."""
    angles, rates = tilt_for(low[0::2], low[1::2])
    for pair, angle, rate in zip(pairs, angles, rates, strict=True):
        motion.tilt[pair.rotation - 3] = pair.sign * angle
        motion.tilt_rate[pair.rotation - 3] = pair.sign * rate


def classical(task: Task) -> Washout:
    """Make the classical washout."""
    return Washout(task, ClassicalChannels(task, PERIOD))


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
