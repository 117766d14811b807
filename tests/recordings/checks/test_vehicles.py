"""A correct log is never altered, whatever the vehicle and the road."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.recordings.settings import LogSettings
from tests.recordings import vehicles
from tests.recordings.checks.drives import ALL, SAE, attempt, differs, read, truth, written
from tests.recordings.vehicles import Ride

RIDES = {
    "level car": vehicles.car(),
    "fast on a banked oval": vehicles.oval(70.0),
    "at a pace at which the bank takes more than it gives": vehicles.oval(40.0),
    "slow on a bank, felt force against the turn": vehicles.oval(28.0),
    "very slow on a bank": vehicles.oval(20.0),
    "on a bank of 45 deg, hardly any lateral force": vehicles.oval(58.0, banked_deg=45.0),
    "lorry on hills that slows uphill": vehicles.hills(),
    "lorry on hills, a_x against the change of speed": vehicles.hills(drive=0.5),
    "one slope up a mountain": vehicles.mountain(),
    "motorcycle": vehicles.motorcycle(),
    "motorcycle that leans more than it must": vehicles.motorcycle(lean=1.1),
    "motorcycle that leans less": vehicles.motorcycle(lean=0.9),
    "tilting train": vehicles.train(),
    "train that tilts by what looks like a unit": vehicles.train(tilt=0.72),
}
ON_EARTH = (*ALL, "lat", "lon")


@pytest.mark.parametrize("name", RIDES)
def test_a_correct_log_with_gyro_is_read_as_it_is(name: str) -> None:
    one = RIDES[name]
    log = read(written(one))
    for key, values in truth(one, ALL).items():
        assert_allclose(log.channels[key].values, values, atol=1e-6)


@pytest.mark.parametrize("name", RIDES)
def test_a_log_in_sae_axes_is_turned_where_the_ground_proves_it(name: str) -> None:
    one = RIDES[name]
    log = read(written(one, ON_EARTH, SAE))
    assert max(differs(log, truth(one, ALL)).values()) < 1e-6
    assert any("left and right are proven by latitude and longitude" in note for note in log.notes)


@pytest.mark.parametrize("name", RIDES)
@pytest.mark.parametrize(
    "keys", [("ax", "ay", "yaw_rate", "vx"), ("ax", "ay", "vx"), ("ax", "ay", "yaw_rate")]
)
def test_without_a_full_gyro_a_correct_log_is_read_as_it_is_or_refused(
    name: str, keys: tuple[str, ...]
) -> None:
    """A slow lap on a bank looks like a turned sign; then both explanations are named, never one taken."""
    one = RIDES[name]
    log, sentence = attempt(written(one, keys))
    if log is None:
        assert "more than one thing makes this file agree" in sentence or "nothing in the file" in sentence
        assert "--axes iso" in sentence or "if the road is banked, or the vehicle leans" in sentence
        return
    for key, values in truth(one, keys).items():
        assert_allclose(log.channels[key].values, values, atol=1e-6)


@pytest.mark.parametrize("name", RIDES)
def test_the_users_word_on_axes_ends_every_doubt_about_signs(name: str) -> None:
    one = RIDES[name]
    keys = ("ax", "ay", "yaw_rate", "vx")
    for axes, turned in (("iso", ()), ("sae", ("ay", "yaw_rate"))):
        mapping = {"ay": "ay_mps2:m/s2"}  # some trains and motorcycles look as if the unit were another
        log = read(written(one, keys, turned), LogSettings(axes=axes), **mapping)
        assert max(differs(log, truth(one, keys)).values()) < 1e-6


def test_what_a_driver_on_a_slope_feels_stays_and_both_explanations_are_named() -> None:
    log = read(written(RIDES["one slope up a mountain"]))
    (note,) = (note for note in log.notes if note.startswith("ax: a constant +0.69"))
    assert "a sensor tilted by 4.0 deg, or a slope of 7.0 %" in note
    assert float(np.mean(log.channels["ax"].values)) == pytest.approx(0.69, abs=0.05)


def test_a_lateral_force_that_is_all_centripetal_is_not_called_vertical() -> None:
    """Re-made from a public complaint: the inertial force of a 45 deg bank, v r = 9.81 m/s²."""
    t = np.arange(0.0, 30.0, 0.05)
    turning = 0.24525 * np.clip(np.minimum(t - 3.0, 27.0 - t) / 4.0, 0.0, 1.0)
    data = {"t": t, "ax": 0.0 * t, "ay": 40.0 * turning, "yaw_rate": turning, "vx": np.full_like(t, 40.0)}
    log = read(data)
    assert_allclose(log.channels["ay"].values, data["ay"], atol=1e-8)
    assert any(note.startswith("ay is speed × turning throughout (slope 1.00)") for note in log.notes)


def test_gravity_that_two_axes_share_is_a_tilted_sensor() -> None:
    """A telephone in a holder that leans back by 38 deg: no mapping repairs that."""
    one: Ride = RIDES["level car"]
    data = written(one, ("ax", "ay", "az", "yaw_rate"))
    c, s = np.cos(np.radians(38.0)), np.sin(np.radians(38.0))
    data["ax"], data["az"] = c * data["ax"] + s * data["az"], c * data["az"] - s * data["ax"]
    with pytest.raises(InputError, match="the sensor is tilted by 38 deg"):
        read(data)
