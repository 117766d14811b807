"""How far from the best: ratios that can be done by hand, and their words."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.loop import Run
from otolith.metrics import against_best, best_in_words, summarise
from otolith.metrics.scales import TIMES_THE_BEST
from tests.metrics.stored_runs import noisy

NO_LAG = {"surge-pitch": 0.0, "sway-roll": 0.0, "yaw": 0.0}
WEIGHTS = {"surge-pitch": 1.0, "sway-roll": 1.0, "yaw": 100.0}


class Known:
    def __init__(self, run: Run, through_lag: dict[str, float] = NO_LAG) -> None:
        self.run, self.through_lag, self.weights = run, through_lag, WEIGHTS


def missing(run: Run, *shares: float) -> Run:
    """The run that feels all but a share of what is wanted, by axis, at rest and without a failure."""
    felt = run.reference_force.copy()
    for axis, share in enumerate(shares):
        felt[:, axis] *= 1.0 - share
    still = np.zeros_like(run.pose)
    return replace(run, felt_force=felt, pose=still, twist=still, acceleration=still, plant="ideal")


ONE, TWO = noisy("thesis", ("surge-pitch",), seed=2), noisy("thesis", ("surge-pitch", "sway-roll"), seed=1)
WANTED = float(np.sqrt(np.mean(ONE.reference_force[:, 0] ** 2)))


def test_the_ratio_is_that_of_the_errors() -> None:
    entry = against_best(missing(ONE, 0.5), Known(missing(ONE, 0.2)))
    assert entry["times"] == pytest.approx(2.5)
    assert entry["standing_still"] == pytest.approx(5.0)
    assert entry["by_dof"]["surge-pitch"]["error"] == pytest.approx(0.2 * WANTED)
    summary = summarise(missing(ONE, 0.5), Known(missing(ONE, 0.2)))
    size = f"{0.2 * WANTED:.4f} m/s²"
    assert best_in_words(summary) == (
        f"its error is 2.50 times the best that is possible on this drive ({size})"
    )
    reading = TIMES_THE_BEST.read(summary)
    assert reading is not None
    assert (reading.value, reading.share) == ("2.5 times", pytest.approx(1.5 / 4.0))


def test_what_the_lag_costs_is_within_reach() -> None:
    """A best that misses a tenth of what is wanted, nearly all of it through the lag alone."""
    best = missing(ONE, 0.1)
    near, far = (
        Known(best, through_lag={"surge-pitch": float(np.sqrt(0.1**2 - off**2)) * WANTED})
        for off in (0.0199, 0.0201)
    )
    assert against_best(missing(ONE, 0.5), near)["times"] is None
    assert against_best(missing(ONE, 0.5), far)["times"] == pytest.approx(5.0)
    words = best_in_words(summarise(missing(ONE, 0.5), near))
    assert words.startswith("a perfect answer is within reach of this platform on this drive (")
    assert TIMES_THE_BEST.read(summarise(missing(ONE, 0.5), near)) is None  # a scale would mislead


def test_where_nothing_is_wanted_nothing_is_divided() -> None:
    nothing = replace(ONE, reference_force=np.zeros_like(ONE.reference_force))
    assert against_best(missing(nothing, 0.0), Known(missing(nothing, 0.0)))["times"] is None


def test_degrees_of_freedom_count_together() -> None:
    """One may be better than in the best run, at the other's expense; together they cannot."""
    entry = against_best(missing(TWO, 0.1, 0.6), Known(missing(TWO, 0.2, 0.3)))
    x, y = np.sqrt(np.mean(TWO.reference_force**2, axis=0))[:2]
    assert entry["times"] == pytest.approx(np.hypot(0.1 * x, 0.6 * y) / np.hypot(0.2 * x, 0.3 * y))
    assert entry["by_dof"]["surge-pitch"]["times"] == pytest.approx(0.5)
    words = best_in_words(summarise(missing(TWO, 0.1, 0.6), Known(missing(TWO, 0.2, 0.3))))
    assert f"(surge-pitch 0.50 times {0.2 * x:.4f} m/s², sway-roll 2.00 times {0.3 * y:.4f} m/s²)" in words


def test_yaw_is_told_in_degrees() -> None:
    turning = noisy("davsi", ("yaw",), seed=4)
    best = replace(turning, plant="ideal", reference_rate=turning.felt_rate + np.array([0.0, 0.0, 0.01]))
    same = replace(best, reference_force=best.reference_force)
    assert "(0.573 deg/s)" in best_in_words(summarise(same, Known(best)))


def test_what_a_ratio_leaves_open_is_said() -> None:
    run, best = missing(ONE, 0.5), Known(missing(ONE, 0.2))
    assert best_in_words(summarise(replace(run, plant="hexapod"), best)).endswith(
        ", measured on the plant ideal"
    )
    beyond = replace(run, pose=run.pose + 9.0)
    assert best_in_words(summarise(beyond, best)).endswith(", which keeps the limits that this run passed")
    assert best_in_words(summarise(run)) == ""
    assert best_in_words(summarise(run, "add --optimum")).endswith("is not computed; add --optimum")


def test_the_best_may_decide_at_another_period() -> None:
    """An explicit law of 10 Hz is compared with an optimum of 100 Hz."""
    slow = replace(missing(ONE, 0.5), period=2 * ONE.period, command_time=ONE.command_time[::2])
    assert against_best(slow, Known(missing(ONE, 0.2)))["times"] == pytest.approx(2.5)


def test_the_best_of_another_drive_is_refused() -> None:
    other = replace(ONE, reference_force=2.0 * ONE.reference_force)
    with pytest.raises(InputError, match="the optimum is of another drive"):
        against_best(ONE, Known(other))
