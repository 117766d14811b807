"""Dynamics of a hexapod, compiled: one rigid body on six legs whose mass moves along them.

Notation: ν = (v, ω) velocity of the motion reference point in world; c centre of mass from that point, in
world; I inertia about it; m mass, μ mass of a leg; J of `otolith.platforms.kinematics`; F leg forces. All are
along the coordinates of the legs: of a crank, F is its torque over its radius and μ its inertia over its
square.

    (M + μ JᵀJ) ν̇ = Jᵀ (F − μ J̇ ν) + w − h,   M = [[m 1, −m [c]×], [m [c]×, I]]
    w = (−m g ẑ, −m g c × ẑ),   h = (m ω × (ω × c), ω × I ω)

Derivation: Newton and Euler about the reference point; each leg adds μ L̈ = μ (J ν̇ + J̇ ν) to its force
(legs are lumped: their own rotation and weight are neglected). The servo of a leg is digital, with period Δ:
F = weight + k (ℓ − L) + d (ℓ̇ − L̇), held over Δ and limited to the leg's force.

Stability: at rest, in a mode of M⁻¹JᵀJ with eigenvalue λ, the held force gives x⁺ the characteristic
polynomial z² + (λ d Δ + λ k Δ²/2 − 2) z + 1 − λ d Δ + λ k Δ²/2. Both roots are inside the unit circle exactly
if k Δ/2 < d < 2/(λ Δ) (Jury). Checked by test_gains_decide_stability_where_the_bound_says.
"""

import math
from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel
from otolith.core.rotation import rotation_of, turn
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.kinematics import Actuators, inverse, rates, solve


class Machine(NamedTuple):
    """The numbers of an `otolith.platforms.hexapod.Hexapod` that the kernels need."""

    actuators: Actuators
    centre: Vec  # (3,) [m]
    inertia: Vec  # (3,) [kg m²] along the platform's axes
    mass: float  # m [kg]
    leg_mass: float  # μ [kg]
    stiffness: float  # k [N/m]
    damping: float  # d [N s/m]
    force: float  # [N] limit of a servo's force


def machine(hexapod: Hexapod) -> Machine:
    """Return the machine's numbers as plain arrays, which compiled kernels read."""
    return Machine(*(getattr(hexapod, name) for name in Machine._fields))


@kernel
def _cross(a: Vec, b: Vec, out: Vec) -> None:
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@kernel
def _turned(R: Mat, a: Vec, out: Vec) -> None:
    """Write R a (3,)."""
    for i in range(3):
        out[i] = R[i, 0] * a[0] + R[i, 1] * a[1] + R[i, 2] * a[2]


@kernel
def carry(place: Vec, of: Machine, forces: Vec) -> bool:
    """Write the leg forces (6,) [N] that carry the platform's weight at rest; return False if none do."""
    R, J = np.empty((3, 3)), np.empty((6, 6))
    rotation_of(place, R)
    inverse(place, of.actuators, np.empty(6), J, np.empty((6, 3)))
    weight, centre = of.mass * GRAVITY, of.centre
    forces[:3] = 0.0
    forces[2] = weight
    forces[3] = (R[1, 0] * centre[0] + R[1, 1] * centre[1] + R[1, 2] * centre[2]) * weight
    forces[4] = -(R[0, 0] * centre[0] + R[0, 1] * centre[1] + R[0, 2] * centre[2]) * weight
    forces[5] = 0.0
    return solve(J.T.copy(), forces)


@kernel
def servo(legs: Mat, targets: Mat, of: Machine) -> None:
    """Write the servos' forces [N] into the last row of `legs` (3, 6): lengths, speeds, forces.

    Parameters
    ----------
    targets : (3, 6) lengths, speeds and weights.
    """
    for i in range(6):
        force = targets[2, i] + of.stiffness * (targets[0, i] - legs[0, i])
        force += of.damping * (targets[1, i] - legs[1, i])
        legs[2, i] = min(of.force, max(-of.force, force))


@kernel
def mass_matrix(R: Mat, J: Mat, of: Machine, M: Mat) -> None:
    """Write M + μ JᵀJ (6, 6) about the reference point."""
    m, c = of.mass, np.empty(3)
    _turned(R, of.centre, c)
    for a in range(6):
        for b in range(a, 6):
            total = 0.0
            for i in range(6):
                total += J[i, a] * J[i, b]
            M[a, b] = M[b, a] = of.leg_mass * total
    c2 = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
    for a in range(3):
        M[a, a] += m
        for b in range(3):
            own = -m * c[a] * c[b] + (m * c2 if a == b else 0.0)  # −m [c]×²: Steiner
            for i in range(3):
                own += R[a, i] * of.inertia[i] * R[b, i]
            M[3 + a, 3 + b] += own
    for a, b, s in ((0, 1, c[2]), (1, 2, c[0]), (2, 0, c[1])):  # −m [c]×
        M[a, 3 + b] += m * s
        M[3 + b, a] += m * s
        M[b, 3 + a] -= m * s
        M[3 + a, b] -= m * s


@kernel
def _loads(R: Mat, velocity: Vec, of: Machine, loads: Vec) -> None:
    """Write w − h (6,): weight, centrifugal and gyroscopic loads."""
    m, w = of.mass, velocity[3:]
    c, spin, turned, moment = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    _turned(R, of.centre, c)
    _cross(w, c, spin)
    _cross(w, spin, turned)  # ω × (ω × c)
    _turned(R.T, w, moment)
    _turned(R, of.inertia * moment, spin)  # I ω
    _cross(w, spin, moment)
    for i in range(3):
        loads[i] = -m * turned[i]
    loads[2] -= m * GRAVITY
    _cross(c, loads[:3], turned)  # body's ω × I ω plus c × m ω × (ω × c)
    for i in range(3):
        loads[3 + i] = turned[i] - moment[i]


@kernel
def advance(
    place: Vec,
    velocity: Vec,
    acceleration: Vec,
    legs: Mat,
    targets: Mat,
    of: Machine,
    dt: float,
) -> bool:
    """Advance one servo period: sample the legs, hold their forces over dt, move; False if the legs fold.

    Parameters
    ----------
    place, velocity, acceleration : (7,), (6,) and (6,) of the reference point, advanced in place; the
        acceleration is that of the period.
    legs : (3, 6) output: lengths, speeds and forces at the start of the period.
    targets : (3, 6) lengths, speeds and weights for the servos.
    """
    R, J, M = np.empty((3, 3)), np.empty((6, 6)), np.empty((6, 6))
    arms, moving = np.empty((6, 3)), np.empty((2, 6))
    rotation_of(place, R)
    inverse(place, of.actuators, legs[0], J, arms)
    rates(velocity, legs[0], J, arms, of.actuators, moving)
    for i in range(6):
        legs[1, i] = moving[0, i]
    servo(legs, targets, of)
    mass_matrix(R, J, of, M)
    _loads(R, velocity, of, acceleration)
    for i in range(6):
        force = legs[2, i] - of.leg_mass * moving[1, i]
        for j in range(6):
            acceleration[j] += J[i, j] * force
    if not solve(M, acceleration):
        return False
    for i in range(3):
        place[i] += dt * (velocity[i] + 0.5 * dt * acceleration[i])
    half = 0.5 * dt
    turn(
        place,
        dt * (velocity[3] + half * acceleration[3]),
        dt * (velocity[4] + half * acceleration[4]),
        dt * (velocity[5] + half * acceleration[5]),
    )
    for i in range(6):
        velocity[i] += dt * acceleration[i]
    return True


def modes(hexapod: Hexapod) -> Vec:
    """Return the eigenvalues λ (6,) [1/kg] of M⁻¹JᵀJ in the neutral pose, ascending."""
    J, M = hexapod.jacobian(np.zeros(6)), np.empty((6, 6))
    mass_matrix(np.eye(3), J, machine(hexapod), M)
    found: Vec = np.sort(np.linalg.eigvals(np.linalg.solve(M, J.T @ J)).real)
    return found


def damping_bounds(hexapod: Hexapod, period: float) -> tuple[float, float]:
    """Return the servo dampings [N s/m] between which a digital servo with this period [s] is stable."""
    return 0.5 * hexapod.stiffness * period, 2.0 / (float(modes(hexapod)[-1]) * period)


def frequencies(hexapod: Hexapod) -> Vec:
    """Return the undamped natural frequencies (6,) [Hz] of the platform on its servos, ascending."""
    found: Vec = np.sqrt(hexapod.stiffness * modes(hexapod)) / (2.0 * math.pi)
    return found
