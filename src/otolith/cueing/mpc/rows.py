"""The rows that keep a degree of freedom within its platform's limits.

Notation is that of `otolith.cueing.mpc.motion`: per axis place p, speed v, acceleration a and lag T; a tilt
is θ and its rate ω.

A *row* is a linear form of the states of one degree of freedom that must stay between two bounds at every
stage. All functions take the limits as `Platform.limits` returns them, one for each axis, or the axes'
`AxisSet`s in the same order.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError, one_of
from otolith.core.frames import AXES, Dof
from otolith.cueing.mpc.motion import Axes, Chain, chains, states
from otolith.platforms import AxisLimits, Braking, Platform
from otolith.safety.invariant.axis import AxisRow, AxisSet
from otolith.safety.law import HUGE

Limits = Sequence[AxisLimits]  # of every axis of one degree of freedom
REST: Final = "rest_"  # begins the name of a row that holds at the end of the horizon only
HAIR: Final = 1e-4  # [rad], 0.006 deg, far above all tolerances; see `braking_rows`


class BrakingRows(StrEnum):
    """Which rows slow the platform down as it approaches the end of its reach."""

    # Eq. C.2, and limits on the leading motion, from which the platform can always stop
    STOPPING = "stopping"
    LEADING = "leading"  # limits on the leading motion alone; nothing slows the platform until it must stop
    POSITION = "position"  # eq. C.2: s + c_v v T + ½ c_u a T² within the reach, limits at the nodes
    PRINTED = "printed"  # eqs. 4.7 and 4.8 as printed, without the position; for reproduction only
    NONE = "none"

    @property
    def leads(self) -> bool:
        """Return whether limits are imposed on the leading motion, so that the platform can always stop."""
        return self in (BrakingRows.STOPPING, BrakingRows.LEADING)

    def leads_on(self, dof: Dof) -> bool:
        """Return whether they are imposed on a degree of freedom; on an axis of its own they always are."""
        return self.leads or not dof.is_pair


def parse_braking_rows(name: str) -> BrakingRows:
    """Return the braking rows of this name; another name is an InputError that lists the known ones."""
    try:
        return BrakingRows(name)
    except ValueError:
        raise InputError("braking", repr(name), one_of(BrakingRows, name)) from None


@dataclass(frozen=True, slots=True)
class Row:
    """A row: lower ≤ coefficients · x ≤ upper, with x the states of one degree of freedom, or of all."""

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
    sets: Sequence[AxisSet],
    terminal: bool,
) -> list[Row]:
    """Return all rows of a degree of freedom in the implicit model.

    The leading motion of an axis of its own is limited whatever `kind` is: it has no braking law in a
    platform's file, except a base, which has that of the translation it carries.

    Parameters
    ----------
    sets : sets of its axes (`otolith.cueing.mpc.axis_sets`); empty if there are neither leading nor terminal
        rows.
    terminal : whether `terminal_rows` are added, for the last state.
    """
    leads = kind.leads_on(dof)
    rows = leading_rows(dof, sets) if leads else state_rows(dof, limits) + acceleration_rows(dof, limits)
    rows += [_a_hair_less(row) for row in braking_rows(dof, limits, braking, kind)]
    return rows + (terminal_rows(dof, sets) if terminal and not leads else [])


def _form(dof: Dof, **weights: float) -> Vec:
    """Return the coefficients (states,) of a row from weights of states by name."""
    form = np.zeros(len(states(dof)))
    for name, weight in weights.items():
        form[states(dof).index(name)] = weight
    return form


def _names(dof: Dof, chain: Chain) -> tuple[str, str, str]:
    """Return the names of an axis's place, speed and acceleration among the states."""
    known = states(dof)
    return known[chain.place], known[chain.speed], known[chain.acceleration]


def _either_way(name: str, form: Vec, bound: float) -> Row:
    return Row(name, form, -bound, bound)


def state_rows(dof: Dof, limits: Limits) -> list[Row]:
    """Return limits on speeds and places, which the explicit and the implicit model share (eq. 4.3)."""
    rows = []
    for chain in chains(dof):
        place, speed, _ = _names(dof, chain)
        of_axis = limits[chain.of]
        rows.append(_either_way(speed, _form(dof, **{speed: 1.0}), of_axis.velocity))
        rows.append(Row(place, _form(dof, **{place: 1.0}), *of_axis.position))
    return rows


def acceleration_rows(dof: Dof, limits: Limits) -> list[Row]:
    """Return limits on the actual accelerations, not on the commanded ones."""
    rows = []
    for chain in sorted(chains(dof), key=lambda one: one.of):
        name, bound = _names(dof, chain)[2], limits[chain.of].acceleration
        if math.isfinite(bound):
            rows.append(_either_way(name, _form(dof, **{name: 1.0}), bound))
    return rows


def leading_rows(dof: Dof, sets: Sequence[AxisSet]) -> list[Row]:
    """Return limits on the leading motion.

    From every state that keeps them, and the rows of the braking law if these are imposed, a command leads to
    another such state (`otolith.safety.invariant`). The commands are bounded by the limits on the
    accelerations, and so the accelerations stay within these limits, too.
    """
    rows = []
    for chain in chains(dof):
        place, speed, _ = _names(dof, chain)
        axis, ahead = sets[chain.of]
        rows += [
            _of_axis(dof, chain, row, name)
            for row, name in zip(axis.leading_rows(ahead), (speed, place), strict=True)
        ]
    return rows


def _of_axis(dof: Dof, chain: Chain, row: AxisRow, name: str) -> Row:
    """Turn a row of one axis into a row of its degree of freedom."""
    place, speed, acceleration = _names(dof, chain)
    form = {place: row.place, speed: row.speed, acceleration: row.acceleration}
    return Row(name, _form(dof, **form), row.lower, row.upper)


def circle_weights(surge: AxisSet) -> Vec:
    """Return the weights (3,) of velocity, position and acceleration in q + τ w, which the circle limits.

    Surge and sway share τ.
    """
    _, row = surge.axis.leading_rows(surge.ahead)
    return np.array([row.speed, row.place, row.acceleration])


def command_bounds(dof: Dof, limits: Limits, kind: BrakingRows) -> Vec:
    """Return bounds (nu,) on the commanded accelerations; `leading_rows` then bound the actual ones."""
    leads = kind.leads_on(dof)
    ordered = [limits[chain.of] for chain in chains(dof)]
    return np.array([min(one.command, one.acceleration) if leads else one.command for one in ordered])


def brakes(dof: Dof) -> bool:
    """Return whether a braking law slows a degree of freedom: a pair, or a base along surge or sway."""
    return dof.is_pair or (dof.is_base and not dof.feels_rate)


def braking_rows(dof: Dof, limits: Limits, braking: Braking, kind: BrakingRows) -> list[Row]:
    """Return rows that slow a pair, or a base, down near the ends of its reach (eqs. 4.7, 4.8; C.2).

    On its surface the position row is a stable second-order law s → limit. If c_v² / c_u ≥ 2 it is damped
    strongly enough not to overshoot, so a motion that satisfies it can stop within the reach.
    """
    if kind in (BrakingRows.NONE, BrakingRows.LEADING) or not brakes(dof):
        return []
    own = 0.0 if kind is BrakingRows.PRINTED else 1.0
    T_s, T_tilt = braking.position_s, braking.tilt_s
    translation = _form(
        dof, position=own, velocity=braking.c_v * T_s, acceleration=0.5 * braking.c_u * T_s**2
    )
    if not dof.is_pair:
        return [Row("braking_position", translation, *limits[0].position)]
    rotation = _form(
        dof, tilt=own, tilt_rate=braking.c_w * T_tilt, tilt_acceleration=0.5 * braking.c_u * T_tilt**2
    )
    travel, tilt = limits
    return [
        Row("braking_position", translation, *travel.position),
        Row("braking_tilt", rotation, *tilt.position),
    ]


def slowing_rows(dof: Dof, limits: Limits, braking: Braking, kind: BrakingRows) -> list[tuple[AxisRow, ...]]:
    """Return the braking rows of the implicit model as rows of the axes, in the order of `Dof.axes`."""
    rows = [_a_hair_less(row) for row in braking_rows(dof, limits, braking, kind)]
    found = []
    for chain in sorted(chains(dof), key=lambda one: one.of):
        forms = [(row, row.coefficients[[chain.place, chain.speed, chain.acceleration]]) for row in rows]
        found.append(
            tuple(
                AxisRow(row.name, float(p), float(v), float(a), row.lower, row.upper)
                for row, (p, v, a) in forms
                if p or v or a
            )
        )
    return found


def _a_hair_less(row: Row) -> Row:
    """Tighten the braking row of the tilt by `HAIR`; return any other row unchanged.

    A tilt that rests at its limit would have both rows active, the braking row and the limit, at every stage.
    These are twice as many rows as there are inputs to move them. So the braking row is slightly tighter.
    """
    if row.name != "braking_tilt":
        return row
    return replace(row, lower=row.lower + HAIR, upper=row.upper - HAIR)


def terminal_rows(dof: Dof, sets: Sequence[AxisSet]) -> list[Row]:
    """Return rows on the last state that place it, with the rows on every state, in the set of each axis.

    From there a command leads to another state of the set, and so on for ever. The braking rows of eq. C.2
    alone do not imply this, since in them acceleration can compensate speed.
    """
    rows = []
    for chain in sorted(chains(dof), key=lambda one: one.of):
        place = _names(dof, chain)[0]
        rows += [
            _of_axis(dof, chain, row, f"terminal_{place}_{row.name}") for row in sets[chain.of].beyond_limits
        ]
    return rows


def rest_rows(dof: Dof) -> list[Row]:
    """Return rows that ask every axis to be at rest at the end of the horizon."""
    names = [_names(dof, chain)[1] for chain in chains(dof)]
    return [Row(REST + name, _form(dof, **{name: 1.0}), 0.0, 0.0) for name in names]


def interference_rows(platform: Platform, axes: Axes, kind: BrakingRows) -> list[Row]:
    """Return rows that keep a base and the platform on it apart, over all states of a problem (nx,).

    Where the base is slowed down by eq. C.2, so is the sum, since it is of the same form: it leads to the
    bound without passing it. A platform that is not moved by this problem may be wherever it reaches.
    """
    if platform.base is None or axes.axis.max() < len(AXES):
        return []
    T, law = platform.braking.position_s, platform.braking
    slows = 0.0 if kind in (BrakingRows.NONE, BrakingRows.PRINTED) else 1.0
    rows = []
    for number, one in enumerate(platform.base.interference, start=1):
        form, others = np.zeros(3 * len(axes.axis)), one.weights.copy()
        of_axis = axes.sign * others[axes.axis]
        if not of_axis.any():
            continue
        form[axes.place] = of_axis
        form[axes.speed] = slows * law.c_v * T * of_axis
        form[axes.acceleration] = slows * 0.5 * law.c_u * T**2 * of_axis
        others[axes.axis] = 0.0
        rows.append(Row(f"interference {number}", form, -math.inf, one.at_most_m - platform.farthest(others)))
    return rows


def plausible(values: Mat) -> bool:
    """Return whether all values are finite numbers of at most `HUGE` in SI units; False for a NaN."""
    return bool(np.abs(values).max(initial=0.0) <= HUGE)
