"""The rows that keep a degree of freedom within its platform's limits.

Notation as in `otolith.cueing.mpc.motion`: per axis place p, speed v, acceleration a, lag T; θ, ω of a tilt.

A *row* is a linear form of the states of one degree of freedom that must stay between two bounds at every
stage. All functions take its limits as `Platform.limits` gives them, one for each of its axes.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError, one_of
from otolith.core.frames import Dof
from otolith.cueing.mpc.motion import Chain, chains, states
from otolith.platforms import AxisLimits, Braking
from otolith.safety.law import HUGE

Limits = Sequence[AxisLimits]  # of every axis of one degree of freedom
HAIR: Final = 1e-4  # [rad], 0.006 deg, far above all tolerances; see `braking_rows`


class BrakingRows(StrEnum):
    """Which rows slow the platform down as it nears its reach."""

    STOPPING = "stopping"  # eq. C.2, and limits on the leading motion: whoever keeps them can stop
    LEADING = "leading"  # limits on the leading motion alone: nothing slows the platform until it must stop
    POSITION = "position"  # eq. C.2: s + c_v v T + ½ c_u a T² within the reach, limits at the nodes
    PRINTED = "printed"  # eqs. 4.7 and 4.8 as printed, without the position: for reproduction only
    NONE = "none"

    @property
    def leads(self) -> bool:
        """True when limits are imposed on the leading motion, so that the platform can always stop."""
        return self in (BrakingRows.STOPPING, BrakingRows.LEADING)


def parse_braking_rows(name: str) -> BrakingRows:
    """Read an option's value, or say in one sentence what it may be."""
    try:
        return BrakingRows(name)
    except ValueError:
        raise InputError("braking", repr(name), one_of(BrakingRows, name)) from None


@dataclass(frozen=True, slots=True)
class Row:
    """lower ≤ coefficients · x ≤ upper with x the states of one degree of freedom."""

    name: str
    coefficients: Vec  # (states,)
    lower: float
    upper: float


def rows_of(
    dof: Dof,
    limits: Limits,
    braking: Braking,
    *,
    kind: BrakingRows,
    lag: float,
    period: float,
    terminal: bool,
) -> list[Row]:
    """All rows of a degree of freedom in the implicit model.

    An axis of its own has no braking law in a platform's file, so its leading motion is limited whatever
    `kind` says.

    Parameters
    ----------
    lag : T [s]; period : Δ [s] between two decisions.
    terminal : whether `terminal_rows` are added, for the last state.
    """
    if kind.leads or not dof.is_pair:
        rows = leading_rows(dof, limits, braking, lag=lag, period=period)
    else:
        rows = state_rows(dof, limits) + acceleration_rows(dof, limits)
    rows += [_a_hair_less(row) for row in braking_rows(dof, limits, braking, kind)]
    return rows + (terminal_rows(dof, limits) if terminal else [])


def _form(dof: Dof, **weights: float) -> Vec:
    """Coefficients (states,) of a row from weights of states by name."""
    form = np.zeros(len(states(dof)))
    for name, weight in weights.items():
        form[states(dof).index(name)] = weight
    return form


def _names(dof: Dof, chain: Chain) -> tuple[str, str, str]:
    """Names of an axis's place, speed and acceleration among the states."""
    known = states(dof)
    return known[chain.place], known[chain.speed], known[chain.acceleration]


def _either_way(name: str, form: Vec, bound: float) -> Row:
    return Row(name, form, -bound, bound)


def state_rows(dof: Dof, limits: Limits) -> list[Row]:
    """Limits on speeds and places, which the explicit and the implicit model share (eq. 4.3)."""
    rows = []
    for chain in chains(dof):
        place, speed, _ = _names(dof, chain)
        of_axis = limits[chain.of]
        rows.append(_either_way(speed, _form(dof, **{speed: 1.0}), of_axis.velocity))
        rows.append(Row(place, _form(dof, **{place: 1.0}), *of_axis.position))
    return rows


def acceleration_rows(dof: Dof, limits: Limits) -> list[Row]:
    """Limits on the accelerations that the platform has, not on those commanded."""
    rows = []
    for chain in sorted(chains(dof), key=lambda one: one.of):
        name, bound = _names(dof, chain)[2], limits[chain.of].acceleration
        if math.isfinite(bound):
            rows.append(_either_way(name, _form(dof, **{name: 1.0}), bound))
    return rows


def leading_rows(dof: Dof, limits: Limits, braking: Braking, *, lag: float, period: float) -> list[Row]:
    """Limits on the leading motion, from which the platform can always stop (`otolith.safety.stopping`).

    With q = p + T v and w = v + T a, T the lag: |v + 2 T a| ≤ v_max and q + τ w within the reach. While both
    hold, v follows v + 2 T a, q follows q + τ w, and p follows q, each through a low-pass; so the limits on
    v and p hold as well, between the nodes too. With T instead of 2 T the speed would run into its limit
    within one period, and a servo that follows not quite would overshoot it. τ is such that full braking
    needs no more than τ |w| (`look_ahead`). The commands' bounds, not above those on the accelerations,
    keep the accelerations.
    """
    rows = []
    for chain in chains(dof):
        place, speed, acceleration = _names(dof, chain)
        of_axis, ahead = limits[chain.of], look_ahead(dof, chain, limits, braking, period)
        of_speed = _form(dof, **{speed: 1.0, acceleration: 2.0 * lag})
        of_place = _form(dof, **{place: 1.0, speed: lag + ahead, acceleration: ahead * lag})
        rows.append(_either_way(speed, of_speed, of_axis.velocity))
        rows.append(Row(place, of_place, *of_axis.position))
    return rows


def look_ahead(dof: Dof, chain: Chain, limits: Limits, braking: Braking, period: float) -> float:
    """Time τ [s] of an axis in `leading_rows`.

    Full braking by periods Δ from the leading speed w takes at most w (Δ/2 + w/(2U)), and w is at most
    v_max, or L/τ when the reach of length L is shorter. Where a braking law slows the axis, τ is at least a
    tenth of that law's own time, far below where it acts in normal motion, so that measurement errors cost
    little command.
    """
    needed = time_to_stop(limits[chain.of], period)
    if not dof.is_pair:
        return needed
    eased = braking.c_v * braking.position_s if chain.of == 0 else braking.c_w * braking.tilt_s
    return max(needed, 0.1 * eased)


def time_to_stop(limits: AxisLimits, period: float) -> float:
    """Smallest τ with τ ≥ Δ/2 + min(v_max, L/τ)/(2U)."""
    half, bound = 0.5 * period, min(limits.command, limits.acceleration)
    room = (limits.position[1] - limits.position[0]) / (2.0 * bound)
    return min(half + limits.velocity / (2.0 * bound), 0.5 * half + math.sqrt(0.25 * half**2 + room))


def circle_weights(
    pairs: Sequence[tuple[Dof, Limits]], braking: Braking, kind: BrakingRows, *, lag: float, period: float
) -> Vec:
    """Weights (3,) of velocity, position and acceleration in the place that the limit circle holds.

    The position itself, or with `leading_rows` their q + τ w with one τ for all pairs: the way from q
    there is straight, and stays in the circle.
    """
    if not kind.leads:
        return np.array([0.0, 1.0, 0.0])
    translations = [(dof, chain, of) for dof, of in pairs for chain in chains(dof) if chain.of == 0]
    ahead = max(look_ahead(dof, chain, of, braking, period) for dof, chain, of in translations)
    return np.array([lag + ahead, 1.0, ahead * lag])


def command_bounds(dof: Dof, limits: Limits, kind: BrakingRows) -> Vec:
    """Bounds (nu,) on the commanded accelerations; next to `leading_rows` they keep the actual ones, too."""
    leads = kind.leads or not dof.is_pair
    ordered = [limits[chain.of] for chain in chains(dof)]
    return np.array([min(one.command, one.acceleration) if leads else one.command for one in ordered])


def braking_rows(dof: Dof, limits: Limits, braking: Braking, kind: BrakingRows) -> list[Row]:
    """Rows that slow a pair down as it nears its reach (eqs. 4.7, 4.8; with position: C.2).

    On its surface the position row is a stable second-order law s → limit, overdamped enough not
    to overshoot when c_v² / c_u ≥ 2, so that whoever satisfies it can stop within the reach.
    """
    if kind in (BrakingRows.NONE, BrakingRows.LEADING) or not dof.is_pair:
        return []
    own = 0.0 if kind is BrakingRows.PRINTED else 1.0
    T_s, T_tilt = braking.position_s, braking.tilt_s
    translation = _form(
        dof, position=own, velocity=braking.c_v * T_s, acceleration=0.5 * braking.c_u * T_s**2
    )
    rotation = _form(
        dof, tilt=own, tilt_rate=braking.c_w * T_tilt, tilt_acceleration=0.5 * braking.c_u * T_tilt**2
    )
    travel, tilt = limits
    return [
        Row("braking_position", translation, *travel.position),
        Row("braking_tilt", rotation, *tilt.position),
    ]


def _a_hair_less(row: Row) -> Row:
    """The braking row of the tilt within bounds tighter by `HAIR`, any other as it is.

    A tilt that waits at its limit would have both its rows active, the braking row and the limit, at
    every stage: twice as many as there are inputs to move them. So the braking row ends a hair before.
    """
    if row.name != "braking_tilt":
        return row
    return replace(row, lower=row.lower + HAIR, upper=row.upper - HAIR)


def terminal_rows(dof: Dof, limits: Limits) -> list[Row]:
    """Rows on the last state from which a platform without lag can stop within its reach.

    On v = κ (s_max − s) braking asks for κ² (s_max − s) ≤ κ² (s_max − s_min), which the command bound u
    affords for κ² = u / (s_max − s_min): without lag the wedge is invariant. With a lag it is not, nor are
    the braking rows of eq. C.2, which let the acceleration pay for the speed; those on the leading motion
    (`leading_rows`) are, whatever the lag.
    """
    rows = []
    for chain in sorted(chains(dof), key=lambda one: one.of):
        of_axis, (place, speed, _) = limits[chain.of], _names(dof, chain)
        bound, (low, high) = min(of_axis.command, of_axis.acceleration), of_axis.position
        if math.isfinite(bound):
            kappa = math.sqrt(bound / (high - low))
            form = _form(dof, **{place: 1.0, speed: 1.0 / kappa})
            rows.append(Row(f"terminal_{place}", form, low, high))
    return rows


def plausible(values: Mat) -> bool:
    """True when all values are finite numbers of at most `HUGE` in SI units; False for a NaN."""
    return bool(np.abs(values).max(initial=0.0) <= HUGE)
