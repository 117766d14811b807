"""The classical washout (thesis, section 2.2.1, after Reid & Nahon, 1985).

Notation as in `otolith.cueing.washout.filters` and `drive`; K the scaling's slope. For small signals along an
axis pair with tilt θ, translation and tilt obey

    g θ = K L(s) f + g R(s)/s · K_ω ω,    a = H(s) (K f − g θ),    felt: a + g θ,

because the frame transformation takes the tilt's part out of what the travel is asked for. From f to
what is felt this is K (L + H (1 − L)), which is K wherever H or L is one: the two channels complement
each other.
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
    """High-pass translations, low-pass tilts, high-pass rotations, one bank of filters."""

    def __init__(self, task: Task, period: float) -> None:
        of, mask = task.tuning.of(tables.Classical), cued(task)
        self._pairs = pairs_of(task.dofs)
        self._moved, self._turned = np.flatnonzero(mask[:3]), np.flatnonzero(mask[3:])
        systems = [at_period_ends(translation(getattr(of, AXES[i])), period) for i in self._moved]
        systems += [one_period_late(rotation(of.rotation), period) for _ in self._turned]
        systems += [at_period_ends(tilt(of.tilt), period) for _ in self._pairs]
        self._bank = Bank(systems, period)

    def reset(self) -> None:
        """Forget the past."""
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
    """Write the tilts for low-passed forces and their derivatives, one after the other per pair."""
    angles, rates = tilt_for(low[0::2], low[1::2])
    for pair, angle, rate in zip(pairs, angles, rates, strict=True):
        motion.tilt[pair.rotation - 3] = pair.sign * angle
        motion.tilt_rate[pair.rotation - 3] = pair.sign * rate


def classical(task: Task) -> Washout:
    """The classical washout."""
    return Washout(task, ClassicalChannels(task, PERIOD))


def force_response(tuning: Tuning, pair: Dof, omega: Vec) -> Complexes:
    """From wanted to felt specific force along a pair, K (L + H (1 − L)), in continuous time.

    Small signals: below the tilt's rate limit, with the scaling's slope.

    Parameters
    ----------
    omega : (n,) [rad/s].

    Returns
    -------
    (n,), complex.
    """
    s = 1j * np.asarray(omega, dtype=np.float64)
    of = tuning.of(tables.Classical)
    H = s * translation(getattr(of, AXES[pair.translation])).frequency_response(omega)[:, 0, 0]
    L = tilt(of.tilt).frequency_response(omega)[:, 0, 0]
    response: Complexes = tuning.scaling.force.slope * (L + H * (1.0 - L))
    return response


def rate_response(tuning: Tuning, omega: Vec) -> Complexes:
    """From wanted to given angular rate, K_ω R, in continuous time; (n,) complex."""
    R: Complexes = rotation(tuning.of(tables.Classical).rotation).frequency_response(omega)[:, 0, 0]
    return tuning.scaling.rate.slope * R


def cross_response(tuning: Tuning, pair: Dof, omega: Vec) -> Complexes:
    """From wanted angular rate to felt specific force along a pair [m/s² per rad/s], (n,) complex.

    The tilt that the rotation brings is taken out again by the travel as far as H reaches: g θ (1 − H).
    """
    s = 1j * np.asarray(omega, dtype=np.float64)
    of = tuning.of(tables.Classical)
    H = s * translation(getattr(of, AXES[pair.translation])).frequency_response(omega)[:, 0, 0]
    response: Complexes = pair.sign * GRAVITY * rate_response(tuning, omega) / s * (1.0 - H)
    return response


def hold_response(omega: Vec, period: float = PERIOD, *, late: bool = False) -> Complexes:
    """What sampling adds to the response to force, or, when `late`, to those to rate; (n,) complex.

    With sinc x = sin x / x: force is held, and the acceleration is held at its mean, e^(−jωT/2) sinc³(ωT/2);
    rate is taken as straight between the samples, and reached at the period's end, e^(−jωT) sinc⁴(ωT/2).
    So half a period of delay or a whole one, and nothing else below a tenth of the sampling frequency. The
    plant's own lag comes on top.
    """
    half = 0.5 * period * np.asarray(omega, dtype=np.float64)
    sinc = np.sinc(half / np.pi)
    response: Complexes = np.exp(-2j * half) * sinc**4 if late else np.exp(-1j * half) * sinc**3
    return response
