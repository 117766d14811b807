"""The sets that the axes of a platform can always stay in, with the rows of an MPC's settings.

The wedge of an axis (`otolith.safety.invariant.axis`) is as short as the proof allows. A sequence of times
ahead is tried, each a tenth longer than the one before, and the first is taken with which every vertex of the
set has a command that leads back into it. If a braking law slows an axis, the sequence begins at a tenth of
that law's own time. This is far below the times at which the law acts in normal motion, so that measurement
errors cost little command.
"""

from dataclasses import replace
from typing import Final

from otolith.core.errors import InputError
from otolith.core.frames import DOFS, Dof
from otolith.cueing.mpc.rows import BrakingRows, Limits, brakes, slowing_rows
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Braking, Platform
from otolith.safety.invariant.axis import LEAST_LAG, Axis, AxisSet
from otolith.safety.invariant.contraction import certified_ahead

_PAIRS: Final = tuple(dof for dof in DOFS.values() if dof.is_pair)
_SHARE: Final = 0.1  # share of the braking law's own time that a wedge has at least


def axis_sets(
    platform: Platform, dof: Dof, kind: BrakingRows, *, lag: float, period: float
) -> tuple[AxisSet, ...]:
    """Return the sets of the axes of a degree of freedom, in the order of `Dof.axes`.

    Surge and sway of a platform with a limit circle get the same wedge, in which neither ever needs to move
    its z = q + τ w away from the centre. So both together can stay in the circle.

    Parameters
    ----------
    kind : the rows that slow the axes.
    lag : T [s].
    period : Δ [s] between two decisions.

    Raises
    ------
    InputError : the platform lacks an axis, or no motion of one keeps its limits and its braking law.
    """
    axes = axes_on(platform, dof, kind, lag=lag, period=period)
    if not axes[0].shares_circle:
        return sets_apart(dof, platform.braking, axes)
    together = tuple(axes_on(platform, pair, kind, lag=lag, period=period)[0] for pair in _PAIRS)
    shared = _ahead(dof, platform.braking, together, 0)
    return (AxisSet(axes[0], shared), *sets_apart(dof, platform.braking, axes)[1:])


def sets_with(platform: Platform, dof: Dof, settings: MpcSettings) -> tuple[AxisSet, ...]:
    """Return the sets of the axes of a degree of freedom; empty if no row comes from them."""
    if not (settings.terminal or settings.braking.leads_on(dof)):
        return ()
    lag = settings.lag_of(platform, dof)
    return axis_sets(platform, dof, settings.braking, lag=lag, period=settings.period)


def axes_on(
    platform: Platform, dof: Dof, kind: BrakingRows, *, lag: float, period: float
) -> tuple[Axis, ...]:
    """Return the axes of a platform's degree of freedom, in the order of `Dof.axes`.

    Parameters are those of `axis_sets`.
    """
    first, *others = axes_of(dof, platform.limits(dof), platform.braking, kind, lag=lag, period=period)
    circle = platform.circle is not None and dof in _PAIRS and all(map(platform.can_cue, _PAIRS))
    return (replace(first, shares_circle=circle), *others)


def axes_of(
    dof: Dof, limits: Limits, braking: Braking, kind: BrakingRows, *, lag: float, period: float
) -> tuple[Axis, ...]:
    """Return the axes of a degree of freedom as their sets need them, in the order of `Dof.axes`."""
    slowing = slowing_rows(dof, limits, braking, kind)
    return tuple(
        Axis(limits=one, lag=max(lag, LEAST_LAG), period=period, slowing=rows)
        for one, rows in zip(limits, slowing, strict=True)
    )


def sets_apart(dof: Dof, braking: Braking, axes: tuple[Axis, ...]) -> tuple[AxisSet, ...]:
    """Return the sets of axes that share no circle; errors are those of `axis_sets`."""
    return tuple(AxisSet(axis, _ahead(dof, braking, (axis,), i)) for i, axis in enumerate(axes))


def _ahead(dof: Dof, braking: Braking, axes: tuple[Axis, ...], i: int) -> float:
    """Return the wedge's time [s] of axis i of a degree of freedom and of all `axes` that share it."""
    period = axes[0].period
    own = (braking.c_v * braking.position_s, braking.c_w * braking.tilt_s)[i] if brakes(dof) else 0.0
    found = certified_ahead(axes, max(_SHARE * own, period))
    if found is None:
        raise InputError(
            f"the braking law of {dof.name}",
            f"{own:g} s",
            f"so slow that an axis with a lag of {axes[0].lag:g} s can follow it inside its limits",
        )
    return found
