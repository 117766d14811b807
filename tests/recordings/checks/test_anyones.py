"""Any vehicle's log in any axes: right, mirrored and told, or refused with a remedy that is right for it.

`benchmarks/log_physics.py` does the same thousands of times.
"""

import numpy as np
import pytest

from tests.recordings.checks.anyones import Case, judged, outcome, random_case, ways
from tests.recordings.checks.drives import NAMES, read, truth, written
from tests.recordings.vehicles import car


@pytest.mark.parametrize("part", range(4))
def test_no_log_is_read_wrongly_without_a_word_and_remedies_are_right(part: int) -> None:
    became = []
    for k in range(10):
        case = random_case(np.random.default_rng([part, k]))
        became.append(outcome(case))
        assert "wrong" not in became[-1], (case.what, became[-1])
    assert sum(one.startswith(("right", "mirrored")) for one in became) > 1  # refusing all would be easy


def test_the_judge_knows_a_wrong_reading() -> None:
    data, true = written(car()), truth(car(), ("ax", "ay"))
    log = read(data)
    assert judged(Case("a car", data, NAMES, true, ()), log) == "right"
    other = {key: values + 1.0 for key, values in true.items()}
    assert judged(Case("a car", data, NAMES, other, ()), log).startswith("wrong: ")


def test_the_remedies_of_a_sentence_are_found() -> None:
    sentence = (
        "of the same sign (…: map ay=-ay_mps2; or map yaw_rate=-r:deg/s and vx=v:km/h; or --axes iso if …)"
    )
    assert ways(sentence) == [
        ({"ay": "-ay_mps2"}, ""),
        ({"yaw_rate": "-r:deg/s", "vx": "v:km/h"}, ""),
        ({}, "iso"),
    ]
