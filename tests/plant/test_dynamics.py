"""Our rigid body against conserved quantities, virtual work, and the bound on its servos' gains."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import GRAVITY
from otolith.core.rotation import place_of, rotation_of
from otolith.plant.dynamics import (
    Machine,
    advance,
    carry,
    damping_bounds,
    frequencies,
    machine,
    mass_matrix,
)
from otolith.plant.servo_targets import check_gains
from otolith.platforms import load, parse_platform
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.template import template

DAVSI = load("davsi").six_legs()
POSE = np.array([0.1, -0.1, 0.1, 0.1, -0.15, 0.2])
RIG = parse_platform(template("cranks"), "cranks.toml").six_legs()
LIMP = machine(DAVSI)._replace(stiffness=0.0, damping=0.0)  # legs that only have mass


class Body:
    """The state that `advance` moves."""

    def __init__(self, pose: Vec, velocity: Vec) -> None:
        self.place, self.velocity, self.acceleration = np.empty(7), velocity.copy(), np.zeros(6)
        place_of(pose, self.place)

    def run(self, of: Machine, targets: Mat, *, dt: float, n: int) -> "Body":
        legs = np.empty((3, 6))
        for _ in range(n):
            assert advance(self.place, self.velocity, self.acceleration, legs, targets, of, dt)
        return self

    def rotation(self) -> Mat:
        R = np.empty((3, 3))
        rotation_of(self.place, R)
        return R


def energy(body: Body, of: Machine, hexapod: Hexapod) -> float:
    R, M, J = body.rotation(), np.empty((6, 6)), np.empty((6, 6))
    roll_pitch_yaw = np.array(
        [np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0]), np.arctan2(R[1, 0], R[0, 0])]
    )
    J = hexapod.jacobian(np.concatenate([body.place[:3], roll_pitch_yaw]))
    mass_matrix(R, J, of, M)
    height = body.place[2] + (R @ of.centre)[2]
    return float(0.5 * body.velocity @ M @ body.velocity + of.mass * GRAVITY * height)


@pytest.mark.parametrize("hexapod", [DAVSI, RIG], ids=["legs", "cranks"])
def test_energy_is_conserved_to_the_integrators_order(hexapod: Hexapod) -> None:
    """Legs without force but with mass: Coriolis terms, J̇ and gyroscopic loads all take part."""
    limp = machine(hexapod)._replace(stiffness=0.0, damping=0.0)
    velocity, errors = np.array([0.3, -0.2, 1.0, 0.8, -0.6, 0.9]), []
    pose = POSE if hexapod is DAVSI else 0.3 * POSE
    for n in (200, 400):
        body = Body(pose, velocity)
        before = energy(body, limp, hexapod)
        after = energy(body.run(limp, np.zeros((3, 6)), dt=0.1 / n, n=n), limp, hexapod)
        errors.append(abs(after - before))
    kinetic = energy(Body(pose, velocity), limp, hexapod) - energy(Body(pose, np.zeros(6)), limp, hexapod)
    assert errors[0] < 2e-3 * kinetic
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.1)


def test_a_free_body_falls_in_a_parabola_and_keeps_its_spin() -> None:
    free = LIMP._replace(leg_mass=0.0)
    body = Body(POSE, np.array([0.3, -0.2, 1.0, 1.8, -1.6, 1.9]))
    t, n = 0.2, 4000

    def momentum() -> Vec:
        R = body.rotation()
        return R @ (free.inertia * (R.T @ body.velocity[3:]))

    def centre() -> Vec:
        return body.place[:3] + body.rotation() @ free.centre

    spin, start = momentum(), centre()
    v = body.velocity[:3] + np.cross(body.velocity[3:], body.rotation() @ free.centre)
    body.run(free, np.zeros((3, 6)), dt=t / n, n=n)
    assert_allclose(centre(), start + v * t - [0, 0, 0.5 * GRAVITY * t**2], atol=1e-4)
    assert_allclose(momentum(), spin, rtol=1e-4)


@pytest.mark.parametrize("hexapod", [DAVSI, RIG], ids=["legs", "cranks"])
def test_the_legs_carry_the_weight_by_virtual_work(hexapod: Hexapod) -> None:
    """Leg forces are the derivative of the potential energy with respect to the leg lengths, or arcs."""
    place, forces, h = np.empty(7), np.empty(6), 1e-6
    at_pose = POSE if hexapod is DAVSI else 0.5 * POSE
    place_of(at_pose, place)
    assert carry(place, machine(hexapod), forces)

    def potential(lengths: Vec) -> float:
        pose, at, R = hexapod.pose_of(lengths, near=at_pose), np.empty(7), np.empty((3, 3))
        place_of(pose, at)
        rotation_of(at, R)
        return float(hexapod.mass * GRAVITY * (pose[2] + (R @ hexapod.centre)[2]))

    L = hexapod.lengths(at_pose)
    slopes = [(potential(L + h * e) - potential(L - h * e)) / (2 * h) for e in np.eye(6)]
    assert_allclose(forces, slopes, rtol=1e-5)


def test_carried_at_rest_it_stays_at_rest() -> None:
    body, targets, gained = Body(POSE, np.zeros(6)), np.zeros((3, 6)), machine(DAVSI)
    targets[0] = DAVSI.lengths(POSE)
    assert carry(body.place, gained, targets[2])
    start = body.place.copy()
    body.run(gained, targets, dt=1e-3, n=500)
    assert_allclose(body.place, start, atol=1e-12)


@pytest.mark.parametrize(
    ("end", "factor", "grows"), [(0, 1.02, False), (0, 0.98, True), (1, 0.98, False), (1, 1.02, True)]
)
def test_gains_decide_stability_where_the_bound_says(end: int, factor: float, grows: bool) -> None:
    """Just inside a bound a small deflection dies out, just outside it grows, in the simulation itself."""
    bound = damping_bounds(replace(DAVSI, stiffness=2e8), 1e-3)[end]
    hexapod = replace(DAVSI, stiffness=2e8, damping=factor * bound, force=1e12)
    of, targets = machine(hexapod), np.zeros((3, 6))
    deflected = 1e-9 * np.random.default_rng(0).normal(size=6)
    body = Body(deflected, np.zeros(6))
    targets[0] = hexapod.lengths(np.zeros(6))
    carry(np.array([0, 0, 0, 1.0, 0, 0, 0]), of, targets[2])
    body.run(of, targets, dt=1e-3, n=(4000, 600)[end])
    left = np.abs(body.velocity).max()
    assert left > 1e-4 if grows else left < 1e-8


def test_unstable_gains_are_refused_in_one_sentence() -> None:
    wild: Hexapod = replace(DAVSI, stiffness=5e7, damping=1e6)
    with pytest.raises(InputError) as caught:
        check_gains(wild, 1e-3)
    assert str(caught.value) == (
        "hexapod.legs.damping_nspm is 1e+06, must be between 2.5e+04 and 9.723e+05 N s/m for a stable servo "
        "of 1 ms and 5e+07 N/m"
    )
    check_gains(DAVSI, 1e-3)


def test_the_platform_swings_on_its_servos_at_the_frequencies_told() -> None:
    """Undamped and let go from a deflection: the peak of heave's spectrum is one of them."""
    soft = replace(DAVSI, stiffness=2e5, damping=1.0, force=1e12)
    of, targets = machine(soft), np.zeros((3, 6))
    targets[0] = soft.lengths(np.zeros(6))
    carry(np.array([0, 0, 0, 1.0, 0, 0, 0]), of, targets[2])
    body, dt = Body(np.array([0, 0, 1e-6, 0, 0, 0]), np.zeros(6)), 2e-5
    speeds = [body.run(of, targets, dt=dt, n=20).velocity.copy() for _ in range(5000)]
    spectrum = np.abs(np.fft.rfft(np.array(speeds) * np.hanning(len(speeds))[:, None], axis=0, n=2**17))
    at = np.fft.rfftfreq(2**17, 20 * dt)
    heave = at[np.argmax(spectrum[:, 2])]
    assert np.min(np.abs(frequencies(soft) / heave - 1.0)) < 0.02
