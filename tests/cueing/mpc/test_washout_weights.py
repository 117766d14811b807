import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.cueing.mpc.washout_weights import PRESETS, constant, preset


def test_the_printed_polynomial_at_its_scale_is_the_sum_of_its_coefficients() -> None:
    """Eq. 4.12 at |s| = w₅: 0.01 + 20 + 20 + 20; at |ω| = 3 deg/s: 0.0001 + 3 · 0.7."""
    tilt_rate, position = PRESETS["printed"]
    x = np.array([np.deg2rad(-3.0), 0.0, 0.0, 0.5, 0.0, 0.0])
    assert tilt_rate.at(x) == pytest.approx(2.1001)
    assert position.at(x) == pytest.approx(60.01)
    assert (tilt_rate.on, position.on) == ("tilt_rate", "position")


def test_half_way_out_the_weight_is_still_small() -> None:
    """Figure 4.2: from neutral to 0.25 m the increase is low. 0.01 + 20 (½ + ¼ + 1/16)."""
    _, position = PRESETS["printed"]
    assert position.at(np.array([0, 0, 0, -0.25, 0, 0])) == pytest.approx(16.26)


def test_constant_weights_do_not_depend_on_the_state() -> None:
    (weight,) = constant({"position": 0.9})
    assert weight.at(np.zeros(6)) == weight.at(np.full(6, 7.0)) == 0.9


@pytest.mark.parametrize(
    ("weights", "sentence"),
    [
        ({"sway": 1.0}, "weight is 'sway', must be on one of tilt_rate, tilt, velocity, position"),
        ({"position": -1.0}, "weight position is -1, must be 0, or from 1e-12 to 1e[+]12"),
        ({"position": float("nan")}, "weight position is nan"),
    ],
)
def test_wrong_weights_are_refused(weights: dict[str, float], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        constant(weights)


def test_an_unknown_preset_is_refused() -> None:
    with pytest.raises(InputError, match="washout is 'best', must be one of printed, thesis-fit, none"):
        preset("best")
