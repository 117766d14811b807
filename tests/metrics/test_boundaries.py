import math

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.metrics.boundaries import Boundary, parse_boundaries
from otolith.metrics.frequency_response import Response
from otolith.scenarios.cueing_tests import TESTS

HEAD = "test,omega_radps,modulus_low,modulus_high,phase_low_deg,phase_high_deg\n"


def response(omega: float, modulus: float, phase_deg: float) -> Response:
    return Response(
        test=TESTS[5],
        omega=omega,
        modulus=modulus,
        modulus_uncertainty=0.0,
        phase_deg=phase_deg,
        phase_uncertainty_deg=0.0,
        distortion=0.0,
    )


def test_a_response_is_judged_between_the_frequencies_of_the_file() -> None:
    bounds = parse_boundaries(HEAD + "surge,0.1,0.2,1.0,-20,20\n6,10,0.6,1.0,-60,20\n", "b.csv")
    assert set(bounds) == {"surge"}
    surge = bounds["surge"]
    # at 1 rad/s, midway on the logarithm: modulus from 0.4, phase from −40°
    assert surge.holds(response(1.0, 0.41, -39.0)) is True
    assert surge.holds(response(1.0, 0.39, -39.0)) is False
    assert surge.holds(response(1.0, 0.41, -41.0)) is False
    assert surge.holds(response(10.0, 0.61, -59.0)) is True
    assert surge.holds(response(15.0, 0.61, 0.0)) is None
    assert surge.holds(response(1.0, 0.41, math.nan)) is True


def test_an_empty_cell_bounds_nothing() -> None:
    surge = parse_boundaries(HEAD + "6,0.1,0.5,,,\n6,1,,0.9,,10\n6,10,0.7,0.9,,10\n", "b.csv")["surge"]
    assert surge.holds(response(0.3, 0.0, -170.0)) is True  # one neighbour has no lower bound: none between
    assert surge.holds(response(3.0, 0.95, 0.0)) is False
    assert surge.holds(response(3.0, 0.1, 11.0)) is False
    assert np.isinf(surge.phase_low_deg).all()


def test_one_frequency_bounds_that_frequency_alone() -> None:
    surge = parse_boundaries(HEAD + "6,1.0,0.5,0.9,-10,10\n", "b.csv")["surge"]
    assert isinstance(surge, Boundary)
    assert surge.holds(response(1.0, 0.6, 0.0)) is True
    assert surge.holds(response(1.0, 0.4, 0.0)) is False
    assert surge.holds(response(1.1, 0.6, 0.0)) is None


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("test,omega_radps\n6,1\n", "column modulus_low of b.csv is missing"),
        ("", "column test of b.csv is missing"),
        (HEAD + "serge,1,,,,\n", "the test in line 2 of b.csv is 'serge'.*did you mean surge"),
        (HEAD + "6,1,,,,\n6,2,x,,,\n", "modulus_low in line 3 of b.csv is 'x', must be a number"),
        (HEAD + "6,0,,,,\n", "omega_radps in line 2 of b.csv is 0.0, must be greater than 0"),
        (HEAD + "6,1,nan,,,\n", "line 2 of b.csv"),
        (HEAD + "6,2,,,,\n6,1,,,,\n", "omega_radps of surge in b.csv is .* must be increasing"),
    ],
)
def test_a_wrong_file_is_refused_in_one_sentence(text: str, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        parse_boundaries(text, "b.csv")
