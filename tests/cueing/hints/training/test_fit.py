"""What is fitted knows more than nothing of an unseen drive; without its library it says so."""

import importlib
import itertools
from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import MissingExtra
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.hints.stored import Kind
from otolith.cueing.hints.training.build import build
from otolith.cueing.hints.training.fit import QUICK, _pair_of, fit_network, is_symmetric
from otolith.cueing.hints.training.manoeuvres import Manoeuvre, along
from otolith.cueing.hints.training.recording import Recording, record
from otolith.cueing.mpc.problem import Problem
from otolith.scenarios.waves import Pulse
from tests.cueing.hints.training.tiny import PAIRS, SEEN, SETTINGS, THESIS, tiny_hint, unseen_recording


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


def test_a_motion_that_one_pair_mirrors_has_the_rows_of_that_pair_mirrored() -> None:
    pairs = (SURGE_PITCH, SWAY_ROLL)
    steps, other = (Manoeuvre(name, 1.2, Pulse(a, 0.1, 0.9)) for name, a in (("one", 1.4), ("other", 1.1)))
    made = []
    for a in (1.1, -1.1):
        mirrored = replace(other, wave=Pulse(a, 0.1, 0.9))
        drive = along([steps], PAIRS)[0].combined_with(along([mirrored], (SWAY_ROLL,))[0])
        made.append(record(THESIS, pairs, SETTINGS, [drive]))
    plain, turned = (one.sets.reshape(len(one), -1) for one in made)
    pair = _pair_of(Problem(THESIS, pairs, SETTINGS).structure, plain.shape[1])
    assert set(pair) == {0, 1, 2}
    assert (plain[:, pair == 1] != 0).any()
    np.testing.assert_array_equal(turned, plain * np.where(pair == 1, -1, 1))


def test_each_pair_has_a_network_of_its_own_rows() -> None:
    pairs = (SURGE_PITCH, SWAY_ROLL)
    recording = record(THESIS, pairs, SETTINGS, along(SEEN, pairs, seed=1))
    networks = [
        fit_network(THESIS, pairs, SETTINGS, p, recording=recording, effort=QUICK, progress=lambda _: None)[0]
        for p in range(2)
    ]
    pair = _pair_of(Problem(THESIS, pairs, SETTINGS).structure, recording.sets[0].size)
    for p, network in enumerate(networks):
        assert len(network.outputs) > 0
        assert set(pair[abs(network.outputs) - 1]) == {p}


def test_only_what_changes_the_named_rows_counts_as_a_change() -> None:
    recording = unseen_recording()
    sets = recording.sets.reshape(len(recording), -1)
    rows = np.zeros(sets.shape[1], dtype=np.bool_)
    assert recording.changed(rows).sum() == 1  # the first decision
    rows[:] = True
    expected = [True, *(not np.array_equal(a, b) for a, b in itertools.pairwise(sets))]
    np.testing.assert_array_equal(recording.changed(rows), expected)
    rows[::2] = False
    assert recording.changed(rows).sum() < np.sum(expected)


def test_without_scikit_learn_building_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}", name="sklearn")

    monkeypatch.setattr(importlib, "import_module", absent)
    with pytest.raises(MissingExtra, match=r"needs scikit-learn, .* pip install 'otolith\[hint\]'"):
        build(THESIS, PAIRS, SETTINGS, manoeuvres=SEEN, effort=QUICK)
