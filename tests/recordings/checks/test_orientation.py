"""Left and right: proven, stated, not proven, contradicted; and remedies that are right for the file."""

import re
from typing import Any

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.recordings import Log
from otolith.recordings.settings import LogSettings
from tests.recordings.checks.drives import ALL, NAMES, SAE, differs, read, truth, written
from tests.recordings.vehicles import car, motorcycle

CAR = car()
PLANE = ("ax", "ay", "yaw_rate", "vx")


def right(log: Log, keys: tuple[str, ...] = PLANE) -> bool:
    return max(differs(log, truth(CAR, keys)).values()) < 1e-6


@pytest.mark.parametrize("witness", [("lat", "lon"), ("heading",)])
def test_the_ground_decides_when_all_signs_are_turned_together(witness: tuple[str, ...]) -> None:
    log = read(written(CAR, (*ALL, *witness), SAE))
    assert right(log, ALL)
    assert log.found is not None
    assert log.found.proof
    assert set(log.found.turned) == set(SAE)


@pytest.mark.parametrize("witness", [("lat", "lon"), ("heading",)])
def test_a_log_that_the_ground_confirms_is_not_turned(witness: tuple[str, ...]) -> None:
    log = read(written(CAR, (*ALL, *witness)))
    assert right(log, ALL)
    assert any("left and right are proven by" in note for note in log.notes)


def test_a_heading_that_counts_the_other_way_has_a_way_out_that_works() -> None:
    """In degrees it is taken for a compass; some simulators' counts as yaw does, and nothing tells."""
    data = written(CAR, (*PLANE, "heading"))
    data["heading"] = -data["heading"]
    taken = read(data)
    assert set(taken.found.turned if taken.found else ()) == {"ay", "yaw_rate"}
    assert any("leave it out with heading=none" in note for note in taken.notes)
    log = read(data, heading="none")
    assert right(log)
    assert any("left and right are not proven" in note for note in log.notes)


def test_the_ground_decides_without_gravity_and_without_a_gyro() -> None:
    assert right(read(written(CAR, (*PLANE, "lat", "lon"), ("ay", "yaw_rate"))))
    assert right(read(written(CAR, ("ax", "yaw_rate", "vx", "heading"), ("yaw_rate",))), ("ax", "yaw_rate"))


def test_without_a_witness_it_says_that_left_and_right_are_not_proven() -> None:
    for turned in ((), ("ay", "yaw_rate")):
        log = read(written(CAR, PLANE, turned))
        assert any(note.startswith("left and right are not proven") for note in log.notes)
    for axes, turned in (("iso", ()), ("sae", ("ay", "yaw_rate"))):
        log = read(written(CAR, PLANE, turned), LogSettings(axes=axes))
        assert right(log)
        assert not any("not proven" in note for note in log.notes)


def test_z_down_alone_does_not_tell_left_and_both_remedies_are_named_and_work() -> None:
    """The remedy of old, az turned alone, made a mirrored drive of a log in SAE axes."""
    keys = ("ax", "ay", "az", "yaw_rate", "vx")
    for turned, settings, columns in (
        (("ay", "az", "yaw_rate"), LogSettings(axes="sae"), {}),
        (("az",), LogSettings(), {"az": "-az_mps2"}),
    ):
        data = written(CAR, keys, turned)
        with pytest.raises(InputError, match=r"--axes sae if it does .* map az=-az_mps2 if it points left"):
            read(data)
        assert right(read(data, settings, **columns), keys)


def test_gravity_turns_a_vertical_channel_alone_where_the_ground_proves_the_rest() -> None:
    keys = ("ax", "ay", "az", "yaw_rate", "vx", "lat", "lon")
    assert right(read(written(CAR, keys, ("az",))), keys)


def test_the_roll_of_a_motorcycle_and_gravity_show_sae_axes_with_z_down() -> None:
    """f_y = v r + g sin(roll): turned with y and z, but not with the roll; no ground is needed."""
    one = motorcycle()
    log = read(written(one, ALL, SAE))
    assert max(differs(log, truth(one, ALL)).values()) < 1e-6
    assert any("roll rate and gravity shows" in note for note in log.notes)


@pytest.mark.parametrize("turned", ["ay", "yaw_rate"])
def test_one_turned_sign_is_refused_and_the_one_remedy_that_the_ground_proves_works(turned: str) -> None:
    data = written(CAR, (*PLANE, "lat", "lon"), (turned,))
    with pytest.raises(InputError) as caught:
        read(data)
    remedy = re.search(r"map (\w+)=(-\w+)", str(caught.value))
    assert remedy is not None
    assert "which makes this file agree" in str(caught.value)
    mapped: dict[str, Any] = {remedy.group(1): remedy.group(2)}
    assert right(read(data, **mapped))


def test_one_turned_sign_without_a_witness_has_two_remedies_and_says_so() -> None:
    with pytest.raises(InputError) as caught:
        read(written(CAR, PLANE, ("ay",)))
    assert "nothing in it shows which: map ay=-ay_mps2; or map yaw_rate=-yaw_rate_radps" in str(caught.value)


def test_a_statement_that_the_ground_contradicts_is_refused() -> None:
    for axes, turned in (("iso", SAE), ("sae", ())):
        with pytest.raises(InputError, match="--axes is"):
            read(written(CAR, (*PLANE, "heading"), set(turned) & set(PLANE)), LogSettings(axes=axes))


def test_a_plain_map_proves_nothing_alone_but_contradicts() -> None:
    """x and y may be drawn with z down: then the map is mirrored, and not the drive."""
    keys = (*PLANE, "x", "y")
    assert any("agree with the positions x, y" in note for note in read(written(CAR, keys)).notes)
    with pytest.raises(InputError, match=r"--axes sae.*or map y=-y_m if it is the map"):
        read(written(CAR, keys, ("ay", "yaw_rate")))
    assert right(read(written(CAR, keys, ("ay", "yaw_rate")), LogSettings(axes="sae"), y="none"))
    assert right(read(written(CAR, keys, ("y",)), y="-y_m"))


def test_a_map_with_east_and_north_proves() -> None:
    from otolith.recordings import parse_log
    from tests.recordings.checks.drives import text

    names = {**NAMES, "x": "east_m", "y": "north_m"}
    data = written(CAR, (*PLANE, "x", "y"), ("ay", "yaw_rate"))
    log = parse_log(text(data, names), "ride.csv", columns={"x": "east_m", "y": "north_m"})
    assert right(log)


def test_what_is_not_cued_is_said_and_not_refused() -> None:
    data = written(CAR, PLANE, ("ay",))
    log = read(data, LogSettings(needs=("ax",)))
    assert any(
        note.startswith("reported only, since it is not cued: ay in ride.csv is against")
        for note in log.notes
    )
    with pytest.raises(InputError):
        read(data, LogSettings(needs=("ay",)))


def test_coarse_positions_prove_as_well() -> None:
    """Five decimals of a degree are steps of a metre."""
    data = written(CAR, (*PLANE, "lat", "lon"), ("ay", "yaw_rate"))
    grain = np.radians(1e-5)
    data["lat"], data["lon"] = (np.round(data[key] / grain) * grain for key in ("lat", "lon"))
    assert right(read(data))


def test_latitude_and_longitude_whose_names_are_exchanged_are_refused_with_a_mapping_that_works() -> None:
    """At 50 deg a degree of longitude is 36 % shorter: exchanged, the way does not have the file's speed.

    Before, the mirrored way proved a right drive wrong, and it was turned.
    """
    data = written(CAR, (*PLANE, "lat", "lon"))
    data["lat"], data["lon"] = data["lon"], data["lat"]
    with pytest.raises(InputError, match="with their names exchanged") as caught:
        read(data)
    remedy = dict(re.findall(r"(lat|lon)=(l[a-z]+ \(deg\))", str(caught.value)))
    assert right(read(data, **remedy))
    assert right(read(data, lat="none", lon="none"))
    assert right(read(written(CAR, (*PLANE, "lat", "lon"))))
