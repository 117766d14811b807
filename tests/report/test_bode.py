import json
import math
from pathlib import Path

import numpy as np

from otolith.metrics.boundaries import parse_boundaries
from otolith.metrics.frequency_response import Response
from otolith.report import save_figure
from otolith.report.bode import omct_figure, omct_json, omct_page
from otolith.scenarios.cueing_tests import FREQUENCIES, TESTS

HEAD = "test,omega_radps,modulus_low,modulus_high,phase_low_deg,phase_high_deg\n"
BOUNDS = parse_boundaries(HEAD + "surge,0.05,0.8,,-30,30\nsurge,20,0.8,,-30,30\n", "b.csv")


def responses() -> list[Response]:
    """Surge through 1/(1 + s/2); the heave of a platform that stays still."""
    found = []
    for omega in FREQUENCIES:
        felt = 1.0 / (1.0 + 0.5j * omega)
        for test, c in ((TESTS[5], felt), (TESTS[9], 0.0)):
            phase = math.degrees(np.angle(c)) if c else math.nan
            found.append(
                Response(
                    test=test,
                    omega=omega,
                    modulus=abs(c),
                    modulus_uncertainty=0.01 * abs(c),
                    phase_deg=phase,
                    phase_uncertainty_deg=0.5 if c else math.nan,
                    distortion=0.02 if c else math.nan,
                )
            )
    return found


def test_the_figure_has_one_row_per_test_with_every_frequency(tmp_path: Path) -> None:
    figure = omct_figure(responses(), BOUNDS)
    assert [ax.get_title(loc="left") for ax in figure.axes[::2]] == ["6  surge", "10  heave"]
    modulus, phase = figure.axes[0], figure.axes[1]
    line = modulus.lines[0]
    np.testing.assert_allclose(
        np.asarray(line.get_ydata(), dtype=float), 1.0 / np.hypot(1.0, 0.5 * np.array(FREQUENCIES))
    )
    np.testing.assert_allclose(np.asarray(phase.lines[0].get_xdata(), dtype=float), FREQUENCIES)
    assert len(modulus.collections) == 2  # uncertainty bars and the boundary's region
    assert "nothing is felt" in [text.get_text() for text in figure.axes[2].texts]
    save_figure(figure, tmp_path / "bode.png")
    assert (tmp_path / "bode.png").stat().st_size > 10_000


def test_json_has_no_nan_and_says_what_is_within_the_boundaries() -> None:
    surge, heave = json.loads(json.dumps(omct_json(responses(), BOUNDS), allow_nan=False))
    assert (surge["test"], surge["name"], surge["unit"]) == (6, "surge", "")
    modulus = np.array(surge["modulus"])
    phase = np.array(surge["phase_deg"])
    assert surge["within_boundaries"] == list((modulus >= 0.8) & (phase >= -30.0))
    assert set(surge["within_boundaries"]) == {True, False}
    assert heave["within_boundaries"] == [None] * 12
    assert heave["phase_deg"] == [None] * 12


def test_the_page_shows_every_number_escaped_and_needs_nothing_else() -> None:
    page = omct_page("<washout>", {"plant": "a & b"}, responses(), BOUNDS)
    assert "&lt;washout&gt;" in page
    assert "a &amp; b" in page
    assert "<svg" in page
    assert 'src="http' not in page
    assert page.count("<tr>") == 2 * (1 + 12)
    assert "<strong>no</strong>" in page
    assert page == omct_page("<washout>", {"plant": "a & b"}, responses(), BOUNDS)
