"""Stretches that no vehicle drove are found, named, cut or bridged; driving is left alone."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings import Log
from otolith.recordings.channels import Channel
from otolith.recordings.columns import Column
from otolith.recordings.events.halts import find_halts, find_replays
from otolith.recordings.settings import LogSettings
from tests.recordings import vehicles
from tests.recordings.checks.drives import ALL, attempt, read, written

Data = dict[str, Vec]
PLANE = ("ax", "ay", "yaw_rate", "vx")
CUT, MARK = LogSettings(events="cut"), LogSettings(events="mark")


def drive(keys: tuple[str, ...] = PLANE) -> Data:
    """Forty seconds of a level car at 50 Hz, with what a real sensor adds."""
    noise = np.random.default_rng(4)
    data = {key: values[:2000] for key, values in written(vehicles.car(), keys).items()}
    return {k: v + (noise.normal(0.0, 0.02, len(v)) if k in ("ax", "ay") else 0.0) for k, v in data.items()}


def paused(data: Data, at: int, rows: int) -> Data:
    """All channels but time stand still for so many rows, then the drive goes on."""
    held = {k: np.r_[v[:at], np.full(rows, v[at - 1]), v[at:]] for k, v in data.items()}
    return held | {"t": 0.02 * np.arange(len(data["t"]) + rows)}


def respawned(data: Data, at: int, rows: int) -> Data:
    """At a row the car is put back at rest, stands, and the drive goes on elsewhere."""
    rest = {k: np.zeros(rows) for k in data}
    later = 900
    new = {
        k: np.r_[v[:at], rest[k], v[at + later :] - (v[at + later] if k == "vx" else 0.0)]
        for k, v in data.items()
    }
    n = len(new["vx"])
    new["vx"] = np.r_[data["vx"][:at], np.zeros(rows), np.cumsum(np.r_[0.0, np.diff(new["vx"][at + rows :])])]
    new["vx"] -= np.minimum(0.0, new["vx"].min()) * (np.arange(n) >= at + rows)
    return new | {"t": 0.02 * np.arange(n)}


def named(log: Log, kind: str) -> list[str]:
    return [note for note in log.notes if note.startswith(f"{kind} from")]


def kinds(log: Log) -> list[str]:
    assert log.found is not None
    return [event.kind for event in log.found.events]


def test_a_drive_without_events_has_none() -> None:
    assert kinds(read(drive())) == []
    assert kinds(read(drive(ALL))) == []


@pytest.mark.parametrize("vehicle", [vehicles.oval(70.0), vehicles.motorcycle(), vehicles.hills()])
def test_other_vehicles_have_none_either(vehicle: vehicles.Ride) -> None:
    assert kinds(read(written(vehicle))) == []


def test_a_pause_is_refused_marked_or_cut() -> None:
    whole, data = drive(), paused(drive(), 750, 150)
    with pytest.raises(InputError) as caught:
        read(data)
    assert "not driving in 1 place: pause from 14.98 s to 18 s (all forces unchanged for 3 s" in str(
        caught.value
    )
    assert "--events cut takes them out, --events mark plays them as they are" in str(caught.value)
    marked = read(data, MARK)
    assert_allclose(marked.channels["ay"].values, data["ay"], atol=1e-8)
    assert "played as it is" in named(marked, "pause")[0]
    log = read(data, CUT)
    assert log.duration == pytest.approx(whole["t"][-1], abs=0.03)
    assert_allclose(log.channels["ay"].on(whole["t"]), whole["ay"], atol=1e-6)


def test_a_pause_without_a_speed_is_sure_where_stray_packets_come_in_between() -> None:
    """Re-made from a public complaint: zeros arrive while a game is paused."""
    noisy = paused({k: v for k, v in drive().items() if k in ("t", "ax", "ay")}, 750, 500)
    with pytest.raises(InputError, match="of a sensor that jitters otherwise"):
        read(noisy)
    smooth = {k: v[:2000] for k, v in written(vehicles.car(), ("ax", "ay")).items()}
    data = paused(smooth, 750, 500)
    log = read(data)
    assert kinds(log) == ["held"]  # a steady manoeuvre may look so: it is said, and played
    assert "it may be driving" in named(log, "held")[0]
    for row in (900, 1000, 1100):
        data["ax"][row] = data["ay"][row] = 0.0
    with pytest.raises(InputError, match=r"pause from 14\.98 s to 25 s .* with 3 stray packets"):
        read(data)
    assert_allclose(read(data, CUT).channels["ax"].on(smooth["t"]), smooth["ax"], atol=1e-6)


def test_stray_packets_of_zeros_are_bridged_in_place() -> None:
    data = drive()
    for row in (300, 301, 1203):
        for key in PLANE:
            data[key][row] = 0.0
    with pytest.raises(InputError, match=r"stray packet from 5\.98 s to 6\.04 s \(packet of zeros, 2 rows"):
        read(data)
    log = read(data, CUT)
    assert log.duration == pytest.approx(39.98)
    assert_allclose(log.channels["ax"].on(data["t"]), drive()["ax"], atol=0.15)


def test_a_spike_of_one_row_is_bridged() -> None:
    data = drive()
    data["ax"][700] = -48.0
    with pytest.raises(InputError, match=r"stray packet from 13\.98 s to 14\.02 s \(spike of ax, 1 row"):
        read(data)
    assert_allclose(read(data, CUT).channels["ax"].on(data["t"]), drive()["ax"], atol=0.15)


def test_a_respawn_is_named_with_its_size_and_cut_with_a_bridge() -> None:
    data = respawned(drive(), 750, 200)
    with pytest.raises(InputError) as caught:
        read(data)
    assert "jump from 14.98 s" in str(caught.value)
    assert "speed changes by" in str(caught.value)
    log = read(data, CUT)
    ax = log.channels["ax"]
    inside = (ax.t > 14.98 + 1e-9) & (ax.t < 15.98 - 1e-9)
    assert not inside.any()  # one second of straight line
    assert_allclose(ax.values[ax.t <= 14.98], data["ax"][:750], atol=1e-8)
    assert log.duration < data["t"][-1] - 2.0


def test_a_teleport_shows_in_the_positions() -> None:
    data = drive((*PLANE, "x", "y"))
    data["x"][1000:] += 80.0
    note = named(read(data), "stray position")[0]
    assert "the position jumps by 80" in note
    data["ay"][1000:] += 6.0  # now the forces leap, too: the car is elsewhere
    with pytest.raises(InputError, match=r"jump from 19\.98 s .*the position jumps by 8\d"):
        read(data)


def test_a_glitch_of_the_speed_alone_is_not_felt_and_only_said() -> None:
    data = drive()
    data["vx"][800:803] = 0.0
    log = read(data)
    assert kinds(log) == ["stray speed"]
    assert_allclose(log.channels["ax"].values, data["ax"], atol=1e-8)


def test_rows_that_come_again_are_told() -> None:
    data = drive()
    again = {k: np.r_[v[:1500], v[500:800], v[1500:]] for k, v in data.items()}
    again["t"] = 0.02 * np.arange(len(again["vx"]))
    assert "replay" in kinds(read(again, MARK))


@pytest.mark.parametrize("rate", [100.0, 250.0])
def test_chatter_is_told_with_its_frequency_and_low_passed_on_request(rate: float) -> None:
    """Re-made from a public complaint: 47 Hz on top of a drive."""
    t = np.arange(0.0, 40.0, 1.0 / rate)
    quiet = np.sin(0.5 * t)
    shaking = (t > 12.0) & (t < 20.0)
    data = {"t": t, "ax": quiet + 3.0 * np.sin(2.0 * np.pi * 47.0 * t) * shaking, "ay": 0.5 * np.cos(0.3 * t)}
    log = read(data)
    (note,) = named(log, "chatter")
    assert "ax shakes at about 47 Hz, 2.1 m/s² rms" in note
    assert "--lowpass 5" in note
    smooth = read(data, CUT)
    inside = (t > 13.0) & (t < 19.0)
    assert float(np.abs(smooth.channels["ax"].values - quiet)[inside].max()) < 0.1
    outside = (t < 11.0) | (t > 21.0)
    assert_allclose(smooth.channels["ax"].values[outside], data["ax"][outside], atol=1e-8)


def test_a_drive_with_most_energy_above_10_hz_is_told_of_the_low_pass_and_what_it_leaves() -> None:
    t = np.arange(0.0, 30.0, 0.01)
    data = {"t": t, "ax": np.sin(0.4 * t) + 2.0 * np.sin(2.0 * np.pi * 13.0 * t), "ay": 0.0 * t}
    (note,) = (n for n in read(data).notes if "of its energy lies above 10 Hz" in n)
    assert "ax: 79 %" in note
    assert "--lowpass 5 leaves 0.7" in note  # the sine of 0.71 m/s² rms that is driving


def test_values_that_are_held_for_several_rows_are_no_pause() -> None:
    """60 Hz written in rows of 250 Hz, and satellites' speed once a second in rows of 20 Hz."""
    t = np.arange(0.0, 30.0, 0.004)
    held = np.floor(t * 60.0) / 60.0
    assert kinds(read({"t": t, "ax": np.sin(held), "ay": np.cos(held)})) == []
    data = {key: np.round(values, 2) for key, values in drive().items()} | {"t": drive()["t"]}
    data["vx"] = data["vx"][::50].repeat(50)
    assert not [kind for kind in kinds(read(data)) if kind == "pause"]


def test_a_car_that_stands_and_a_steady_manoeuvre_with_speed_are_no_events() -> None:
    t = np.arange(0.0, 40.0, 0.05)
    stands = {"t": t, "ax": 0.0 * t, "ay": 0.0 * t, "vx": 0.0 * t}
    assert kinds(read(stands | {"ax": np.where(t > 30.0, 1.0, 0.0), "vx": np.maximum(t - 30.0, 0.0)})) == []
    circle = {"t": t, "ax": 0.0 * t, "ay": np.full_like(t, 4.0), "vx": np.full_like(t, 20.0)}
    circle |= {"yaw_rate": np.full_like(t, 0.2)}
    circle = {k: np.where(t < 5.0, 0.0, v) if k in ("ay", "yaw_rate") else v for k, v in circle.items()}
    assert kinds(read(circle)) == []


def test_a_frozen_sensor_is_named() -> None:
    data = drive()
    data["ax"][300:500], data["ay"][300:500] = data["ax"][300], data["ay"][300]
    log, sentence = attempt(data)
    assert log is None
    assert "frozen sensor from 6 s to 10 s" in sentence


def test_signs_are_judged_on_the_driving_alone() -> None:
    """A respawn must not hide that all signs are turned, nor count as a turned sign."""
    data = respawned(drive((*PLANE, "heading")), 750, 200)
    data["ay"], data["yaw_rate"] = -data["ay"], -data["yaw_rate"]
    log = read(data, MARK)
    assert log.found is not None
    assert set(log.found.turned) == {"ay", "yaw_rate"}
    assert_allclose(log.channels["ay"].values, -data["ay"], atol=1e-8)


@pytest.mark.parametrize("held", [1, 2, 7])
def test_the_work_of_finding_halts_and_replays_grows_with_the_rows_alone(
    held: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A periodic log stands still, or returns, thousands of times; no median is taken anew."""
    n, wave = 20_000, np.array([0.0, 9.0, 2.0, 1.0, 5.0, 5.0])
    values = np.resize(np.repeat(wave, held), n)
    column = Column("ax", 0, "ax", 1.0, "m/s2", assumed=False)
    t = 0.001 * np.arange(n, dtype=float)
    ax = Channel(column=column, t=t, values=values, rows=np.arange(n), place="line", source="log.csv")
    ay = replace(ax, column=replace(column, key="ay"), values=values[::-1])
    looked_at, median = [0], np.median

    def counting(a: Vec) -> float:
        looked_at[0] += len(a)
        return float(median(a))

    monkeypatch.setattr(np, "median", counting)
    assert find_halts({"ax": ax, "ay": ay}, []) == []
    assert find_replays([ax, ay]) == []
    assert looked_at[0] <= 4 * n


def gapped(data: Data, first: int, last: int) -> Data:
    """The recorder pauses: the rows from the first to the last are not there, and the clock runs on."""
    return {k: np.r_[v[:first], v[last:]] for k, v in data.items()}


def test_a_recorders_pause_is_refused_with_its_length_and_cut_with_a_bridge() -> None:
    whole, data = drive(), gapped(drive(), 750, 1000)
    with pytest.raises(InputError, match=r"14.98 s after the first row, is 5.02 s, .*--events cut joins"):
        read(data)
    log = read(data, CUT)
    assert kinds(log) == ["gap"]
    assert named(log, "gap") == ["gap from 14.98 s to 20 s (no ax and ay for 5.02 s): cut out"]
    assert log.duration == pytest.approx(39.98 - 5.02 + 1.0)  # a second of straight line stands for it
    t = np.arange(0.0, 14.9, 0.1)
    assert_allclose(log.felt(t)[:, 1], np.interp(t, data["t"], whole["ay"][: len(data["t"])]), atol=1e-6)
    after = np.arange(16.0, 30.0, 0.1)
    assert_allclose(log.felt(after)[:, 1], np.interp(after + 4.02, whole["t"], whole["ay"]), atol=1e-6)


def test_a_recorders_pause_that_is_marked_is_a_straight_line() -> None:
    data = gapped(drive(), 750, 1000)
    log = read(data, MARK)
    assert named(log, "gap")[0].endswith("(no ax and ay for 5.02 s): played as a straight line")
    ends = np.interp([14.98, 20.0], data["t"], data["ay"])
    assert log.felt(np.array([17.49]))[0, 1] == pytest.approx(ends.mean(), abs=1e-6)


def test_a_gap_in_one_channel_cuts_all_of_them() -> None:
    data = drive()
    lost = (data["t"] > 10.0) & (data["t"] < 13.0)
    log = read(data | {"ay": np.where(lost, np.nan, data["ay"])}, CUT)
    assert named(log, "gap") == ["gap from 10 s to 13 s (no ay for 3 s): cut out"]
    after = np.arange(11.1, 20.0, 0.1)
    assert_allclose(log.felt(after)[:, 0], np.interp(after + 2.0, data["t"], data["ax"]), atol=1e-6)


@pytest.mark.parametrize("again", [1, 2])
def test_a_clock_that_starts_anew_is_a_pause_of_unknown_length(again: int) -> None:
    data = drive()
    rows = 2000 // (again + 1)
    data |= {
        "t": np.where(
            data["t"] < 0.02 * again * rows, data["t"] % (0.02 * rows), data["t"] - 0.02 * again * rows
        )
    }
    with pytest.raises(InputError, match=rf"time in line {rows + 2} of .* as at the beginning again"):
        read(data)
    log = read(data, CUT)
    assert kinds(log) == ["gap"] * again
    assert any("starts anew in line" in note for note in log.notes)
    assert log.duration == pytest.approx(0.02 * (1999 - again) + again * 1.0)


def test_a_stamp_that_goes_astray_is_no_clock_that_starts_anew() -> None:
    data = drive()
    with pytest.raises(InputError, match=r"time in line 502 of .* must be after the row before"):
        read(data | {"t": np.where(np.arange(2000) == 500, 0.0, data["t"])}, CUT)


def calm(keys: tuple[str, ...], speed: float) -> Data:
    """Straight ahead at one speed: the noise of a sensor and nothing else."""
    noise, one = np.random.default_rng(5), vehicles.ride(lambda t: np.full_like(t, speed), np.zeros_like)
    data = {key: values[:2000] for key, values in written(one, keys).items()}
    return data | {k: data[k] + noise.normal(0.0, 0.02, 2000) for k in ("ax", "ay")}


@pytest.mark.parametrize("seen", [("lat", "lon"), ("x", "y"), ("vx",)])
def test_a_pause_on_a_straight_is_sure_where_speed_or_positions_tell_that_it_moved(
    seen: tuple[str, ...],
) -> None:
    data = calm(("ax", "ay", *seen), 12.0)
    assert kinds(read(data)) == []
    held = paused(data, 750, 150)
    with pytest.raises(InputError, match=r"pause from 14\.98 s to 18 s \(all forces unchanged for 3 s"):
        read(held)
    assert_allclose(read(held, CUT).channels["ay"].on(data["t"]), data["ay"], atol=1e-6)


def test_a_pause_of_a_calm_sensor_that_nothing_shows_to_have_moved_is_told_and_played() -> None:
    log = read(paused(calm(("ax", "ay"), 12.0), 750, 150))
    assert kinds(log) == ["held"]
    assert "of a sensor that jitters otherwise; or it stands there" in named(log, "held")[0]


@pytest.mark.parametrize("seen", [("x", "y"), ("vx",)])
def test_a_vehicle_that_stands_still_to_the_last_digit_is_not_paused(seen: tuple[str, ...]) -> None:
    """A game's car that brakes to a stop as hard as it can, stands for ten seconds and starts again."""
    t = 0.02 * np.arange(2000)
    ax = np.where((t > 5.0) & (t <= 7.0), -9.0, np.where((t > 17.0) & (t <= 19.0), 9.0, 0.0))
    vx = 18.0 + 0.02 * np.cumsum(ax)
    vx[(t > 7.0) & (t <= 17.0)] = 0.0
    noise = np.where(vx > 0.0, np.random.default_rng(6).normal(0.0, 0.02, len(t)), 0.0)
    data = {
        "t": t,
        "ax": ax + noise,
        "ay": noise[::-1] * (vx > 0.0),
        "vx": vx,
        "x": 0.02 * np.cumsum(vx),
        "y": 0.0 * t,
    }
    log = read({key: data[key] for key in ("t", "ax", "ay", *seen)})
    assert "pause" not in kinds(log)
    assert log.duration == pytest.approx(t[-1])
