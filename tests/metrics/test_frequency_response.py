"""The test applied to algorithms whose frequency response is known in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest

from otolith.core.arrays import Vec
from otolith.core.filter import Filter
from otolith.core.frames import GRAVITY
from otolith.core.lti import StateSpace, diagonal
from otolith.interfaces import Command, Outcome, PlatformState, Reference, Status
from otolith.metrics.frequency_response import (
    Procedure,
    System,
    applicable,
    decisions,
    drive,
    motion_cueing_test,
    respond,
    sinacori_point,
)
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.scenarios.cueing_tests import FREQUENCIES, TESTS, Amplitudes, Sweep, sinusoid

T, LAG = 0.01, 0.01  # [s] period of the algorithm, lag of the plant
HIGH = StateSpace.from_polynomials([0.5, 0.0, 0.0], [1.0, 3.0, 4.0])  # force -> surge acceleration
LOW = StateSpace.from_polynomials([0.6, 0.0, 0.0], [0.4, 1.0, 2.0])  # force/g -> tilt acceleration
TURN = StateSpace.from_polynomials([0.8, 0.0, 0.0], [1.0, 1.4, 1.0])  # pitch rate -> pitch acceleration


class Linear:
    """Surge and pitch accelerations by linear filters from surge force and pitch rate."""

    period = T

    def __init__(self, high: StateSpace = HIGH, low: StateSpace = LOW) -> None:
        self.filter = Filter(diagonal(high, low, TURN).discretise(T))

    def reset(self, state: PlatformState) -> None:
        self.filter.reset()

    def step(self, state: PlatformState, reference: Reference) -> Command:
        force, rate = reference.specific_force[0], reference.angular_rate[1]
        surge, tilt, turn = self.filter.step(np.array([force, force / GRAVITY, rate]))
        acceleration = np.array([surge, 0.0, 0.0, 0.0, turn - tilt, 0.0])
        still = np.zeros(6)
        outcome = Outcome(status=Status.DECIDED)
        return Command(acceleration=acceleration, pose=still, twist=still, plan=still[None], outcome=outcome)


def expected(omega: float) -> dict[str, complex]:
    """Discrete filter, held over its period, through the plant's lag and its integrators."""
    s = 1j * omega
    held = (1.0 - np.exp(-s * T)) / (s * T) / (1.0 + LAG * s)
    high, low, turn = (
        complex(system.discretise(T).frequency_response(np.array([omega]))[0, 0, 0]) * held
        for system in (HIGH, LOW, TURN)
    )
    return {
        "surge": high + low / s**2,  # f = a − g·pitch, pitch = −∬ tilt acceleration, which is per g
        "surge to pitch": -low / s / GRAVITY,
        "pitch": turn / s,
        "pitch to surge": -GRAVITY * turn / s**2,
    }


LINEAR = System(cueing=Linear(), plant=Ideal(LAG), platform=load("thesis"), axes=("surge", "pitch"))
SMALL = Amplitudes(angle=math.radians(0.5), rate=math.radians(0.1), force=0.05)  # sin(tilt) is tilt
QUICK = Procedure(
    amplitudes=SMALL,
    sweep=Sweep(settle=12.0, measured=4.0),
    frequencies=(FREQUENCIES[3], FREQUENCIES[7], FREQUENCIES[11]),
)


def test_the_response_of_a_linear_algorithm_is_its_transfer_function() -> None:
    found = motion_cueing_test(LINEAR, QUICK)
    assert [response.test.number for response in found] == [n for n in (1, 2, 6, 7) for _ in range(3)]
    for response in found:
        exact = expected(response.omega)[response.test.name]
        measured = response.modulus * np.exp(1j * math.radians(response.phase_deg))
        assert abs(measured / exact - 1.0) < 2e-3, (response.test.name, response.omega)
        assert abs(response.modulus - abs(exact)) < response.modulus_uncertainty + 2e-3 * abs(exact)
        assert response.phase_uncertainty_deg < 0.2


def test_the_point_at_1_rad_per_s_is_that_of_the_high_pass_alone() -> None:
    held = (1.0 - np.exp(-1j * T)) / (1j * T) / (1.0 + 1j * LAG)
    high = complex(HIGH.discretise(T).frequency_response(np.ones(1))[0, 0, 0]) * held
    point = sinacori_point(LINEAR, "surge", QUICK)
    assert point.modulus == pytest.approx(abs(high), rel=2e-3)
    assert math.radians(point.phase_deg) == pytest.approx(np.angle(high), abs=2e-3)
    turned = sinacori_point(LINEAR, "pitch", QUICK)
    assert turned.modulus == pytest.approx(abs(expected(1.0)["pitch"]), rel=2e-3)


def test_what_had_no_time_to_settle_says_so() -> None:
    slow = StateSpace.from_polynomials([1.0], [15.0, 1.0])  # settles in a minute
    system = replace(LINEAR, cueing=Linear(high=slow, low=StateSpace.gain(np.zeros((1, 1)))))
    exact = 1.0 / abs(1.0 + 15.0j)
    found = {}
    for settle in (0.0, 80.0):
        procedure = replace(QUICK, sweep=Sweep(settle=settle))
        found[settle] = respond(drive(system, "surge", 1.0, procedure), TESTS[5], 1.0, procedure)
    assert found[0.0].modulus_uncertainty > 5.0 * found[80.0].modulus_uncertainty
    assert abs(found[0.0].modulus - exact) < found[0.0].modulus_uncertainty + 1e-4
    assert found[80.0].modulus == pytest.approx(exact, rel=1e-3)


def test_an_axis_that_stays_still_has_no_phase() -> None:
    (still,) = motion_cueing_test(
        replace(LINEAR, axes=("heave",)), replace(QUICK, frequencies=(FREQUENCIES[11],))
    )
    assert still.modulus == 0.0
    assert math.isnan(still.phase_deg)
    assert math.isnan(still.phase_uncertainty_deg)
    assert math.isnan(still.distortion)


def test_only_axes_that_are_cued_are_tested_and_progress_reaches_one() -> None:
    assert [test.number for test in applicable(("surge", "pitch"))] == [1, 2, 6, 7]
    assert applicable(("surge", "pitch", "sway", "roll", "heave", "yaw")) == list(TESTS)
    fractions: list[float] = []
    motion_cueing_test(
        LINEAR, replace(QUICK, frequencies=(5.0,), sweep=Sweep(settle=1.0)), progress=fractions.append
    )
    assert fractions == [pytest.approx(0.5), pytest.approx(1.0)]


def test_decisions_that_failed_are_counted_once_per_drive_however_many_tests_read_it() -> None:
    """Surge and pitch are driven once each and read twice; every third decision fails."""

    class Failing(Linear):
        count = 0

        def step(self, state: PlatformState, reference: Reference) -> Command:
            self.count += 1
            failed = Outcome(status=Status.FALLBACK if self.count % 3 == 0 else Status.DECIDED)
            return replace(super().step(state, reference), outcome=failed)

    cueing = Failing()
    found = motion_cueing_test(
        replace(LINEAR, cueing=cueing), replace(QUICK, frequencies=(5.0,), sweep=Sweep(settle=1.0))
    )
    assert len(found) == 4
    assert sum(decisions(found).values()) == cueing.count
    assert decisions(found)["fallback"] == cueing.count // 3


def test_frequencies_and_amplitudes_are_those_of_the_table() -> None:
    table = [0.100, 0.158, 0.251, 0.398, 0.631, 1.0, 1.585, 2.512, 3.981, 6.310, 10.0, 15.849]
    np.testing.assert_allclose(FREQUENCIES, table, atol=5e-4)
    of = Amplitudes().of
    assert of("surge", 3.0) == 1.0
    assert math.degrees(of("pitch", 0.1)) == pytest.approx(0.6)  # 6° bounds it
    assert math.degrees(of("roll", 1.0)) == pytest.approx(1.0)  # 1°/s does
    assert math.degrees(of("yaw", 20.0)) == pytest.approx(0.5)  # 10°/s² does


@pytest.mark.parametrize("omega", [0.1, 2.0, 15.849])
def test_a_sinusoid_grows_and_then_is_exactly_one(omega: float) -> None:
    sweep = Sweep(settle=4.0, measured=3.0)
    settle, measured = sweep.times(omega)
    assert measured * omega / (2 * math.pi) == pytest.approx(round(measured * omega / (2 * math.pi)))
    assert measured >= max(3.0, 4 * math.pi / omega) - 1e-9
    t: Vec = np.linspace(0.0, settle + measured, 2001)
    lateral = sinusoid("sway", omega, 0.7, sweep)
    full = t >= 0.5 * settle
    np.testing.assert_allclose(lateral.specific_force(t)[full, 1], 0.7 * np.sin(omega * t[full]), atol=1e-12)
    assert np.all(np.abs(lateral.specific_force(t)) <= 0.7)
    assert not lateral.angular_rate(t).any()
    turning = sinusoid("yaw", omega, 0.1, sweep)
    assert turning.angular_rate(t)[:, 2].any()
    assert not turning.angular_rate(t)[:, :2].any()
    assert not turning.specific_force(t).any()
