"""Moves between poses at rest."""

import re
from pathlib import Path

import numpy as np
import pytest

import otolith.live
from otolith.live.core.bounds import ACCELERATION, SPEED
from otolith.live.core.gate import Gate
from otolith.live.core.moves import JERK, CannotMove, Move
from tests.live.conftest import PARK


def sampled(move: Move, dt: float) -> np.ndarray:
    times = np.append(np.arange(0.0, move.duration, dt), move.duration + dt)
    motions = np.empty((len(times), 3, 6))
    for motion, seconds in zip(motions, times, strict=True):
        move.at(float(seconds), motion)
    return motions


def start(pose: np.ndarray) -> np.ndarray:
    motion = np.zeros((3, 6))
    motion[0] = pose
    return motion


def test_a_move_is_straight_begins_and_ends_at_rest_and_keeps_speed_acceleration_and_jerk(
    travel: Gate,
) -> None:
    goal = np.array([0.05, -0.04, 0.0, 0.02, -0.03, 0.0])
    move = Move(start(PARK), goal, travel)
    dt = 1e-3
    motions = sampled(move, dt)
    way = goal - PARK
    along = (motions[:, 0] - PARK) @ way / (way @ way)
    np.testing.assert_allclose(motions[:, 0], PARK + np.outer(along, way), atol=1e-12)
    np.testing.assert_allclose(motions[0, 0], PARK, atol=1e-12)
    np.testing.assert_array_equal(motions[-1], start(goal))
    speed, strength = np.diff(motions[:-1, 0], axis=0) / dt, np.diff(motions[:-1, 1], axis=0) / dt
    jerk = np.diff(motions[:-1, 2], axis=0) / dt
    for found, most in ((speed, SPEED), (strength, ACCELERATION), (jerk, JERK)):
        assert np.abs(found).max(axis=0).max() <= most.max() * (1.0 + 1e-6)
        assert (np.abs(found) <= most * (1.0 + 1e-6)).all()


def test_a_rise_of_36_cm_takes_as_long_as_its_closed_form(travel: Gate) -> None:
    # seven phases of which four change the acceleration: T = way / v + v / a + a / j
    move = Move(start(PARK), np.zeros(6), travel)
    v, a, j = SPEED[2], ACCELERATION[2], JERK[2]
    share = min(1.0, 0.5 * travel.bounds.acceleration[2] / a)  # of the limits that a move uses
    v, a = min(v, 0.5 * travel.bounds.twist[2]), share * a
    assert move.duration == pytest.approx(0.15 / v + v / a + a / j, rel=1e-6)


def test_no_way_is_no_move(travel: Gate) -> None:
    move = Move(start(PARK), PARK, travel)
    assert move.duration == 0.0
    motion = np.empty((3, 6))
    move.at(0.0, motion)
    np.testing.assert_array_equal(motion, start(PARK))


def test_a_pose_out_of_reach_is_refused_before_anything_moves(gate: Gate) -> None:
    with pytest.raises(CannotMove, match="surge leaves its reach"):
        Move(start(np.zeros(6)), np.array([0.3, 0, 0, 0, 0, 0.0]), gate)


def test_the_false_friends_of_ruckig_are_not_used() -> None:
    """Extrema that are wrong, limits that are ignored, and positions that ask a server."""
    banned = re.compile(r"position_extrema|max_position|min_position|intermediate_positions")
    folder = Path(otolith.live.__file__).parent
    files = list(folder.rglob("*.py"))
    assert len(files) > 20
    assert not [file.name for file in files if banned.search(file.read_text(encoding="utf-8"))]
