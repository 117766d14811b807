"""Laws that several tests look at, built once."""

import pytest

from otolith.mpqp import Law, enumerate_regions
from tests.mpqp.models import saturated_line, surge_pitch


@pytest.fixture(scope="session")
def blocked() -> Law:
    """Move-blocked N = 5 law of the thesis's explicit 2 DOF model."""
    return enumerate_regions(surge_pitch(5, blocks=2))


@pytest.fixture(scope="session")
def line() -> Law:
    """The three regions of a saturated line."""
    return enumerate_regions(saturated_line())
