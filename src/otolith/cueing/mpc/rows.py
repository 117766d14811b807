"""The rows that keep a degree of freedom within its platform's limits.

Notation as in `otolith.cueing.mpc.motion`: per axis place p, speed v, acceleration a, lag T; θ, ω of a tilt.

A *row* is a linear form of the states of one degree of freedom that must stay between two bounds at every
stage. All functions take its limits as `Platform.limits` gives them, one for each of its axes, or its
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
from otolith.core.frames import Dof
from otolith.cueing.mpc.motion import Chain, chains, states
from otolith.platforms import AxisLimits, Braking
from otolith.safety.invariant.axis import AxisRow, AxisSet
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

    def leads_on(self, dof: Dof) -> bool:
        """True when they are on a degree of freedom: on an axis of its own they always are."""
        return self.leads or not dof.is_pair


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
    sets: Sequence[AxisSet],
    terminal: bool,
) -> list[Row]:
    """All rows of a degree of freedom in the implicit model.

    An axis of its own has no braking law in a platform's file, so its leading motion is limited whatever
    `kind` says.

    Parameters
    ----------
    sets : of its axes (`otolith.cueing.mpc.axis_sets`); empty where neither leading nor terminal rows are.
    terminal : whether `terminal_rows` are added, for the last state.
    """
    leads = kind.leads_on(dof)
    rows = leading_rows(dof, sets) if leads else state_rows(dof, limits) + acceleration_rows(dof, limits)
    rows += [_a_hair_less(row) for row in braking_rows(dof, limits, braking, kind)]
    return rows + (terminal_rows(dof, sets) if terminal and not leads else [])


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


def leading_rows(dof: Dof, sets: Sequence[AxisSet]) -> list[Row]:
    """Limits on the leading motion: from whatever state keeps them, and the braking law's rows where they are
    imposed, a command leads to another one that does (`otolith.safety.invariant`).

    The commands' bounds, not above those on the accelerations, keep the accelerations.
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
    """A row of one axis as a row of its degree of freedom."""
    place, speed, acceleration = _names(dof, chain)
    form = {place: row.place, speed: row.speed, acceleration: row.acceleration}
    return Row(name, _form(dof, **form), row.lower, row.upper)


def circle_weights(surge: AxisSet) -> Vec:
    """Weights (3,) of velocity, position and acceleration in q + τ w, which the limit circle holds.

    Surge and sway share τ.
    """
    _, row = surge.axis.leading_rows(surge.ahead)
    return np.array([row.speed, row.place, row.acceleration])


def command_bounds(dof: Dof, limits: Limits, kind: BrakingRows) -> Vec:
    """Bounds (nu,) on the commanded accelerations; next to `leading_rows` they keep the actual ones, too."""
    leads = kind.leads_on(dof)
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


def slowing_rows(dof: Dof, limits: Limits, braking: Braking, kind: BrakingRows) -> list[tuple[AxisRow, ...]]:
    """The braking rows that the implicit model imposes, as rows of the axes in the order of `Dof.axes`."""
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
    """The braking row of the tilt within bounds tighter by `HAIR`, any other as it is.

    A tilt that waits at its limit would have both its rows active, the braking row and the limit, at
    every stage: twice as many as there are inputs to move them. So the braking row ends a hair before.
    """
    if row.name != "braking_tilt":
        return row
    return replace(row, lower=row.lower + HAIR, upper=row.upper - HAIR)


def terminal_rows(dof: Dof, sets: Sequence[AxisSet]) -> list[Row]:
    """Rows on the last state with which it lies in the set of each axis, next to those on every state.

    From there a command leads to another state of the set, and so on for ever. The braking rows of eq. C.2
    alone do not imply that: they let the acceleration pay for the speed.
    """
    rows = []
    for chain in sorted(chains(dof), key=lambda one: one.of):
        place = _names(dof, chain)[0]
        rows += [
            _of_axis(dof, chain, row, f"terminal_{place}_{row.name}") for row in sets[chain.of].beyond_limits
        ]
    return rows


def plausible(values: Mat) -> bool:
    """True when all values are finite numbers of at most `HUGE` in SI units; False for a NaN."""
    return bool(np.abs(values).max(initial=0.0) <= HUGE)
