"""The whole body on six legs: what the head feels and what the legs do, linearised about a plan.

Without a body, the MPC models each degree of freedom by itself: f = a + g sin(tilt), with limits per axis.
Here all axes form one body. The force felt is that at the driver's head,

    f = Rᵀ (a + R̈ h + g ẑ) − g ẑ,

with rotation and lever arm; the rates are those about the platform's own axes; and at the end of every block
there are rows on length, speed and acceleration of all legs and on the body rates. The length is taken where
it leads, L + τ L̇ with τ = speed/acceleration + lag + period: on that row a leg slows down with L̇/τ, which its
acceleration allows at every speed, and the length follows through a low-pass, without passing the bound. A
row g(q, v, a) ≤ b becomes g(x̄) + g′(x̄) (x − x̄) ≤ b with exact slopes (`otolith.platforms.leg_slopes`), so
that one step per period is a Gauss-Newton step of the nonlinear problem. What such a step misjudges is nearly
all in rows that the plan leaves further than it thinks; their price says whether a second one is worth it.

Rows of the firm blocks have a penalty so high (`FIRM`) that they are violated only where no command of this
period holds them; the outcome then says so. All rows keep a margin, since a single step is not exact; that on
accelerations is the largest, where it may be off by 0.018 m/s² after a jump.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final, NamedTuple

import numpy as np

from otolith.core.arrays import Bools, Ints, Mat, Vec, firsts
from otolith.core.frames import DOFS, Dof
from otolith.core.jit import jit_inner, kernel
from otolith.core.methods import Bound
from otolith.core.rotation import rate_along
from otolith.core.slopes import felt_slopes, rate_slopes, rotation_jet
from otolith.cueing.mpc.between_nodes import Between, Reach
from otolith.cueing.mpc.kernels import LINEARISE, MISJUDGED
from otolith.cueing.mpc.motion import Axes
from otolith.cueing.mpc.objective import Channel
from otolith.cueing.mpc.washout_weights import WashoutWeight
from otolith.platforms import Platform
from otolith.platforms.kinematics import Actuators, leg_motion
from otolith.platforms.leg_slopes import leg_slopes
from otolith.safety.law import HUGE

FIRM: Final = 1e6  # penalty of the rows of firm blocks per m, m/s, m/s² or rad/s
LATER: Final = 1e4  # and of all other blocks
MARGINS: Final = (1e-5, 1e-5, 0.02)  # [m, m/s, m/s²] kept from the limits of the first leg …
APART: Final = 0.1  # … and this share more by each of the next, see `Body.margins`
LEGS: Final = 18  # rows on length, speed and acceleration …
BODY_ROWS: Final = LEGS + 3  # … and on three body rates
# Way of a crank's tip for a way of the platform, from which on the crank is nearly stretched: its slopes
# change so fast that they say nothing of what is near.
STEEP: Final = 4.0


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
    first_output: Ints  # (C + 1,) number of non-zeros before those of a channel in a memory's `output` …
    outputs: Ints  # … and the state of each
    first_row: Ints  # (22,) the same of the body's rows in `varying`, behind the numbers of a circle
    rows: Ints
    before: Ints  # (2,) numbers of a circle in `varying`, and rows before the body's in `lower` and `upper`
    low: Vec  # (21,) bounds of the body's rows
    high: Vec  # (21,)
    price: Mat  # (M, 21) penalties of the body's rows


class _Held(NamedTuple):
    """What a method holds: one tuple, handed on without counting references to its arrays."""

    data: _Data


@jit_inner
def _motion_at(of: _Data, x: Vec, motion: Mat) -> None:
    """Write the platform's motion (3, 6) in the state x (nx,) of the model."""
    numbers = motion.reshape(-1)
    for i in range(len(x)):
        numbers[of.column[i]] = of.sign[i] * x[i]


@jit_inner
def _add(row: int, factor: float, other: int, values: Vec, slopes: Mat) -> None:
    """Add a multiple of another row to a row."""
    values[row] += factor * values[other]
    for column in range(18):
        slopes[row, column] += factor * slopes[other, column]


@jit_inner
def _enter(
    of: _Data, slopes: Vec, factor: float, states: Ints, first: int, last: int, x: Vec, out: Vec
) -> float:
    """Write the slopes of one row, times a factor, into `out`; return their product with x.

    The row's numbers are those from `first` to before `last`, and `states` are the states of all numbers.
    """
    product = 0.0
    for s in range(first, last):
        i = states[s]
        slope = factor * of.sign[i] * slopes[of.column[i]]
        out[s] = slope
        product += slope * x[i]
    return product


@kernel
def _rows_about(of: _Data, x: Vec, motion: Mat, jet: Mat, values: Vec, slopes: Mat) -> bool:
    """Write the body's rows and their slopes in a state; return whether all cranks reach its pose well."""
    _motion_at(of, x, motion)
    rotation_jet(motion, jet)
    leg_slopes(motion, jet, of.legs, values[:18], slopes[:18])
    reached = 0
    for row in range(6):
        for column in range(3):
            reached += abs(slopes[row, column]) < STEEP  # not if a rod is too short, where slopes are NaN
    for row in range(6):
        _add(row, of.lag, 6 + row, values, slopes)  # L + T L̇ …
        _add(6 + row, of.lag, 12 + row, values, slopes)  # … L̇ + T L̈ …
        _add(row, of.lead, 6 + row, values, slopes)  # … and L + T L̇ + τ (L̇ + T L̈)
    rate_slopes(motion, values[18:], slopes[18:])
    return reached == 18


@kernel
def _rows(of: _Data, X: Mat, varying: Mat, lower: Mat, upper: Mat) -> None:
    """Write the body's rows and their bounds about the motion at the ends of all blocks.

    Where a crank does not reach the pose, or is nearly stretched, they are those about the last pose before.
    """
    motion, jet = np.zeros((3, 6)), np.empty((4, 3, 3, 3))
    values, slopes, first = np.empty(BODY_ROWS), np.empty((BODY_ROWS, 18)), of.first_row
    skipped, above = of.before[0], of.before[1]
    at = of.ends[0]
    for k in range(len(of.ends)):
        if _rows_about(of, X[of.ends[k]], motion, jet, values, slopes):
            at = of.ends[k]
        else:
            _rows_about(of, X[at], motion, jet, values, slopes)
        x = X[at]
        for row in range(21):
            out = varying[k, skipped:]
            value = values[row] - _enter(of, slopes[row], 1.0, of.rows, first[row], first[row + 1], x, out)
            lower[k, above + row] = of.low[row] - value
            upper[k, above + row] = of.high[row] - value


@kernel
def _outputs(of: _Data, X: Mat, wanted: Mat, output: Mat, error: Mat) -> None:
    """Write slopes and errors of all channels about the motion of every step."""
    motion, values, slopes, first = np.zeros((3, 6)), np.empty(6), np.empty((6, 18)), of.first_output
    for k in range(len(X)):
        _motion_at(of, X[k], motion)
        felt_slopes(of.head, motion, values, slopes)
        for c in range(wanted.shape[1]):
            root, row = of.root[c], of.felt[c]
            product = _enter(of, slopes[row], root, of.outputs, first[c], first[c + 1], X[k], output[k])
            error[k, c] = root * (values[row] - wanted[k, c]) - product


@kernel
def _linearise(
    of: Any, X: Mat, wanted: Mat, output: Mat, error: Mat, varying: Mat, lower: Mat, upper: Mat
) -> int:
    """Write outputs and rows about the motion X; see `otolith.cueing.mpc.kernels.LINEARISE`."""
    _outputs(of.data, X, wanted, output, error)
    _rows(of.data, X, varying, lower, upper)
    return 0


@jit_inner
def _beyond(value: float, low: float, high: float) -> float:
    """Return how far a value is outside its bounds."""
    return max(0.0, value - high, low - value)


@kernel
def _values(of: _Data, motion: Mat, values: Vec) -> None:
    """Write the values (21,) of the body's rows alone."""
    legs, rates = np.empty((3, 6)), np.empty((1, 3))
    leg_motion(motion[0], motion[1], motion[2], of.legs, legs)
    rate_along(motion[:1], motion[1:2], rates)
    for i in range(6):
        length, speed, acceleration = legs[0, i], legs[1, i], legs[2, i]
        ahead = speed + of.lag * acceleration
        values[i] = length + of.lag * speed + of.lead * ahead
        values[6 + i], values[12 + i] = ahead, acceleration
    for i in range(3):
        values[18 + i] = rates[0, i]


@jit_inner
def _errors(of: _Data, k: int, x: Vec, output: Mat, error: Mat) -> float:
    """Return the linear problem's cost of errors in step k."""
    cost = 0.0
    for c in range(error.shape[1]):
        apart = error[k, c]
        for s in range(of.first_output[c], of.first_output[c + 1]):
            apart += output[k, s] * x[of.outputs[s]]
        cost += 0.5 * apart * apart
    return cost


@kernel
def _share(of: _Data, X: Mat, of_problem: tuple[Mat, Mat, Mat, Mat, Mat]) -> float:
    """Return `_misjudged`."""
    motion, values = np.zeros((3, 6)), np.empty(BODY_ROWS)
    output, error, varying, lower, upper = of_problem
    skipped, above, first, whole, more, step = of.before[0], of.before[1], of.first_row, 0.0, 0.0, -1
    for k in range(len(of.ends)):
        end, x = of.ends[k], X[of.ends[k]]
        whole += (end - step) * _errors(of, end, x, output, error)
        step = end
        _motion_at(of, x, motion)
        _values(of, motion, values)
        for row in range(BODY_ROWS):
            value, linear = values[row], 0.0
            for s in range(first[row], first[row + 1]):
                linear += varying[k, skipped + s] * x[of.rows[s]]
            if not abs(value) < np.inf:  # a crank does not reach the plan's pose
                return np.inf
            thought = _beyond(linear, lower[k, above + row], upper[k, above + row])
            whole += of.price[k, row] * thought
            more += of.price[k, row] * max(0.0, _beyond(value, of.low[row], of.high[row]) - thought)
    return more / whole if more > 0.0 else 0.0


@kernel
def _misjudged(of: Any, X: Mat, output: Mat, error: Mat, varying: Mat, lower: Mat, upper: Mat) -> float:
    """Return what rows of the motion X cost more in truth than the linear problem in memory says, relative.

    The whole is the linear problem's cost of errors and of these rows, each block's as at its end. See
    `otolith.cueing.mpc.kernels.MISJUDGED`.
    """
    share: float = _share(of.data, X, (output, error, varying, lower, upper))
    return share


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
    settled: float  # a smaller share of the cost misjudged ends the Gauss-Newton steps of a period

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
        of_force, of_rate = np.zeros((2, 18), dtype=bool)
        of_force[[3, 4, 5, 12, 13, 14]] = True
        of_force[[9, 10, 11, 15, 16, 17]] = self.platform.head is not None  # through its lever arm
        of_rate[[3, 4, 9, 10, 11]] = True
        column, _ = _columns(axes)
        return np.array([(of_rate if one.is_rate else of_force)[column] for one in channels])

    def methods(
        self, axes: Axes, channels: Sequence[Channel], ends: Ints, penalty: Mat, *, before: tuple[int, int]
    ) -> tuple[Bound, Bound]:
        """Return the kernels that linearise the body, and that tell what the linear problem misjudges.

        Parameters
        ----------
        penalty : (M, 21) of the body's rows.
        before : numbers that a limit circle has in `varying`, in front; constant rows and the circle's.
        """
        column, sign = _columns(axes)
        legs, (low, high) = self.platform.six_legs(), self.bounds(axes)
        head = np.zeros(3) if self.platform.head is None else np.array(self.platform.head)
        by_channel, by_row = self.output_structure(axes, channels), self.row_structure(axes)
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
            first_output=firsts(by_channel),
            outputs=np.argwhere(by_channel)[:, 1],
            first_row=firsts(by_row),
            rows=np.argwhere(by_row)[:, 1],
            before=np.array(before),
            low=low,
            high=high,
            price=np.array(penalty),
        )
        held = _Held(data)
        return LINEARISE.bind(_linearise, held), MISJUDGED.bind(_misjudged, held)

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
