"""What two explanations fit equally well is no proof: both are named, unless a gyro tells them apart."""

import re
from typing import Any

import numpy as np
import pytest

from otolith.core.errors import InputError
from tests.recordings import vehicles
from tests.recordings.checks.drives import ALL, SAE, attempt, differs, read, truth, written

PLANE = ("ax", "ay", "yaw_rate", "vx")
SLOW = vehicles.oval(17.0, banked_deg=11.0)  # gravity takes 1.9 m/s² from v r = 1 m/s²
HILLS = vehicles.hills(drive=0.5)  # a_x is minus the change of speed


def test_a_yaw_rate_that_the_ground_contradicts_does_not_turn_a_lateral_force_that_a_bank_explains() -> None:
    """Lateral force and yaw rate of one sign are not both turned where a car goes slowly round an oval."""
    keys = ("ax", "ay", "az", "yaw_rate", "vx", "lat", "lon")
    data = written(SLOW, keys, ("yaw_rate",))
    with pytest.raises(InputError) as caught:
        read(data)
    bank = re.search(r"map yaw_rate=-yaw_rate_radps if the road is banked by (\d+) deg", str(caught.value))
    assert bank is not None
    assert float(bank.group(1)) == pytest.approx(11.0, abs=1.0)
    assert "or map ay=-ay_mps2 and yaw_rate=-yaw_rate_radps" in str(caught.value)
    both = written(SLOW, keys, ("yaw_rate", "ay"))
    also: dict[str, Any] = {"ay": "-ay_mps2"}
    for turned, mapping in ((data, {}), (both, also)):
        _, sentence = attempt(turned, yaw_rate="-yaw_rate_radps", **mapping)
        assert "if the road is banked" in sentence  # the truth itself looks like a turned sign


def test_the_roll_of_the_gyro_tells_which_of_two_signs_is_turned() -> None:
    for turned in ("yaw_rate", "ay"):
        for ground in ((), ("lat", "lon")):
            data = written(SLOW, (*ALL, *ground), (turned,))
            with pytest.raises(InputError, match=f"map {turned}=-{turned}_") as caught:
                read(data)
            assert "which makes this file agree" in str(caught.value)
            mapped: dict[str, Any] = {turned: f"-{turned}_" + ("mps2" if turned == "ay" else "radps")}
            log = read(data, **mapped)
            assert max(differs(log, truth(SLOW, ALL)).values()) < 1e-6


def test_on_roads_that_turn_both_ways_no_bank_is_steep_enough() -> None:
    car = vehicles.car()
    log = read(written(car, (*PLANE, "lat", "lon"), ("ay", "yaw_rate")))
    assert max(differs(log, truth(car, PLANE)).values()) < 1e-6


def test_the_ground_proves_no_lateral_force_that_a_bank_would_turn() -> None:
    level = vehicles.oval(17.0, banked_deg=0.0)
    log = read(written(level, (*PLANE, "lat", "lon")))
    assert max(differs(log, truth(level, PLANE)).values()) < 1e-6
    assert any("the sign of ay is not proven: on a road that is banked by" in note for note in log.notes)


def test_a_force_along_hills_may_be_turned_and_a_note_says_how_steep_they_are() -> None:
    log = read(written(HILLS, PLANE, ("ax",)))
    note = next(note for note in log.notes if note.startswith("ax goes with the change of speed"))
    assert "unless the road climbs and falls by 6 %" in note
    fast = vehicles.ride(lambda t: 40.0 + 15.0 * np.sin(0.4 * t), lambda t: 0.0 * t)
    assert not any("unless the road climbs" in note for note in read(written(fast, PLANE)).notes)


def test_the_pitch_of_the_gyro_shows_that_the_force_along_hills_is_turned() -> None:
    for turned in (("ax",), ("ax", *SAE)):
        data = written(HILLS, (*ALL, "lat", "lon"), turned)
        with pytest.raises(
            InputError, match=r"ax in ride.csv is against gravity's share in the pitch .*map ax=-"
        ):
            read(data)
        log = read(data, ax="-ax_mps2")
        assert max(differs(log, truth(HILLS, ALL)).values()) < 1e-6


def test_a_motorcycle_whose_lateral_force_is_faint_does_not_tell_whether_pitch_is_turned_with_yaw() -> None:
    one = vehicles.motorcycle(lean=1.01)
    keys = ("ax", "ay", "roll_rate", "pitch_rate", "yaw_rate", "vx", "lat", "lon")
    data = written(one, keys, ("yaw_rate",))
    with pytest.raises(
        InputError, match=r"more than one thing makes this file agree: map yaw_rate=-.* --axes sae"
    ):
        read(data)
    log = read(data, yaw_rate="-yaw_rate_radps")
    assert max(differs(log, truth(one, keys)).values()) < 1e-6


def test_a_vertical_force_without_gravity_is_said_to_be_unproven_where_nothing_else_tells() -> None:
    one = vehicles.motorcycle()
    data = written(one, ("ax", "az", "vx"))
    data["az"] = data["az"] - vehicles.G
    assert any(note.startswith("left and right are not proven") for note in read(data).notes)


def test_the_way_out_for_a_leaning_vehicle_states_every_unit_that_is_doubted() -> None:
    """Before, it stated that of the force alone, and the same refusal came again, for the yaw rate's."""
    leaning = vehicles.motorcycle(lean=0.983)
    data = written(leaning, ("ax", "ay", "yaw_rate", "vx"))
    _, sentence = attempt(data)
    (way,) = re.findall(r"or map ([^;]*?) if the road is banked, or the vehicle leans", sentence)
    mapping = dict(part.split("=", 1) for part in way.split(" and "))
    assert set(mapping) == {"ay", "yaw_rate"}
    log = read(data, **mapping)
    assert max(differs(log, truth(leaning, ("ax", "ay", "yaw_rate"))).values()) < 1e-6
