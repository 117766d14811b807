import contextlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from otolith.core.errors import InputError
from otolith.scenarios import FAMILIES, SCENARIOS, TABLE_5_1, scenario, signals
from otolith.scenarios.catalog import family_parameters

T = np.linspace(0.0, 60.0, 6001)


def refusal(name: str) -> str:
    with pytest.raises(InputError) as caught:
        scenario(name)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("axis", signals.AXES)
def test_every_named_scenario_rests_for_one_second_then_moves_along_one_axis(name: str, axis: str) -> None:
    made = scenario(name, axis=axis)
    force = made.specific_force(T)
    rate = made.angular_rate(T)
    moved = rate if axis == "yaw" else force
    index = signals.FORCES.get(axis, 2)
    assert made.name == name
    assert made.origin == SCENARIOS[name].source
    assert not moved[T < 1.0].any()
    assert moved[100 : int(100 * made.duration), index].any()
    assert not np.delete(moved, index, axis=1).any()
    assert not (force if axis == "yaw" else rate).any()


@pytest.mark.parametrize(
    ("name", "duration", "time", "value"),
    [
        ("sine-0.5", 10, 3.5, 0.5),
        ("sine-1", 10, 3.5, 1.0),
        ("sine-2", 10, 8.5, -2.0),
        ("combined", 10, 2.0, 0.3 * sum(a * np.sin(2 * np.pi * f) for a, f in signals.TABLE_5_1_WAVES)),
        ("step-0.5", 10, 4.5, 0.5),
        ("step-1", 10, 4.5, 1.0),
        ("step-2", 10, 4.5, 2.0),
        ("step-sine-0.5", 20, 12.5, 0.5),
        ("step-sine-1", 20, 17.5, -1.0),
        ("step-0.1", 10, 1.0, 0.1),
        ("sine-1-0.01hz", 60, 26.0, 1.0),
        ("bend", 26, 2.5, 1.25),
        ("bend", 26, 12.9, 2.5),
        ("stop", 15, 4.9, -8.5),
        ("stop", 15, 5.05, -4.25),
        ("combined-emulator", 20, 4.9, 0.0),  # the larger rest of section 6.2
        (
            "combined-fast",
            20,
            1.25,
            0.3 * (0.5 + 0.6 * np.sin(np.pi / 20) + 0.1 * np.sin(np.pi / 10) + 0.8 * np.sin(0.075 * np.pi)),
        ),
    ],
)
def test_named_scenarios_have_the_numbers_that_they_are_described_by(
    name: str, duration: float, time: float, value: float
) -> None:
    made = scenario(name)
    assert made.duration == duration
    assert made.specific_force(np.array([time]))[0, 0] == pytest.approx(value)


@pytest.mark.parametrize("name", ["step-1", "step-sine-1", "step:amplitude=1"])
def test_steps_end_at_five_seconds_and_literally_at_four(name: str) -> None:
    t = np.array([3.99, 4.0, 4.99, 5.0])
    assert scenario(name).specific_force(t)[:, 0].tolist() == [1.0, 1.0, 1.0, 0.0]
    literal = scenario(name, literal=True)
    assert literal.specific_force(t)[:, 0].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert literal.origin.endswith("step until 4 s as printed")


def test_literal_leaves_sines_alone_and_an_explicit_end_too() -> None:
    for name in ("sine-1", "step:end=6", "bend"):
        expected = scenario(name).specific_force(T)
        assert_allclose(scenario(name, literal=True).specific_force(T), expected)


@given(amplitude=st.floats(-30, 30), frequency=st.floats(0.001, 50), duration=st.floats(2, 3600))
def test_a_text_says_the_same_as_the_call(amplitude: float, frequency: float, duration: float) -> None:
    made = scenario(f"sine:amplitude={amplitude!r}, frequency={frequency!r},duration={duration!r}")
    expected = signals.sine(amplitude, frequency, duration=duration)
    assert made.duration == expected.duration
    assert np.array_equal(made.specific_force(T), expected.specific_force(T))


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_has_defaults_that_make_a_scenario(family: str) -> None:
    text = ",".join(f"{name}={value}" for name, value in family_parameters(family).items())
    assert_allclose(scenario(f"{family}:{text}").specific_force(T), scenario(f"{family}:").specific_force(T))


def test_a_texts_own_axis_goes_before_the_option() -> None:
    assert scenario("sine:axis=lateral", axis="longitudinal").specific_force(T)[:, 1].any()


def test_a_family_reads_whole_numbers() -> None:
    expected = signals.multisine(7, count=3).specific_force(T)
    assert_allclose(scenario("multisine:seed=7,count=3").specific_force(T), expected)


def test_an_unknown_name_is_refused_with_what_there_is() -> None:
    assert refusal("sine-3") == (
        f"scenario is 'sine-3', must be one of {', '.join(SCENARIOS)}, "
        "or as sine:amplitude=0.7,frequency=0.2 (did you mean sine-2?)"
    )
    assert refusal("sin:amplitude=1") == (
        "scenario family is 'sin', must be one of sine, step, step-sine, combined, multisine, chirp "
        "(did you mean sine?)"
    )


def test_a_family_alone_is_its_defaults() -> None:
    assert_allclose(scenario("chirp").specific_force(T), signals.chirp().specific_force(T))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "sine:amplitud=1",
            "parameter of sine is 'amplitud', must be one of amplitude, frequency, duration, start, axis "
            "(did you mean amplitude?)",
        ),
        ("sine:amplitude", "parameter of sine is 'amplitude', must be given once, as amplitude=1.0"),
        (
            "sine:amplitude=1,amplitude=2",
            "parameter of sine is 'amplitude=2', must be given once, as amplitude=1.0",
        ),
        ("sine:amplitude=big", "amplitude is 'big', must be a number"),
        ("sine:amplitude=nan", "amplitude is nan m/s², must be between -30 and 30 m/s²"),
        ("multisine:seed=1.5", "seed is '1.5', must be a whole number"),
        ("sine:axis=up", "axis is 'up', must be one of longitudinal, lateral, vertical, yaw"),
    ],
)
def test_a_wrong_parameter_is_named(text: str, sentence: str) -> None:
    assert refusal(text) == sentence


@given(st.text(max_size=40))
def test_any_text_gives_a_scenario_or_is_refused(text: str) -> None:
    for name in (text, f"sine:{text}", f"multisine:seed={text}"):
        with contextlib.suppress(InputError):
            scenario(name)


def test_table_5_1_has_three_sines_their_sum_two_steps_and_two_of_both() -> None:
    assert " ".join(TABLE_5_1) == "sine-0.5 sine-1 sine-2 combined step-1 step-2 step-sine-0.5 step-sine-1"
