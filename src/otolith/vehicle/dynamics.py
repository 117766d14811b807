"""Equations of motion of a double-track car on a road, compiled.

Axes x forward, y left, z up, on the road's surface; wheels q in the order front left, front right, rear left,
rear right, at x_q, y_q from the centre of gravity. The state is

  0 s, 1 e, 2 χ       distance along the path [m], offset to its left [m], heading relative to it [rad]
  3 v_x, 4 v_y, 5 r   [m/s, m/s, rad/s] of the centre of gravity
  6 z, 7 ż, 8 φ, 9 φ̇, 10 θ, 11 θ̇   heave, roll, pitch of the sprung mass relative to the road
  12 δ, 13 a          steering angle of the front wheels [rad], acceleration from the actuators [m/s²]
  14…17 τ_q           tangents of the slip angles, after relaxation
  18…21 z_q, 22…25 ż_q   of the unsprung masses

Planar motion uses the path's own coordinates, ṡ = (v_x cos χ − v_y sin χ)/(1 − κ e), ė = v_x sin χ + v_y cos
χ, χ̇ = r − κ ṡ, so no point has to be projected onto the path. Vertical motion has springs, dampers, bars and
tyres. The part of a tyre's lateral force below the roll centre, and the share `anti` of its longitudinal
force, act through links on the wheels at once. Static loads follow: ΣΔF_z y_q = −(h F_y + m g (h − h_r) φ).

Tyres follow the Magic Formula (Pacejka 2012, chapter 4), F_y = −D sin(C atan(B α − E(B α − atan B α))), with
F_0 the static load, D = μ F_z (1 − μ_z (F_z/F_0 − 1)) and B C D = K F_0 sin(2 atan(F_z/(z F_0))), reduced by
the friction ellipse for the longitudinal force. Relaxation: σ τ̇ + |v| τ = lateral velocity of the contact.
"""

from typing import Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.copying import copy_to
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel
from otolith.vehicle.car import CarNumbers

STATES: Final = 26
EXTRAS: Final = 10  # f_x, f_y, z̈, φ̈, θ̈, ṙ and the four loads
SLOW: Final = 1.0  # [m/s] slip angles relax at least as fast as at this speed
ROLLING: Final = 0.1  # [m/s] speed over which resistances build up from rest


class RoadNumbers(NamedTuple):
    """The road in the form of the equations; rows of `table`: κ, grade, banking, crest, planned v and a."""

    table: Mat  # (6, n + 1)
    step: float  # [m]
    closed: bool
    profile: Mat  # (2, m + 1) roughness [m] under left and right wheels
    profile_step: float  # [m]


@kernel
def at(values: Vec, step: float, closed: bool, s: float) -> float:
    """Interpolate linearly between nodes `step` apart, periodic on a closed road, else held at the ends."""
    last = len(values) - 1
    u = s / step
    if closed:
        u %= last
    i = min(max(int(np.floor(u)), 0), last - 1)
    share = min(max(u - i, 0.0), 1.0)
    return float(values[i] + share * (values[i + 1] - values[i]))


@kernel
def tyre(slip: float, load: float, static: float, stiffness: float, p: CarNumbers) -> tuple[float, float]:
    """Return the lateral force [N] of a freely rolling tyre, and its largest force D [N]."""
    D = p.mu * load * (1.0 - p.mu_z * (load / static - 1.0))
    if D <= 1.0:
        return 0.0, 0.0
    K = stiffness * static * np.sin(2.0 * np.arctan(load / (p.z_stiff * static)))
    b = K / (p.C * D) * np.arctan(slip)
    return -D * np.sin(p.C * np.arctan(b - p.E * (b - np.arctan(b)))), D


@kernel
def tyre_forces(x: Vec, F: float, p: CarNumbers, dx: Vec, extra: Vec) -> tuple[float, float, float]:
    """Return the sums of tyre forces along x and y [N] and of their moments about z [N m].

    Parameters
    ----------
    F : wanted longitudinal force [N].
    dx : output: slip rates.
    extra : input: loads.
    """
    vx, vy, r, delta = x[3], x[4], x[5], x[12]
    front = p.drive_front if F > 0.0 else p.brake_front
    Fx, Fy, Mz = 0.0, 0.0, 0.0
    for q in range(4):
        ahead = q < 2
        xq, yq = p.l_f if ahead else -p.l_r, 0.5 * p.B if q % 2 == 0 else -0.5 * p.B
        angle = delta if ahead else 0.0
        cos, sin = np.cos(angle), np.sin(angle)
        u, v = vx - r * yq, vy + r * xq
        dx[14 + q] = (v * cos - u * sin - max(abs(u * cos + v * sin), SLOW) * x[14 + q]) / p.sigma
        static = p.F_f if ahead else p.F_r
        side, D = tyre(x[14 + q], extra[6 + q], static, p.K_f if ahead else p.K_r, p)
        along = 0.5 * F * (front if ahead else 1.0 - front)
        along = min(max(along, -0.98 * D), 0.98 * D)
        if D > 0.0:
            side *= np.sqrt(1.0 - (along / D) ** 2)
        fx, fy = along * cos - side * sin, along * sin + side * cos
        Fx, Fy, Mz = Fx + fx, Fy + fy, Mz + xq * fy - yq * fx
    return Fx, Fy, Mz


@kernel
def suspension(x: Vec, F: tuple[float, float], n: float, p: CarNumbers, dx: Vec) -> None:
    """Write the accelerations of body and wheels under the tyre forces F = (F_x, F_y) [N].

    Parameters
    ----------
    n : acceleration [m/s²] normal to the road of an object that follows it, including gravity.
    dx : `dx[22:26]` contains, on entry, the change of the tyres' loads.
    """
    z, phi, theta = x[6], x[8], x[10]
    up, roll, pitch = 0.0, 0.0, 0.0
    for q in range(4):
        ahead, left = q < 2, q % 2 == 0
        xq, yq = p.l_f if ahead else -p.l_r, 0.5 * p.B if left else -0.5 * p.B
        stretch = z + yq * phi - xq * theta - x[18 + q]
        rate = x[7] + yq * x[9] - xq * x[11] - x[22 + q]
        other = q + 1 if left else q - 1
        twist = phi - (x[18 + q] - x[18 + other]) / (2.0 * yq)  # between both sides of the axle
        force = -(p.k_f if ahead else p.k_r) * stretch - (p.c_f if ahead else p.c_r) * rate
        force -= (p.b_f if ahead else p.b_r) * twist / (2.0 * yq)
        up, roll, pitch = up + force, roll + yq * force, pitch - xq * force
        weight_share = (p.l_r if ahead else p.l_f) / (p.l_f + p.l_r)
        links = p.h_r * F[1] * weight_share / (2.0 * yq)
        links += (0.5 if ahead else -0.5) * p.anti * p.h * F[0] / (p.l_f + p.l_r)
        dx[22 + q] = (dx[22 + q] - force + links) / p.m_u - (n - GRAVITY)
    arm = p.h - p.h_r
    dx[7] = up / p.m_s - (n - GRAVITY)
    dx[9] = (roll + arm * (F[1] + p.m * GRAVITY * phi)) / p.I_x
    dx[11] = (pitch - (1.0 - p.anti) * p.h * F[0]) / p.I_y


@kernel
def tyre_loads(x: Vec, road: RoadNumbers, p: CarNumbers, dx: Vec, extra: Vec) -> None:
    """Write tyre loads into `extra[6:10]`, and their changes from the static loads into `dx[22:26]`."""
    for q in range(4):
        s = x[0] + (p.l_f if q < 2 else -p.l_r)
        ground = at(road.profile[q % 2], road.profile_step, road.closed, s)
        change = p.k_t * (ground - x[18 + q])
        static = p.F_f if q < 2 else p.F_r
        extra[6 + q] = max(static + change, 0.0)  # a wheel may lose contact
        dx[22 + q] = extra[6 + q] - static


@kernel
def rates(x: Vec, command: Vec, road: RoadNumbers, p: CarNumbers, dx: Vec, extra: Vec) -> None:
    """Write the time derivative of the state into `dx` (26,), accelerations and loads into `extra` (10,).

    Specific forces in `extra` are those of the centre of gravity, in the road's axes.

    Parameters
    ----------
    command : steering angle [rad], and longitudinal acceleration [m/s²] that the driver requests.
    """
    s, e, chi, vx, vy, r = x[0], x[1], x[2], x[3], x[4], x[5]
    kappa = at(road.table[0], road.step, road.closed, s)
    grade = at(road.table[1], road.step, road.closed, s)
    bank = at(road.table[2], road.step, road.closed, s)
    crest = at(road.table[3], road.step, road.closed, s)
    n = GRAVITY * np.cos(grade) * np.cos(bank) + vx * vx * (crest * np.cos(bank) - kappa * np.sin(bank))
    tyre_loads(x, road, p, dx, extra)
    rolling = np.tanh(vx / ROLLING)
    F = p.m * x[13]
    F = min(F, p.P / max(vx, 1.0)) if F > 0.0 else F * rolling
    Fx, Fy, Mz = tyre_forces(x, F, p, dx, extra)
    fx = (Fx - p.drag * vx * abs(vx) - p.roll_resistance * p.m * n * rolling) / p.m
    fy = Fy / p.m
    suspension(x, (Fx, Fy), n, p, dx)
    ds = (vx * np.cos(chi) - vy * np.sin(chi)) / (1.0 - kappa * e)
    dx[0], dx[1], dx[2] = ds, vx * np.sin(chi) + vy * np.cos(chi), r - kappa * ds
    dx[3] = fx - GRAVITY * np.sin(grade) + r * vy
    dx[4] = fy - GRAVITY * np.sin(bank) * np.cos(grade) - r * vx
    dx[5] = Mz / p.I_z
    dx[6], dx[8], dx[10] = x[7], x[9], x[11]
    dx[12] = min(max((command[0] - x[12]) / p.T_steer, -p.steer_rate), p.steer_rate)
    dx[13] = (command[1] - x[13]) / (p.T_brake if command[1] < x[13] else p.T_drive)
    copy_to(dx[18:22], x[22:26])
    extra[0], extra[1], extra[2] = fx, fy, dx[7] + n - GRAVITY
    extra[3], extra[4], extra[5] = dx[9], dx[11], dx[5]


@kernel
def advance(x: Vec, command: Vec, road: RoadNumbers, p: CarNumbers, dt: float, work: Mat) -> None:
    """Advance one step of the classical Runge-Kutta method, in place, with the command held.

    Parameters
    ----------
    work : (6, 26) scratch memory; its last row then contains the extras at the start of the step.
    """
    extra = work[5]
    rates(x, command, road, p, work[0], extra)
    for i in range(STATES):
        work[4, i] = x[i] + 0.5 * dt * work[0, i]
    rates(work[4], command, road, p, work[1], work[3])
    for i in range(STATES):
        work[4, i] = x[i] + 0.5 * dt * work[1, i]
    rates(work[4], command, road, p, work[2], work[3])
    for i in range(STATES):
        work[4, i] = x[i] + dt * work[2, i]
        work[1, i] += work[2, i]
    scratch = np.empty(EXTRAS)
    rates(work[4], command, road, p, work[3], scratch)
    for i in range(STATES):
        x[i] += dt / 6.0 * (work[0, i] + 2.0 * work[1, i] + work[3, i])
