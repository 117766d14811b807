"""Training and held-out manoeuvres: enough of them, apart from each other, along every axis."""

import numpy as np

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.hints.training.manoeuvres import along, training, unseen


def test_the_held_out_set_is_long_enough_and_nothing_of_it_was_trained_on() -> None:
    held_out, trained = unseen(), training()
    assert sum(one.duration for one in held_out) >= 150.0  # 15,000 decisions
    t = np.arange(900, dtype=float) * 0.01
    seen = [one.wave(t) for one in trained]
    for one in held_out:
        wave = one.wave(t)
        assert np.isfinite(wave).all()
        assert min(np.max(np.abs(wave - other)) for other in seen) > 0.05


def test_every_axis_gets_a_manoeuvre_of_its_own_and_rests_now_and_then() -> None:
    scenarios = along(training(), (SURGE_PITCH, SWAY_ROLL))
    t = np.arange(400, dtype=float) * 0.01
    forces = [one.specific_force(t) for one in scenarios]
    still = [not force[:, 1].any() for force in forces]
    assert 0.1 < np.mean(still) < 0.4
    assert all(force[:, 0].any() for force in forces)
    assert not any(np.array_equal(force[:, 0], force[:, 1]) for force in forces[:20] if force[:, 1].any())


def test_equal_seeds_are_equal_drives() -> None:
    t = np.arange(1000, dtype=float) * 0.01
    for one, again in zip(unseen(), unseen(), strict=True):
        np.testing.assert_array_equal(one.wave(t), again.wave(t))
