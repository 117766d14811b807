"""Explicit problems of the axes that stand alone: heave and yaw, which no tilt can help.

Notation: x = [v s] velocity and position (heave) or rate and angle (yaw), u = a held over the period,
y = a (heave: the felt vertical force) or y = v (yaw: the felt rate), parameter ϑ = (v₀, s₀, y_ref):

    min_z  Σ_{k<N} (y_k − y_ref)² + R u_k²   s.t. x_1 … x_N, u within limits,

with y_k at the period's beginning for the force and at its end for the rate, the first that u_k moves.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.lti import condense, zero_order_hold
from otolith.mpc.explicit import ExplicitSettings
from otolith.mpqp import ParametricQp
from otolith.platforms import AxisLimits, Platform

SINGLE_AXES: Final = ("heave", "yaw")
V, S = range(2)


def single_axis_problem(limits: AxisLimits, settings: ExplicitSettings, *, tracks_rate: bool) -> ParametricQp:
    """Condense the explicit MPC of heave (tracks force) or yaw (tracks rate) into an mpQP.

    Returns
    -------
    ParametricQp : z (n,) the blocked accelerations, ϑ (3,) = [velocity, position, y_ref].
    """
    N, T = settings.horizon, settings.blocking[::2, ::2]  # (N, n), one input per stage
    A, B = zero_order_hold(np.array([[0.0, 0.0], [1.0, 0.0]]), np.array([[1.0], [0.0]]), settings.period)
    Phi, Gamma = condense(A, B, N)  # x_1 … x_N
    Gamma = Gamma @ T
    y_of_z = Gamma[:, V] if tracks_rate else T
    y_of_x = Phi[:, V] if tracks_rate else np.zeros((N, 2))
    y_of_theta = np.column_stack([y_of_x, -np.ones(N)])

    low, high = limits.position
    bounds = ((V, -limits.velocity, limits.velocity), (S, low, high))
    rows = [
        (side * Gamma[:, i], -side * Phi[:, i], side, lo, hi) for i, lo, hi in bounds for side in (1.0, -1.0)
    ]
    G = np.vstack([of_z for of_z, *_ in rows] + [np.eye(T.shape[1]), -np.eye(T.shape[1])])
    w = np.concatenate(
        [np.full(N, hi if side > 0 else -lo) for *_, side, lo, hi in rows]
        + [np.full(2 * T.shape[1], limits.acceleration)]
    )
    S_x = np.vstack([of_x for _, of_x, *_ in rows] + [np.zeros((2 * T.shape[1], 2))])
    reference = settings.reference_bound
    return ParametricQp(
        H=y_of_z.T @ y_of_z + settings.control_weight * T.T @ T,
        f=np.zeros(T.shape[1]),
        F=y_of_z.T @ y_of_theta,
        G=G,
        w=w,
        S=np.column_stack([S_x, np.zeros(len(w))]),
        lower=np.array([-limits.velocity, low, -reference]),
        upper=np.array([limits.velocity, high, reference]),
    )


def axis_problem(platform: Platform, axis: str, settings: ExplicitSettings) -> ParametricQp:
    """The explicit problem of "heave" or "yaw" on a platform; errors as `Platform.axis_limits`."""
    limits = platform.axis_limits(axis)
    widest = 10.0 * (limits.velocity if axis == "yaw" else limits.acceleration)
    bound = min(settings.reference_bound, widest)
    return single_axis_problem(limits, replace(settings, reference_bound=bound), tracks_rate=axis == "yaw")
