"""The front and presets on it, against brute force."""

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.studies.jobs import Done
from otolith.studies.results import State, Trial, allowed, best_of, front, preset_of, values
from tests.studies.synthetic import study

OF = study()


def trial(number: int, tracking: float, travel: float, violations: float = 0.0) -> Trial:
    rest = {"travel": travel, "violations": violations, "noticed": 0.0}
    one = {k: Done({"tracking": tracking + k, **rest}) for k in (0, 1)}
    return Trial(number=number, settings={}, training=one, state=State.DONE)


def test_the_front_is_what_brute_force_finds() -> None:
    rng = np.random.default_rng(5)
    numbers = rng.integers(0, 12, size=(200, 2)) / 10.0
    trials = [trial(k, float(x), float(y), float(k % 7 == 0)) for k, (x, y) in enumerate(numbers)]
    sound = [one for one in trials if allowed(OF, one)]
    assert len(sound) == 200 - len(range(0, 200, 7))

    def beaten(one: Trial) -> bool:
        a = np.array(values(OF, one.training))
        others = [np.array(values(OF, other.training)) for other in sound]
        return any((b <= a).all() and (b < a).any() for b in others)

    expected = {values(OF, one.training) for one in sound if not beaten(one)}
    found = front(OF, trials)
    assert {values(OF, one.training) for one in found} == expected
    assert len(found) == len(expected)
    assert [values(OF, one.training)[0] for one in found] == sorted(v[0] for v in expected)


def test_presets_choose_on_the_front() -> None:
    trials = [trial(0, 1.0, 0.1), trial(1, 0.5, 0.2), trial(2, 0.4, 0.9), trial(3, 0.1, 0.1, violations=1.0)]
    assert values(OF, trials[0].training) == (1.5, 0.1)
    assert preset_of(OF, trials, "calm").number == 0
    assert preset_of(OF, trials, "lively").number == 2
    assert best_of(OF, trials).number == 1
    with pytest.raises(InputError, match="preset is 'calmm', must be one of calm, lively"):
        preset_of(OF, trials, "calmm")
    with pytest.raises(InputError, match="trials within all constraints is 0 of 1 done"):
        best_of(OF, trials[3:])
