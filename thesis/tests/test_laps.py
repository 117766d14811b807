"""The laps of section 6.3: what is braked hardest, and a stretch of a lap on the legs."""

from dataclasses import replace

import numpy as np
import pytest

from otolith_thesis import laps
from otolith_thesis.laps import Drive, LapOnLegs, hardest_braking


def test_the_hardest_braking_takes_most_speed_away_not_most_per_second() -> None:
    t = np.arange(0.0, 10.0, 0.5)
    speed = np.interp(t, [0.0, 1.0, 2.0, 3.0, 4.0, 7.0, 9.5], [30, 30, 20, 41, 40.8, 10, 12])
    found = hardest_braking(t, speed)
    assert (found.start, found.end, found.fast, found.slow) == (4.0, 7.0, 40.8, 10.0)


def test_a_braking_that_lasts_to_the_end_counts() -> None:
    t = np.arange(5.0)
    assert hardest_braking(t, np.array([1.0, 5.0, 4.0, 2.0, 0.0])).end == 4.0


@pytest.mark.parametrize(("standing", "start"), [(True, 80.2), (False, 74.7)])
def test_the_hairpin_after_the_parabolika_is_braked_hardest_from_either_start(
    standing: bool, start: float
) -> None:
    driven = Drive(120, standing).run()
    assert driven.braking.start == pytest.approx(start, abs=0.2)
    assert 3.6 * driven.braking.fast == pytest.approx(120.0, abs=1.0)
    assert driven.harshest < 15.0 or driven.harshest > 100.0  # elsewhere: it is no matter of peaks


def test_a_stretch_of_the_lap_on_the_hexapod_keeps_every_limit_but_the_soft_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Every step certified; the supervisor has nothing to do; only the soft tilt rate is exceeded."""
    stretch = replace(laps._reference(120), duration=25.0)
    monkeypatch.setattr(laps, "_reference", lambda _: stretch)
    found = LapOnLegs(120, "hybrid-all").run()
    assert found.closed.unsolved == 0
    assert found.interventions == 0
    assert set(found.broken) <= {"surge-pitch tilt_rate", "sway-roll tilt_rate"}
    assert max(np.abs(motion.tilt_deg).max() for motion in found.closed.motion.values()) > 7.9
    assert found.closed.excess["surge-pitch tilt_rate"] < np.deg2rad(1.0)
