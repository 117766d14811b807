"""A hint belongs to one model and comes back from its arrays as it was."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from otolith.core.errors import CorruptFile
from otolith.core.frames import SWAY_ROLL, Dof
from otolith.cueing.hints.stored import Kind, StaleHint, StoredHint, digest, model_of
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.washout_weights import constant
from otolith.perception import Vestibular
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine
from tests.cueing.hints.training.tiny import PAIRS, SETTINGS, THESIS, tiny_hint


@pytest.mark.parametrize(
    ("platform", "pairs", "settings", "differs"),
    [
        ("davsi", PAIRS, SETTINGS, "limits"),
        ("thesis", (SWAY_ROLL,), SETTINGS, "axes, limits"),
        ("thesis", PAIRS, replace(SETTINGS, washout=constant({"position": 0.9})), "washout"),
        ("thesis", PAIRS, MpcSettings(horizon=51), "horizon"),
        ("thesis", PAIRS, replace(SETTINGS, blocks=(10, 40)), "blocks"),
        ("thesis", PAIRS, replace(SETTINGS, soft={"tilt_rate": 100.0}), "soft"),
        ("thesis", PAIRS, replace(SETTINGS, linear=True), "linear"),
        ("thesis", PAIRS, replace(SETTINGS, objective=Objective(senses=Vestibular())), "what is sensed"),
    ],
)
def test_a_hint_for_another_model_is_refused_and_the_sentence_says_what_differs(
    platform: str, pairs: tuple[Dof, ...], settings: MpcSettings, differs: str
) -> None:
    with pytest.raises(StaleHint, match=f"differ in .*{differs}"):
        tiny_hint().check(load(platform), pairs, settings)
    with pytest.raises(StaleHint):
        tiny_hint().at_work(Kind.LEARNED, load(platform), pairs, settings)


def test_what_does_not_change_the_problem_does_not_make_a_hint_stale() -> None:
    tiny_hint().check(THESIS, PAIRS, replace(SETTINGS, engine=CondensedEngine, iterations=3, tolerance=1e-7))


def test_arrays_there_and_back_are_the_same_hint() -> None:
    hint = tiny_hint()
    again = StoredHint.from_arrays(hint.to_arrays(), hint.model, hint.training)
    assert digest(again.model) == digest(model_of(THESIS, PAIRS, SETTINGS))
    x, wanted, plan = np.full(6, 0.02), np.array([1.2]), np.zeros((50, 2))
    for kind in Kind:
        sets = [one.at_work(kind, THESIS, PAIRS, SETTINGS).sets(x, wanted, plan) for one in (hint, again)]
        assert_array_equal(sets[0], sets[1])


def test_damaged_arrays_are_refused() -> None:
    hint = tiny_hint()
    arrays = hint.to_arrays()
    missing = {name: array for name, array in arrays.items() if name != "law.levels"}
    bad = {
        "lacks the array law.levels": missing,
        "lacks the array sizes": {name: array for name, array in arrays.items() if name[:7] != "network"},
        "does not exist": {**arrays, "table.which": arrays["table.which"] - 1000},
        "names rows that": {**arrays, "network-0.outputs": arrays["network-0.outputs"] * 1000},
        "lengths do not fit": {**arrays, "law.lengths": arrays["law.lengths"] + 1},
    }
    for sentence, damaged in bad.items():
        with pytest.raises(CorruptFile, match=sentence):
            StoredHint.from_arrays(damaged, hint.model, hint.training)
