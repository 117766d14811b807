"""The comparison: identical problems, one answer, and figures that follow from the tallies."""

import numpy as np
import pytest

from otolith.core.arrays import Ints, Mat, Vec
from otolith.cueing.hints.training.compare import COLD, PREVIOUS, Tally, account, compare
from otolith.cueing.hints.training.recording import Recording
from otolith.cueing.mpc.problem import Problem
from tests.cueing.hints.training.tiny import PAIRS, SETTINGS, THESIS, unseen_recording


class Oracle:
    """Knows the answers: no working set is better."""

    def __init__(self, recording: Recording) -> None:
        self._answers = {x.tobytes(): rows for x, rows in zip(recording.x, recording.sets, strict=True)}

    def reset(self) -> None:
        pass

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints:
        return self._answers[x.tobytes()][None].astype(np.int64)


class Wrong(Oracle):
    """Says the contrary of what is right."""

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints:
        return -super().sets(x, wanted, plan)


@pytest.fixture(scope="module")
def tallies() -> dict[str, Tally]:
    recording = unseen_recording()
    hints = {"oracle": Oracle(recording), "wrong": Wrong(recording)}
    return compare(Problem(THESIS, PAIRS, SETTINGS), recording, hints)


def test_an_oracle_saves_nearly_everything_and_a_wrong_hint_costs_no_change(
    tallies: dict[str, Tally],
) -> None:
    found = account(tallies, unseen_recording())
    assert found["oracle"]["changes"]["mean"] < 0.1 * found[PREVIOUS]["changes"]["mean"]
    assert found["oracle"]["changes_saved_percent"]["mean"] > 90.0
    assert found["wrong"]["changes"]["mean"] <= found[PREVIOUS]["changes"]["mean"]
    assert found[COLD]["changes"]["mean"] > 5.0 * found[PREVIOUS]["changes"]["mean"]


def test_the_answer_is_the_same_from_every_start(tallies: dict[str, Tally]) -> None:
    for one in account(tallies, unseen_recording()).values():
        assert one["first_input_gap"] < 1e-6


def test_figures_follow_from_the_tallies(tallies: dict[str, Tally]) -> None:
    oracle, found = tallies["oracle"], account(tallies, unseen_recording())["oracle"]
    assert found["hit_rate"] == np.mean(oracle.changes == 0)
    assert found["changes"]["max"] == oracle.changes.max()
    assert found["step_us"]["worst_percent_mean"] == pytest.approx(1e6 * np.mean(np.sort(oracle.step)[-3:]))
    assert found["step_us"]["p99"] <= found["step_us"]["max"]
    assert np.isfinite(tallies[COLD].changes).sum() == 30  # one in ten
