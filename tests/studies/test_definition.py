"""Study files: what is wrong with one is a sentence that names the field; the shipped ones are sound."""

import pytest

from otolith.core.errors import InputError
from otolith.studies.definition import load_study, parse_study, studies
from tests.studies.synthetic import TEXT


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            "low = 0.01, high = 1.0",
            "low = 1.0, high = 1.0",
            r"position.high in a.toml is 1.0, must be finite and m",
        ),
        ("low = 0.01, high = 1.0", "low = 0.0, high = 1.0", "greater than 0 on a logarithmic scale"),
        ("low = 0.01, high = 1.0", "high = 1.0", "position.low in a.toml is missing, must be given"),
        ("high = 50, step = 10", "high = 55, step = 10", "low plus a multiple of step, 10"),
        (', of = ["stopping", "none"]', "", "at least two choices"),
        (
            '"weight.velocity" = { low',
            '"weight.speeed" = { low',
            "one value for each of weight.position, weight.sp",
        ),
        ("horizon = 30", "horizon = 70", "start.0.horizon in a.toml is 70, must be within the parameter"),
        ('measure = "travel"', 'measure = "travle"', "travel, .*did you mean travel"),
        ('measure = "travel"', 'measure = "tracking"', "each measure once"),
        ("batch = 4", "batch = 1", "budget.batch in a.toml is 1"),
        (
            '"implicit"',
            '"classical"',
            "parameter is 'weight.position', must be left out: classical does not read",
        ),
        ('"implicit"', '"implicti"', "did you mean implicit"),
        (
            '"sine-1", "step-1"',
            "{ scale = 2.0 }",
            "training.0.scenario in a.toml is missing, must be given, or log",
        ),
        ("travel = 1.0", "sickness = 1.0", "one of tracking, travel"),
        ("trials = 14", "trails = 14", "did you mean trials"),
        ("trials = 14", "trials = 0", "budget.trials in a.toml is 0, must be at least 1"),
        ("trials = 14", "trials = 1.5", "budget.trials in a.toml is 1.5, must be a whole number"),
        (
            "low = 0.01, high = 1.0",
            'low = "a", high = 1.0',
            "position.low in a.toml is 'a', must be a number",
        ),
        (
            "low = 10, high = 50",
            "low = 0.5, high = 50.5",
            "horizon.low in a.toml is 0.5, must be a whole number",
        ),
        (', of = ["stopping", "none"]', ', of = ["none", "none"]', "at least two choices, each once"),
        (
            ', of = ["stop',
            ', low = 1.0, of = ["stop',
            "low in a.toml is 1.0, must be left out with a scale that",
        ),
        (
            "low = 0.01, high",
            "step = 2, low = 0.01, high",
            "step in a.toml is 2, must be left out with a scale",
        ),
        (
            "travel = 1.0",
            "travel = nan",
            "presets.calm.travel in a.toml is nan, must be finite and at least 0",
        ),
        ("travel = 1.0", "", "presets.calm in a.toml is a table of none, must be of a weight greater than 0"),
        (
            '"sine-1", "step-1"',
            '{ scenario = "sine-1", lowpass_hz = 3.0 }',
            "training.0.lowpass_hz in a.toml is 3.0, must be left out, or given with a log",
        ),
        ('"sine-1", "step-1"', "3", "training.0 in a.toml is 3, must be a table of fields"),
        (
            "[[start]]",
            "[fixed]\nperiod = true\n[[start]]",
            "fixed.period in a.toml is true, must be a number or a",
        ),
    ],
)
def test_what_is_wrong_is_said(old: str, new: str, words: str) -> None:
    assert old in TEXT
    with pytest.raises(InputError, match=words):
        parse_study(TEXT.replace(old, new, 1), "a.toml")


@pytest.mark.parametrize("name", studies())
def test_a_shipped_study_is_sound_and_judges_what_it_did_not_train_on(name: str) -> None:
    study = load_study(name)
    assert study.name == name
    assert study.judging
    assert not {one.scenario for one in study.training} & {one.scenario for one in study.judging}


def test_an_unknown_study_is_refused() -> None:
    with pytest.raises(InputError, match="did you mean classical"):
        load_study("clasical")
