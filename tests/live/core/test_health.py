"""What telemetry is worth: every kind of sample, and silence, with times by hand."""

import numpy as np
import pytest

from otolith.core.arrays import Vec
from otolith.live.core.health import SPIKES, Count, Health
from otolith.live.messages import Flag, Rung, Telemetry

MS = 1_000_000
STEP = 20 * MS


class Feed:
    """Samples every 20 ms, and a look at the clock after each."""

    def __init__(self, *, pauses_silently: bool = False) -> None:
        self.health = Health(pauses_silently=pauses_silently)
        self.now, self.sequence, self.phase = 0, 0, 0.0

    def sample(self, wanted: Vec | None = None, **fields: object) -> bool:
        self.now += STEP
        self.sequence += 1
        self.phase += 1e-3  # payloads differ
        force = np.full(6, self.phase) if wanted is None else wanted
        given: dict[str, object] = {
            "sequence": self.sequence,
            "sender_ns": self.now + 7_000 * MS,
            "acceleration": force[:3],
            "flags": Flag.RUNNING,
            **fields,
        }
        taken = self.health.take(self.now, Telemetry(**given), force)  # type: ignore[arg-type]
        self.rung = self.health.look(self.now).reaction.rung
        return taken

    def good(self, seconds: float = 1.5) -> "Feed":
        for _ in range(round(seconds * 50)):
            self.sample()
        return self

    def look(self, later_ms: int) -> Rung:
        return self.health.look(self.now + later_ms * MS).reaction.rung


def test_telemetry_is_cued_after_one_second_of_good_samples() -> None:
    feed = Feed()
    taken = [feed.sample() for _ in range(60)]
    assert not any(taken[:50])
    assert all(taken[53:])


@pytest.mark.parametrize(
    ("later", "rung"),
    [(20, Rung.NONE), (60, Rung.HOLD), (101, Rung.FADE), (999, Rung.FADE), (1001, Rung.RETURN)],
)
def test_silence_climbs_the_ladder(later: int, rung: Rung) -> None:
    for pauses_silently, expected in ((False, rung), (True, min(rung, Rung.FADE))):
        feed = Feed(pauses_silently=pauses_silently).good()
        feed.look(later // 2)
        assert feed.look(later) is expected


def test_before_the_first_sample_nothing_is_cued() -> None:
    assert Health().look(0).reaction.rung is Rung.FADE


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_no_number_is_dropped_and_counted(value: float) -> None:
    feed = Feed().good()
    assert not feed.sample(np.array([value, 0, 0, 0, 0, 0]))
    assert not feed.sample(velocity=np.array([value, 0, 0]))
    assert feed.health.counts[Count.NOT_FINITE] == 2
    assert feed.rung is Rung.HOLD  # missing for 40 ms


def test_packets_that_come_twice_or_late_are_dropped_and_a_tenth_of_them_is_a_warning() -> None:
    feed = Feed().good()
    last = feed.sequence
    assert not feed.sample(sequence=last)
    assert not feed.sample(sequence=last - 3)
    assert feed.health.counts[Count.TWICE] == feed.health.counts[Count.OLD] == 1
    assert not feed.health.look(feed.now).warning
    for _ in range(10):
        feed.sample(sequence=last)
    assert "twice or out of order" in feed.health.look(feed.now).warning


@pytest.mark.parametrize("back", [100, 10**6])
def test_a_restart_fades_and_needs_a_second_of_good_samples(back: int) -> None:
    feed = Feed().good(3.0)
    feed.sequence = max(0, feed.sequence - back)
    assert not feed.sample()
    assert feed.health.counts[Count.RESTART] == 1
    taken = [feed.sample() for _ in range(70)]
    assert not any(taken[:49])
    assert all(taken[53:])


def test_a_restart_of_a_young_sender_is_told_from_late_packets_by_their_number() -> None:
    feed = Feed().good(0.8)
    feed.sequence = 0
    for _ in range(20):
        feed.sample()
    assert feed.health.counts[Count.RESTART] == 1


@pytest.mark.parametrize("jump", [-3.0, -0.5, 3.0])
def test_a_jump_of_the_senders_clock_is_a_restart(jump: float) -> None:
    feed = Feed().good()
    assert not feed.sample(sender_ns=feed.now + round((7.0 + jump) * 1e9))
    assert feed.health.counts[Count.RESTART] == 1


def test_few_spikes_are_dropped_and_more_of_them_fade() -> None:
    feed = Feed().good()
    for _ in range(SPIKES):
        assert not feed.sample(np.array([1000.0, 0, 0, 0, 0, 0]))
        assert feed.rung <= Rung.HOLD
    assert not feed.sample(np.array([1000.0, 0, 0, 0, 0, 0]))
    assert feed.rung is Rung.FADE


def test_one_sample_far_off_is_a_spike_and_a_crash_that_lasts_is_none() -> None:
    feed = Feed().good()
    assert not feed.sample(np.array([0, 40.0, 0, 0, 0, 0]))
    assert feed.sample()
    assert feed.sample(np.array([0, 20.0, 0, 0, 0, 0]))
    assert feed.sample(np.array([0, 20.0, 0, 0, 0, 0]))
    assert feed.health.counts[Count.SPIKE] == 1


def test_a_level_that_stays_is_believed_at_its_second_sample() -> None:
    feed = Feed().good()
    assert not feed.sample(np.array([0, 45.0, 0, 0, 0, 0]))
    assert feed.sample(np.array([0, 45.0, 0, 0, 0, 0]))


@pytest.mark.parametrize(("speed", "rung"), [(20.0, Rung.FADE), (0.5, Rung.NONE), (None, Rung.FADE)])
def test_a_payload_that_stands_still_is_suspicious_while_the_vehicle_moves(
    speed: float | None, rung: Rung
) -> None:
    feed = Feed().good()
    for _ in range(30):
        feed.sample(np.ones(6), speed=speed)
    assert feed.rung is rung


@pytest.mark.parametrize("flags", [Flag.PAUSED | Flag.RUNNING, Flag.REPLAY | Flag.RUNNING, Flag(0)])
def test_pause_and_replay_fade(flags: Flag) -> None:
    feed = Feed().good()
    feed.sample(flags=flags)
    assert feed.rung is Rung.FADE
    feed.sample()
    assert feed.rung is Rung.NONE
    assert not feed.health.look(feed.now).healthy


def test_a_teleport_is_seen_by_its_flag_or_by_the_way() -> None:
    feed = Feed().good()
    feed.sample(flags=Flag.TELEPORTED | Flag.RUNNING)
    feed.sample(position=np.zeros(3), speed=30.0)
    feed.sample(position=np.array([0.6, 0, 0]), speed=30.0)
    assert feed.health.counts[Count.TELEPORT] == 1
    feed.sample(position=np.array([60.0, 0, 0]), speed=30.0)
    assert feed.health.counts[Count.TELEPORT] == 2


def test_force_without_a_change_of_speed_is_seen_and_a_true_one_is_not() -> None:
    feed = Feed().good()
    for k in range(60):
        feed.sample(np.array([10.0, 0, 0, 0, 0, 0]), speed=20.0 + 10.0 * 0.02 * k)
    assert feed.rung is Rung.NONE
    for _ in range(60):
        feed.sample(np.array([15.0, 0, 0, 0, 0, 0.001 * feed.phase]), speed=31.8)
    assert feed.rung is Rung.FADE


def test_a_gap_of_our_own_clock_ends_cueing() -> None:
    feed = Feed().good()
    feed.now += 30_000 * MS
    condition = feed.health.look(feed.now)
    assert condition.reaction.rung is Rung.RETURN
    assert "suspended" in condition.reaction.reason
    assert not condition.healthy
