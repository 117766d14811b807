"""Axes found by experiment: whatever way a source turns its vectors is undone, or refused by name."""

import dataclasses
import itertools
import struct

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.live.messages import Telemetry
from otolith.live.wire.axes import AxisMap, axes_from_toml, rows_matrix
from otolith.live.wire.formats import WireError
from otolith.live.wire.forza import Forza
from otolith.live.wire.learned import PARTS, Shown, learn, shown
from otolith.live.wire.lfs import OutSim
from otolith.live.wire.minute import NotLearned, minute_of
from tests.live.wire.minute import DRIVE, DT, PHASES, Driven, G, driven, forza_packet, samples

ONE_G = np.array([0.0, 0.0, G])
TURNS = [
    np.diag(signs)[list(order)]
    for order in itertools.permutations(range(3))
    for signs in itertools.product((1.0, -1.0), repeat=3)
]
STATES = [
    (turn, unit, gravity)
    for turn in TURNS
    for unit, gravity in (("m/s²", True), ("g", True), ("m/s²", False))
]


def _noise(seed: int, size: float) -> np.ndarray:
    return size * np.random.default_rng(seed).normal(size=DRIVE.force.shape)


@pytest.mark.parametrize(("turn", "unit", "gravity"), STATES[::3] + STATES[1::12] + STATES[2::3])
def test_any_axes_unit_and_gravity_are_undone(turn: np.ndarray, unit: str, gravity: bool):
    """Rates follow the hand of the axes, as those of left-handed games do."""
    handed = np.linalg.det(turn)
    size = G if unit == "g" else 1.0
    felt = DRIVE.force + (ONE_G if gravity else 0.0)
    force = (felt @ turn.T + _noise(1, 0.05)) / size
    rate = handed * (DRIVE.rate @ turn.T)
    learned = learn(minute_of("game", samples(DRIVE, force, rate)))
    axes = learned.axes
    expected = turn.T.copy()
    if not gravity and handed < 0.0:
        expected[2] *= -1.0  # nothing shows the vertical sign: right-handed axes are assumed …
        assert any("vertical force is not proven" in note for note in learned.notes)
    assert np.array_equal(rows_matrix(axes.force), expected)
    assert (axes.force_unit, axes.gravity, axes.frame) == (unit, gravity, "car")
    if gravity or handed > 0.0:
        assert np.array_equal(rows_matrix(axes.rate), handed * turn.T)
        sample = Telemetry(acceleration=force[500], angular_rate=rate[500])
        assert np.allclose(axes.wanted(sample), [*DRIVE.force[500], *DRIVE.rate[500]], atol=0.3)


def test_the_sign_of_the_yaw_rate_is_its_own():
    """A game may turn its rates otherwise than its forces."""
    learned = learn(minute_of("game", samples(DRIVE, DRIVE.force, -DRIVE.rate)))
    assert learned.axes.force == ("1", "2", "3")
    assert learned.axes.rate == ("-1", "-2", "-3")


def test_rates_in_degrees_are_noticed():
    learned = learn(minute_of("game", samples(DRIVE, DRIVE.force, np.degrees(DRIVE.rate))))
    assert learned.axes.rate_unit == "deg/s"
    wanted = learned.axes.wanted(Telemetry(acceleration=np.zeros(3), angular_rate=np.array([0.0, 0.0, 90.0])))
    assert wanted[5] == pytest.approx(np.pi / 2)


def _in_world(drive: Driven) -> np.ndarray:
    c, s = np.cos(drive.heading), np.sin(drive.heading)
    x, y, z = drive.force.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=1)


def test_world_axes_are_found_where_an_attitude_is_sent():
    learned = learn(minute_of("game", samples(DRIVE, _in_world(DRIVE), DRIVE.rate, attitude=True)))
    assert learned.axes.frame == "world"
    k = 1500
    sample = samples(DRIVE, _in_world(DRIVE), DRIVE.rate, attitude=True)[k][1]
    assert np.allclose(learned.axes.wanted(sample)[:3], DRIVE.force[k], atol=1e-9)
    with pytest.raises(WireError, match="its forces are in world axes"):
        learned.axes.wanted(dataclasses.replace(sample, attitude=None))


def test_world_axes_without_attitude_are_refused_by_the_circle():
    with pytest.raises(
        NotLearned, match=r"test 'circle' of game is a correlation of .* vectors in world axes need"
    ):
        learn(minute_of("game", samples(DRIVE, _in_world(DRIVE), DRIVE.rate)))


@pytest.mark.parametrize(
    ("phases", "words"),
    [
        (
            ((1.0, 0, 0), *PHASES[1:8], (4.0, -4.0, 0.0)),
            "test 'level rest' of game is .* s below 0.3 m/s, must be at least 3 s",
        ),
        ((*PHASES[:1], (40.0, 0.0, 0.0), *PHASES[-1:]), "test 'straight' of game is .* too little motion"),
        ((*PHASES[:4], (24.0, 0.0, 0.0), *PHASES[7:]), "test 'circle' of game"),
    ],
)
def test_what_was_not_driven_is_named(phases, words: str):
    drive = driven(phases)
    with pytest.raises(NotLearned, match=words):
        learn(minute_of("game", samples(drive, drive.force, drive.rate)))


def test_a_slope_at_rest_is_refused():
    tilted = DRIVE.force + G * np.array([np.sin(0.2), 0.0, np.cos(0.2)])
    with pytest.raises(NotLearned, match="test 'level rest' of game is a mean force of"):
        learn(minute_of("game", samples(DRIVE, tilted, DRIVE.rate)))


def test_noise_that_hides_the_relation_is_refused():
    loud = DRIVE.force + np.where(DRIVE.speed[:, None] > 0.3, _noise(2, 60.0), 0.0)
    with pytest.raises(NotLearned, match="a correlation of 0"):
        learn(minute_of("game", samples(DRIVE, loud, DRIVE.rate)))


def test_a_unit_that_fits_neither_is_refused():
    with pytest.raises(
        NotLearned, match=r"test 'straight' of game is a slope of 0.3, must be 1 for m/s² or 0.102 for g"
    ):
        learn(minute_of("game", samples(DRIVE, 0.3 * DRIVE.force, DRIVE.rate)))


def _without(sample: Telemetry, name: str) -> Telemetry:
    kept = {one.name: getattr(sample, one.name) for one in dataclasses.fields(Telemetry)}
    return Telemetry(**{**kept, name: None})


@pytest.mark.parametrize("name", ["acceleration", "angular_rate", "speed"])
def test_what_a_source_does_not_send_is_named(name: str):
    sent = [(t, _without(one, name)) for t, one in samples(DRIVE, DRIVE.force, DRIVE.rate)]
    with pytest.raises(NotLearned, match="what game sends is without"):
        minute_of("game", sent)
    with pytest.raises(NotLearned, match="duration of the minute of game"):
        minute_of("game", samples(DRIVE, DRIVE.force, DRIVE.rate)[:300])


def test_rates_of_the_attitude_serve_where_none_are_sent():
    """Codemasters' fixed packet and WRC have directions and no rates. The heading passes half a turn."""
    sent = [
        (t, _without(one, "angular_rate"))
        for t, one in samples(DRIVE, DRIVE.force, DRIVE.rate, attitude=True)
    ]
    minute = minute_of("game", sent)
    assert np.ptp(DRIVE.heading) > np.pi
    yaw = np.interp(minute.t, DRIVE.t, DRIVE.rate[:, 2])
    assert np.abs(minute.rate[:, 2] - yaw).max() < 0.01
    learned = learn(minute)
    assert learned.axes.force == ("1", "2", "3")
    assert any("no rates" in note for note in learned.notes)
    assert np.array_equal(learned.axes.wanted(sent[500][1])[3:], np.zeros(3))


def test_an_attitude_whose_sign_changes_is_interpolated_the_short_way():
    world = samples(DRIVE, _in_world(DRIVE), DRIVE.rate, attitude=True)
    flipped = []
    for k, (t, one) in enumerate(world):
        assert one.attitude is not None
        flipped.append((t, dataclasses.replace(one, attitude=one.attitude * (-1.0) ** k)))
    assert learn(minute_of("game", flipped)).axes == learn(minute_of("game", world)).axes


def test_forza_packets_of_a_minute():
    """Through the parser: X right, Y up, Z forward become ours, and nothing is left to turn."""
    sent = [(float(t), Forza().parse(forza_packet(k))) for k, t in enumerate(DRIVE.t)]
    axes = learn(minute_of("forza", sent)).axes
    assert axes.force == axes.rate == ("1", "2", "3")
    assert not axes.gravity


def test_lfs_read_as_car_axes_is_found_to_be_world():
    """What one public reader assumes is contradicted by a circle, and the map repairs it."""
    world, sent = _in_world(DRIVE), []
    for t, f, w, v, h in zip(DRIVE.t, world, DRIVE.rate, DRIVE.speed, DRIVE.heading, strict=True):
        numbers = (w[0], w[1], w[2], h, 0.0, 0.0, -f[1], f[0], f[2], -v * np.sin(h), v * np.cos(h), 0.0)
        packet = struct.pack("<I12f3i", round(1e3 * t), *numbers, 0, 0, 0)
        sent.append((float(t), packet))
    as_car = learn(minute_of("lfs", [(t, OutSim(frame="car").parse(p)) for t, p in sent])).axes
    as_world = learn(minute_of("lfs", [(t, OutSim().parse(p)) for t, p in sent])).axes
    assert (as_car.frame, as_world.frame) == ("world", "car")
    k = 1500
    felt = as_car.wanted(OutSim(frame="car").parse(sent[k][1]))
    assert np.allclose(felt[:3], as_world.wanted(OutSim().parse(sent[k][1]))[:3], atol=1e-4)
    assert np.allclose(felt[:3], DRIVE.force[k], atol=1e-4)


def test_two_packets_per_frame_are_joined_by_their_clocks():
    """F1 sends forces and rates in packets of their own."""
    sent = []
    for t, one in samples(DRIVE, DRIVE.force, DRIVE.rate):
        sent.append((t, dataclasses.replace(one, angular_rate=None)))
        sent.append((t + 0.4 * DT, dataclasses.replace(one, acceleration=None)))
    assert learn(minute_of("f1", sent)).axes.force == ("1", "2", "3")


LEARNED = learn(minute_of("game", samples(DRIVE, DRIVE.force, DRIVE.rate))).axes


def test_a_map_there_and_back():
    text = LEARNED.to_toml()
    assert axes_from_toml("name = 'mine'\n" + text, "s.toml") == LEARNED
    assert LEARNED.evidence["straight"] > 0.99
    reference = LEARNED.reference(Telemetry(acceleration=np.array([1.0, 2.0, 3.0])))
    assert np.array_equal(reference.specific_force, [1.0, 2.0, 3.0])
    assert np.array_equal(reference.angular_rate, np.zeros(3))
    with pytest.raises(WireError, match="without a force"):
        LEARNED.wanted(Telemetry())


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('force_unit = "m/s²"', 'force_unit = "g"', "sha256 of .axes. in s.toml is .*learn the axes again"),
        ('"2", "3"]', '"-2", "3"]', "sha256"),
        ('force_unit = "m/s²"', 'force_unit = "ft"', "force_unit of the axis map is 'ft'"),
        ("gravity = false", "gravity = 0", "gravity of .axes. in s.toml is 0, must be of kind bool"),
        ("gravity = false\n", "", "without gravity"),
        ("gravity = false", "grav = false", "did you mean gravity"),
        ("[axes]", "[axis]", r"\[axes\] of s.toml is missing"),
        ("[axes]", "[axes", "not TOML"),
        ("sha256 = ", "sha257 = ", "field of .axes. in s.toml is 'sha257'"),
    ],
)
def test_an_altered_map_is_refused(old: str, new: str, words: str):
    with pytest.raises(InputError, match=words):
        axes_from_toml(LEARNED.to_toml().replace(old, new, 1), "s.toml")


@pytest.mark.parametrize("rows", [("1", "2", "2"), ("1", "2", "4"), ("1", "2", "--3")])
def test_rows_that_are_no_permutation_are_refused(rows):
    with pytest.raises(InputError, match="force of the axis map is"):
        AxisMap(source="game", force=rows)


def _until(seconds: float, factor: float = 1.0) -> dict[str, Shown]:
    """Return what the first seconds of the drive show; its rates are multiplied by a factor."""
    taken = [one for one in samples(DRIVE, DRIVE.force, factor * DRIVE.rate) if one[0] <= seconds]
    return {one.part: one for one in shown(minute_of("game", taken))}


def test_while_it_is_driven_each_part_shows_when_it_is_enough():
    """A part has passed when `learn` would not fail for it, and not before it was driven."""
    times = np.arange(14.0, DRIVE.t[-1], 2.0)
    passed = [{part for part, one in _until(t).items() if one.passed} for t in times]
    assert passed[0] >= {"stand"}
    assert "circle" not in passed[0]
    assert "turn" not in passed[0]
    assert passed[-1] == set(PARTS)
    end = _until(DRIVE.t[-1])
    learned = learn(minute_of("game", samples(DRIVE, DRIVE.force, DRIVE.rate)))
    assert end["accelerate"].value == pytest.approx(learned.axes.evidence["straight"], abs=1e-4)
    assert end["circle"].value == pytest.approx(learned.axes.evidence["circle"], abs=1e-4)
    turned = np.degrees(np.abs(DRIVE.heading - DRIVE.heading[0]).max())
    assert end["turn"].value == pytest.approx(turned, rel=0.02)
    assert _until(DRIVE.t[-1], np.degrees(1.0))["turn"].value == pytest.approx(turned, rel=0.02)


def test_what_was_not_driven_is_not_shown_as_driven():
    calm = driven((PHASES[0], (40.0, 0.0, 0.0), PHASES[-1]))
    parts = {one.part: one for one in shown(minute_of("game", samples(calm, calm.force, calm.rate)))}
    assert parts["stand"].passed
    assert not any(parts[part].passed for part in ("accelerate", "brake", "circle", "turn"))
