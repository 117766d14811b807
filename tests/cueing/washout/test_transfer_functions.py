"""The objective motion cueing test of the classical washout beside its transfer functions on paper."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.washout.classical import (
    classical,
    cross_response,
    force_response,
    hold_response,
    rate_response,
)
from otolith.metrics.frequency_response import Procedure, System, drive, respond
from otolith.plant.ideal import Ideal
from otolith.scenarios.cueing_tests import FREQUENCIES, TESTS, Amplitudes
from tests.cueing.washout.loop import Task

PITCH, PITCH_TO_SURGE, SURGE = TESTS[0], TESTS[1], TESTS[5]
SMALL = Procedure(amplitudes=Amplitudes(force=0.01, angle=np.radians(0.05), rate=np.radians(0.05)))
# Pitch felt as surge is a small difference of two large motions, whose records stand half a plant step
# apart: at 10 rad/s the error is 1.6 % at 1 ms, 0.8 % at half and 0.4 % at a quarter of it.
FINE = replace(SMALL, plant_period=0.25e-3)


@pytest.mark.parametrize("omega", FREQUENCIES[4::3])
def test_modulus_and_phase_are_those_on_paper_within_one_percent_and_one_degree(omega: float) -> None:
    task, w = Task(), np.array([omega])
    system = System(
        cueing=classical(task), plant=Ideal(lag=0.0), platform=task.platform, axes=("surge", "pitch")
    )
    late, held = hold_response(w, late=True), hold_response(w)
    paper = {
        PITCH: rate_response(task.tuning, w) * late,
        PITCH_TO_SURGE: cross_response(task.tuning, SURGE_PITCH, w) * late,
        SURGE: force_response(task.tuning, SURGE_PITCH, w) * held,
    }
    for test, (expected,) in paper.items():
        procedure = FINE if test is PITCH_TO_SURGE and omega > 5.0 else SMALL
        measured = respond(drive(system, test.driven, omega, procedure), test, omega, procedure)
        assert measured.modulus == pytest.approx(abs(expected), rel=0.01)
        apart = measured.phase_deg - np.degrees(np.angle(expected))
        assert abs((apart + 180.0) % 360.0 - 180.0) < 1.0
