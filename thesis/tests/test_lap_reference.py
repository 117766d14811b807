import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

from otolith.vehicle import Driver, drive, load_car, road
from otolith_thesis.lap_reference import hockenheim_reference


def test_the_reference_is_the_cars_acceleration_through_eq_6_4() -> None:
    """Against scipy's own simulation of the transfer function."""
    reference = hockenheim_reference(80.0)
    lap = drive(road("hockenheim").limited(80 / 3.6), load_car(), Driver(), standing=True)
    assert reference.duration == pytest.approx(lap.time[-1], abs=0.011)
    otolith = ([4.0, 0.4], np.polymul([5.0, 1.0], [0.016, 1.0]))
    felt = reference.specific_force(lap.time)
    for axis in range(2):
        _, expected, _ = signal.lsim(otolith, lap.acceleration[:, axis], lap.time)
        assert_allclose(felt[:, axis], expected, atol=5e-3)
    assert not felt[:, 2].any()
    assert np.abs(felt).max() < 4.5
