"""Exported logs: what was in the world stands in the tables, and a drive can be read back."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from otolith import files
from otolith.core.errors import InputError
from otolith.interfaces import Cueing
from otolith.live.controller import plain
from otolith.live.core.health import Health
from otolith.live.export import EVENT, MEASURED, REFERENCE, SET_POINT, Tables
from otolith.live.log import MOST, NAMES
from otolith.live.messages import State
from otolith.live.records import Records
from otolith.live.virtual_log import VirtualLog
from otolith.live.wire.generic import Generic
from otolith.live.world import World, arm_and_engage, sines
from otolith.platforms import Platform
from otolith.recordings.recorded import Signal
from tests.live.conftest import PARK

DRIVE = sines({0: (1.2, 0.4), 1: (0.8, 0.7), 5: (0.1, 0.3)})
Made = tuple[World, dict[str, list[Signal]]]


@pytest.fixture
def made(washout: Cueing, machine: Platform) -> Made:
    """A session whose telemetry is damaged for a while, and its log as tables."""
    log = VirtualLog()
    world = World(washout, machine, drive=DRIVE, park=PARK, tick=2e-3).record(log)
    world.at(4.0, lambda: setattr(world.links["telemetry"], "corruption", 0.5))
    world.at(4.5, lambda: setattr(world.links["telemetry"], "corruption", 0.0))
    arm_and_engage(world).run(6.0)
    log.recorder.tick(world.now_ns)
    tables = Tables("s.otl", parse=Generic().parse, wanted=plain, health=Health())
    tables.take(Records(bytes(log.disk.data), "s.otl", NAMES, most=MOST))
    return world, tables.signals()


def by_name(signals: list[Signal]) -> dict[str, np.ndarray]:
    return {one.name: one.values for one in signals}


def test_tables_hold_what_was_in_the_world(made: Made) -> None:
    world, tables = made
    set_points = by_name(tables[SET_POINT])
    motions = np.array([row.motion for row in world.trace])
    assert set_points["commanded sway velocity"].tobytes() == motions[:, 1, 1].tobytes()
    assert set_points["commanded pitch"].tobytes() == motions[:, 0, 4].tobytes()
    np.testing.assert_allclose(tables[SET_POINT][0].t, [1e-9 * row.time_ns for row in world.trace], atol=1e-9)
    reference = by_name(tables[REFERENCE])
    t = tables[REFERENCE][0].t - 1e-3  # the link's delay
    wanted = np.array([DRIVE(one) for one in t])
    for column, name in enumerate(("ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")):
        np.testing.assert_allclose(reference[name], wanted[:, column], atol=1e-6)  # the packet has 32 bits
    gaps = np.diff(t)
    assert ((t > 4.0) & (t < 4.5)).sum() < 20  # damaged ones are left out …
    assert gaps[t[:-1] > 4.6].max() < 0.02  # … and all others are there
    changes = [event.after.encode() for event in world.output.session.events]
    assert by_name(tables[EVENT])["after"].tolist() == changes
    assert changes[-1] == b"engaged"
    assert {one.unit for one in tables[MEASURED]} == {"m", "rad", ""}


def test_the_reference_is_read_back_as_a_drive(made: Made, tmp_path: Path) -> None:
    _, tables = made
    path = tmp_path / "x.csv"
    files.write_tables(path, tables, {}, table=REFERENCE)
    log = files.read_log(path, {})
    reference, t = by_name(tables[REFERENCE]), tables[REFERENCE][0].t
    felt = log.felt(t - t[0])
    for column, name in enumerate(("ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")):
        np.testing.assert_allclose(felt[:, column], reference[name], atol=1e-9)
    text = path.read_text().splitlines()
    assert text[0].startswith("time [s],ax [m/s^2],ay [m/s^2],az [m/s^2],roll_rate [rad/s]")
    first = np.array([float(number) for number in text[1].split(",")])
    assert first[1] == reference["ax"][0]  # bit for bit


def test_hdf5_has_all_tables_with_their_units(made: Made, tmp_path: Path) -> None:
    _, tables = made
    path = tmp_path / "x.h5"
    files.write_tables(path, tables, {"log": "s.otl"}, table=REFERENCE)
    with h5py.File(path) as file:
        assert file.attrs["log"] == "s.otl"
        assert set(file) == set(tables)
        force = file["reference/ax"]
        assert force.attrs["unit"] == "m/s^2"
        assert force[()].tobytes() == by_name(tables[REFERENCE])["ax"].tobytes()
        assert file["set-points/time"].attrs["unit"] == "s"
        assert file["events/after"][-1] == str(State.ENGAGED).encode()


def test_mdf_has_all_tables_with_their_units(made: Made, tmp_path: Path) -> None:
    asammdf = pytest.importorskip("asammdf", exc_type=ImportError)
    _, tables = made
    path = tmp_path / "x.mf4"
    files.write_tables(path, tables, {}, table=REFERENCE)
    with asammdf.MDF(path) as file:
        assert len(file.groups) == len(tables)
        sway = file.get("commanded sway velocity")
        assert sway.unit == "m/s"
        assert sway.samples.tobytes() == by_name(tables[SET_POINT])["commanded sway velocity"].tobytes()
        np.testing.assert_array_equal(sway.timestamps, tables[SET_POINT][0].t)
        assert file.get("after").samples[-1] == b"engaged"
    assert files.read_log(path, {}).duration == pytest.approx(np.ptp(tables[REFERENCE][0].t))


def test_a_table_that_is_not_there_is_refused(made: Made, tmp_path: Path) -> None:
    _, tables = made
    del tables[MEASURED]
    with pytest.raises(InputError, match="table is 'measured', must be one of reference, set-points"):
        files.write_tables(tmp_path / "x.csv", tables, {}, table=MEASURED)
    assert not list(tmp_path.iterdir())
