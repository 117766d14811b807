"""The whole body on six legs: what the head feels and what the legs do, linearised about a plan.

Without a body, the MPC models each degree of freedom by itself: f = a + g sin(tilt), with limits per axis.
Here all axes form one body. The force felt is that at the driver's head,

    f = Rᵀ (a + R̈ h + g ẑ) − g ẑ,

with rotation and lever arm; the rates are those about the platform's own axes; and at the end of every block
there are rows on length, speed and acceleration of all legs and on the body rates. The length is taken where
it leads, L + τ L̇ with τ = speed/acceleration + lag + period: on that row a leg slows down with L̇/τ, which its
acceleration allows at every speed, and the length follows through a low-pass, without passing the bound. A
row g(q, v, a) ≤ b becomes g(x̄) + g′(x̄) (x − x̄) ≤ b with exact slopes (`otolith.platforms.leg_slopes`), so
that one step per period is a Gauss-Newton step of the nonlinear problem.

Rows of the firm blocks have a penalty so high (`FIRM`) that they are violated only where no command of this
period holds them; the outcome then says so. All rows keep a margin, since a single step is not exact; that on
accelerations is the largest, where it may be off by 0.018 m/s² after a jump.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec
from otolith.core.frames import DOFS, Dof
from otolith.core.jit import kernel
from otolith.core.methods import Bound
from otolith.core.slopes import felt_slopes, rate_slopes, rotation_jet
from otolith.cueing.mpc.between_nodes import Between, Reach
from otolith.cueing.mpc.kernels import LINEARISE
from otolith.cueing.mpc.motion import Axes
from otolith.cueing.mpc.objective import Channel
from otolith.cueing.mpc.washout_weights import WashoutWeight
from otolith.platforms import Platform
from otolith.platforms.kinematics import Actuators
from otolith.platforms.leg_slopes import leg_slopes
from otolith.safety.law import HUGE

FIRM: Final = 1e6  # penalty of the rows of firm blocks per m, m/s, m/s² or rad/s
LATER: Final = 1e4  # and of all other blocks
MARGINS: Final = (1e-5, 1e-5, 0.02)  # [m, m/s, m/s²] kept from the limits of the first leg …
APART: Final = 0.1  # … and this share more by each of the next, see `Body.margins`
LEGS: Final = 18  # rows on length, speed and acceleration …
BODY_ROWS: Final = LEGS + 3  # … and on three body rates


class _Data(NamedTuple):
    """What the kernel reads; nu axes, nx states, C channels, M blocks."""

    axes: Axes
    column: Ints  # (nx,) which of 18 numbers of a motion (pose, twist, acceleration) a state is
    sign: Vec  # (nx,) of the state relative to the platform's motion
    head: Vec  # (3,) [m]
    legs: Actuators
    lead: float  # τ [s]
    lag: float  # T [s]
    ends: Ints  # (M,) last step of every block
    felt: Ints  # (C,) which of three forces and three body rates a channel feels
    root: Vec  # (C,) square root of its weight
    outputs: Ints  # (non-zeros, 2) channel and state of the numbers in a memory's `output`
    rows: (
        Ints  # (non-zeros, 2) row of the body and state of the numbers in `varying`, behind those of a circle
    )
    before: Ints  # (2,) numbers of a circle in `varying`, and rows before the body's in `lower` and `upper`
    low: Vec  # (21,) bounds of the body's rows
    high: Vec  # (21,)


@kernel
def _motion_at(of: Any, x: Vec, motion: Mat) -> None:
    """Write the platform's motion (3, 6) in the state x (nx,) of the model."""
    for i in range(len(x)):
        column = of.column[i]
        motion[column // 6, column % 6] = of.sign[i] * x[i]


@kernel
def _add(row: int, factor: float, other: int, values: Vec, slopes: Mat) -> None:
    """Add a multiple of another row to a row."""
    values[row] += factor * values[other]
    for column in range(18):
        slopes[row, column] += factor * slopes[other, column]


@kernel
def _rows(of: Any, X: Mat, varying: Mat, lower: Mat, upper: Mat) -> None:
    """Write the body's rows and their bounds about the motion at the ends of all blocks."""
    motion, jet = np.zeros((3, 6)), np.empty((4, 3, 3, 3))
    values, slopes = np.empty(21), np.empty((21, 18))
    skipped, above = of.before[0], of.before[1]
    for k in range(len(of.ends)):
        x = X[of.ends[k]]
        _motion_at(of, x, motion)
        rotation_jet(motion, jet)
        leg_slopes(motion, jet, of.legs, values[:18], slopes[:18])
        for row in range(6):
            _add(row, of.lag, 6 + row, values, slopes)  # L + T L̇ …
            _add(6 + row, of.lag, 12 + row, values, slopes)  # … L̇ + T L̈ …
            _add(row, of.lead, 6 + row, values, slopes)  # … and L + T L̇ + τ (L̇ + T L̈)
        rate_slopes(motion, values[18:], slopes[18:])
        for s in range(len(of.rows)):
            row, i = of.rows[s, 0], of.rows[s, 1]
            slope = of.sign[i] * slopes[row, of.column[i]]
            varying[k, skipped + s] = slope
            values[row] -= slope * x[i]
        for row in range(21):
            lower[k, above + row] = of.low[row] - values[row]
            upper[k, above + row] = of.high[row] - values[row]


@kernel
def _outputs(of: Any, X: Mat, wanted: Mat, output: Mat, error: Mat) -> None:
    """Write slopes and errors of all channels about the motion of every step."""
    motion, values, slopes = np.zeros((3, 6)), np.empty(6), np.empty((6, 18))
    for k in range(len(X)):
        _motion_at(of, X[k], motion)
        felt_slopes(of.head, motion, values, slopes)
        for c in range(wanted.shape[1]):
            error[k, c] = of.root[c] * (values[of.felt[c]] - wanted[k, c])
        for s in range(len(of.outputs)):
            c, i = of.outputs[s, 0], of.outputs[s, 1]
            slope = of.root[c] * of.sign[i] * slopes[of.felt[c], of.column[i]]
            output[k, s] = slope
            error[k, c] -= slope * X[k, i]


@kernel
def _linearise(
    of: Any, X: Mat, wanted: Mat, output: Mat, error: Mat, varying: Mat, lower: Mat, upper: Mat
) -> int:
    """Write outputs and rows about the motion X; see `otolith.cueing.mpc.kernels.LINEARISE`."""
    _outputs(of, X, wanted, output, error)
    _rows(of, X, varying, lower, upper)
    return 0


@dataclass(frozen=True, kw_only=True)
class Body:
    """A platform on six legs as one body, with weights per degree of freedom.

    Raises
    ------
    InputError : the platform's file describes no legs.
    """

    platform: Platform
    washout: Mapping[str, tuple[WashoutWeight, ...]]  # by name of the degree of freedom
    weights: Mapping[str, float]  # of squared errors, by name of the degree of freedom
    period: float  # [s] between two decisions
    lag: float  # T [s] between commanded and actual acceleration
    # [m/s² or rad/s²] a change of all controls by less ends the Gauss-Newton steps of a period
    settled: float

    @property
    def lead(self) -> float:
        """Return τ [s], with which the rows on lengths look ahead."""
        legs = self.platform.six_legs()
        return float(legs.speed / legs.acceleration + self.lag + self.period)

    @cached_property
    def between(self) -> Between:
        """Return how far legs may go beyond their rows between two nodes."""
        place, speed, acceleration = np.zeros((2, 6)), np.zeros(6), np.zeros(6)
        for dof in (DOFS[name] for name in self.washout):
            limits = self.platform.limits(dof)
            for axis, sign, of_axis in zip(dof.axes, dof.signs, limits, strict=True):
                place[:, axis] = np.sort(sign * np.array(of_axis.position))
                speed[axis] = of_axis.velocity
                acceleration[axis] = min(of_axis.acceleration, HUGE)
        reach = Reach(place, speed, acceleration)
        legs = self.platform.six_legs()
        return Between.of(legs, reach, lead=self.lead, lag=self.lag, period=self.period)

    @property
    def margins(self) -> Mat:
        """Return what rows keep from the limits on length, speed and acceleration of every leg (3, 6).

        They differ from leg to leg. On a drive along x the legs of either side move alike, and with equal
        margins would reach their limits together: rows of equal bounds and nearly equal slopes, at which 41
        of 14,400 problems of such drives found no certified answer.
        """
        margins: Mat = np.outer(MARGINS, 1.0 + APART * np.arange(6)) + np.array(self.between)[:, None]
        return margins

    def weighed(self, channels: Sequence[Channel], dofs: Sequence[Dof]) -> list[Channel]:
        """Return the channels with these weights; their rates are those about the platform's own axes."""
        weights = (self.weights.get(dofs[one.of].name, one.weight) for one in channels)
        return [replace(one, weight=weight, sign=1.0) for one, weight in zip(channels, weights, strict=True)]

    def penalties(self, horizon: int, hard_steps: int) -> Mat:
        """Return the penalties (N, 21) of the body's rows."""
        firm = np.arange(horizon)[:, None] < hard_steps
        return np.broadcast_to(np.where(firm, FIRM, LATER), (horizon, BODY_ROWS)).copy()

    def row_structure(self, axes: Axes) -> Bools:
        """Return on which of the states of x each of the body's rows may depend (21, nx)."""
        of_motion = np.zeros((BODY_ROWS, 18), dtype=bool)
        of_motion[:18] = True
        of_motion[18:, [3, 4]] = of_motion[18:, 9:12] = True
        found: Bools = of_motion[:, _columns(axes)[0]]
        return found

    def output_structure(self, axes: Axes, channels: Sequence[Channel]) -> Bools:
        """Return which of the states of x each channel may depend on (C, nx)."""
        of_force, of_rate = np.ones(18, dtype=bool), np.zeros(18, dtype=bool)
        of_force[6:12], of_force[[0, 1, 2]] = self.platform.head is not None, False
        of_rate[[3, 4, 9, 10, 11]] = True
        column, _ = _columns(axes)
        return np.array([(of_rate if one.is_rate else of_force)[column] for one in channels])

    def method(
        self, axes: Axes, channels: Sequence[Channel], ends: Ints, *, circles: int, rows_before: int
    ) -> Bound:
        """Return the kernel that linearises the body.

        Parameters
        ----------
        circles : numbers that a limit circle has in `varying`, in front.
        rows_before : constant rows and the circle's.
        """
        column, sign = _columns(axes)
        legs, (low, high) = self.platform.six_legs(), self.bounds(axes)
        head = np.zeros(3) if self.platform.head is None else np.array(self.platform.head)
        data = _Data(
            axes=axes,
            column=column,
            sign=sign,
            head=head,
            legs=legs.actuators,
            lead=self.lead,
            lag=self.lag,
            ends=ends,
            felt=np.array([one.column for one in channels]),
            root=np.sqrt([one.weight for one in channels]),
            outputs=np.argwhere(self.output_structure(axes, channels)),
            rows=np.argwhere(self.row_structure(axes)),
            before=np.array([circles, rows_before]),
            low=low,
            high=high,
        )
        return LINEARISE.bind(_linearise, data)

    def bounds(self, axes: Axes) -> tuple[Vec, Vec]:
        """Return the bounds (21,) of the body's rows; a rate about an axis that is not cued has none."""
        legs, rates = self.platform.six_legs(), np.full(3, np.inf)
        for dof in DOFS.values():
            if dof.axes[-1] >= 3 and dof.axes[-1] in axes.axis:
                rates[dof.axes[-1] - 3] = self.platform.limits(dof)[-1].velocity
        of_length, of_speed, of_acceleration = self.margins
        moving = (legs.speed - of_speed, legs.acceleration - of_acceleration, rates)
        low, high = (
            np.concatenate([end - sign * of_length, *(sign * side for side in moving)])
            for end, sign in zip(legs.stroke, (-1, 1), strict=True)
        )
        return low, high


def _columns(axes: Axes) -> tuple[Ints, Vec]:
    """Return for each state of x which of 18 numbers of a motion it is (nx,), and its sign (nx,)."""
    nx = 3 * len(axes.axis)
    column, sign = np.zeros(nx, dtype=np.int64), np.zeros(nx)
    for order, states in enumerate((axes.place, axes.speed, axes.acceleration)):
        column[states], sign[states] = 6 * order + axes.axis, axes.sign
    return column, sign
