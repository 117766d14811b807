from importlib.resources import files

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.core.errors import InputError
from otolith.cueing.washout.scaling import Cubic
from otolith.cueing.washout.tuning import Adaptive, Classical, load_tuning, parse_tuning, tunings

POSITIVE = st.floats(0.1, 10.0)


@given(slope=POSITIVE, largest=POSITIVE, extra=st.floats(1.0, 3.0))
@settings(derandomize=True)
def test_the_cubic_meets_its_conditions_and_grows(slope: float, largest: float, extra: float) -> None:
    limit = extra * slope * largest / 3.0
    scale = Cubic(slope=slope, largest=largest, limit=limit)
    h = 1e-6 * largest
    ends = np.array([h, largest - h, largest, 2.0 * largest])
    small, before, at, beyond = scale(ends)
    assert small / h == pytest.approx(slope, rel=1e-4)
    assert at == pytest.approx(limit)
    assert beyond == at
    assert abs(at - before) / h < 1e-4 * (slope + limit / largest)  # level where it saturates
    x = np.linspace(-1.5 * largest, 1.5 * largest, 400)
    np.testing.assert_allclose(scale(-x), -scale(x))
    assert (np.diff(scale(x)[np.abs(x) < largest]) > -1e-12 * limit).all() or extra > 1.0 + slope


@pytest.mark.parametrize("name", tunings())
def test_every_shipped_tuning_loads_under_its_own_name(name: str) -> None:
    tuning = load_tuning(name)
    assert tuning.name == name
    assert tuning.description


def _changed(change: str) -> str:
    """The shipped tuning of the DAVSi with "old->new" carried out."""
    text = (files("otolith.cueing.washout") / "tunings" / "davsi.toml").read_text(encoding="utf-8")
    old, new = change.split("->")
    assert old in text
    return text.replace(old, new)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            "limit_mps2 = 3.4->limit_mps2 = 3.0",
            "force.limit_mps2 in rig.toml is 3.0, must be at least",
        ),
        (
            "limit_degps = 12.0->limit_degps = 1.0",
            "rate.limit_degps in rig.toml is 1.0, must be at least",
        ),
        ("largest_mps2 = 10.0->largest_mps2 = -1", "must be greater than 0 m/s2"),
        ("sensed_rate->senced_rate", "optimal.senced_rate in rig.toml is unknown, must be one of"),
        ('name = "davsi"->name = davsi', "line 4 of rig.toml"),
    ],
)
def test_a_wrong_tuning_is_one_sentence(change: str, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_tuning(_changed(change), "rig.toml")
    assert sentence in str(refused.value)


def test_an_unknown_tuning_says_which_there_are() -> None:
    with pytest.raises(InputError, match="one of davsi, thesis, or a file"):
        load_tuning("rig")


def test_a_file_may_hold_one_washout_only_and_makes_no_other() -> None:
    text = _changed("[adaptive]->[later]").split("[later]")[0]
    tuning = parse_tuning(text, "rig.toml")
    assert tuning.of(Classical).surge.damping == 1.0
    with pytest.raises(InputError, match=r"\[adaptive\] of tuning davsi is missing, must be given for"):
        tuning.of(Adaptive)
    with pytest.raises(InputError, match=r"classical in rig.toml is missing, must be given, or \[adaptive\]"):
        parse_tuning(text.split("[classical]")[0], "rig.toml")
