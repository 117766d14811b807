"""What is fitted knows more than nothing of an unseen drive; without its library it says so."""

import importlib

import numpy as np
import pytest

from otolith.core.errors import MissingExtra
from otolith.hints.build import build
from otolith.hints.fit import QUICK, is_symmetric
from otolith.hints.manoeuvres import along
from otolith.hints.recording import Recording, record
from otolith.mpc.hint.stored import Kind
from tests.hints.tiny import PAIRS, SEEN, SETTINGS, THESIS, tiny_hint, unseen_recording


def wrong_rows(kind: Kind, recording: Recording) -> float:
    """Mean number of rows that a hint gets wrong."""
    hint = tiny_hint().at_work(kind, THESIS, PAIRS, SETTINGS)
    wrong = []
    for x, wanted, plan, rows in zip(
        recording.x, recording.wanted, recording.plan, recording.sets, strict=True
    ):
        sets = hint.sets(x, wanted, plan)
        assert sets is not None
        wrong.append(np.count_nonzero(sets[0] != rows))
    return float(np.mean(wrong))


@pytest.mark.parametrize("kind", Kind)
def test_hints_know_more_than_nothing_about_an_unseen_drive(kind: Kind) -> None:
    recording = unseen_recording()
    assert wrong_rows(kind, recording) < 0.6 * np.count_nonzero(recording.sets, axis=(1, 2)).mean()


def test_the_table_knows_by_heart_what_it_has_seen() -> None:
    recording = record(THESIS, PAIRS, SETTINGS, along(SEEN, PAIRS), plans=True)
    assert wrong_rows(Kind.TABLE, recording) < wrong_rows(Kind.TABLE, unseen_recording())


def test_the_account_of_the_training_adds_up() -> None:
    training = tiny_hint().training
    assert training["steps"] == 1000
    assert training["unsolved"] == 0
    assert set(training["seconds"]) == {"simulate", "learn", "table", "law"}
    assert training["entries"] == len(tiny_hint().table.parameters) <= 100


def test_a_reach_that_differs_between_the_sides_is_not_symmetric() -> None:
    assert is_symmetric(THESIS, PAIRS)
    assert THESIS.surge is not None
    lopsided = THESIS.model_copy(
        update={"surge": THESIS.surge.model_copy(update={"position_m": (-0.4, 0.5)})}
    )
    assert not is_symmetric(lopsided, PAIRS)


def test_without_scikit_learn_building_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}", name="sklearn")

    monkeypatch.setattr(importlib, "import_module", absent)
    with pytest.raises(MissingExtra, match=r"needs scikit-learn, .* pip install 'otolith\[hint\]'"):
        build(THESIS, PAIRS, SETTINGS, manoeuvres=SEEN, effort=QUICK)
