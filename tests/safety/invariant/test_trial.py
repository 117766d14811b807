"""Adversaries get nowhere in a proved set, and out of one that is not."""

import numpy as np

from otolith.safety.invariant.axis import AxisSet
from otolith.safety.invariant.certificate import AxisCertificate
from otolith.safety.invariant.trial import drive
from tests.safety.invariant.test_certificate import certificate
from tests.safety.invariant.test_contraction import HEAVE, SHARED, SURGE


def test_adversaries_get_nowhere_in_a_proved_set_nor_beyond_a_limit_between_its_nodes() -> None:
    for axis in (SURGE, HEAVE):
        found = drive([(axis, certificate(axis))], states=600, steps=80, rng=np.random.default_rng(1))
        assert found.passed
        assert 1.0 - 1e-9 < found.outermost < 1.0 + 1e-9  # they do reach the facets
        assert found.between < 1.0 + 1e-9


def test_adversaries_find_the_states_of_too_short_a_wedge_that_have_no_command() -> None:
    """Here with three quarters of the time that the commands need."""
    short = AxisCertificate.of(AxisSet(HEAVE, 0.04))
    found = drive([(HEAVE, short)], states=600, steps=80, rng=np.random.default_rng(1))
    assert found.infeasible > 100
    assert found.violations > 100


def test_two_axes_keep_within_their_circle_together_only_with_cells_for_it() -> None:
    """With the shorter wedge of one axis alone, the other cannot always make room."""
    of, rng = certificate(SHARED), np.random.default_rng(1)
    found = drive([(SHARED, of), (SHARED, of)], circle=0.5, states=600, steps=150, rng=rng)
    assert found.passed
    short = AxisCertificate.of(AxisSet(SHARED, 0.4))
    found = drive([(SHARED, short), (SHARED, short)], circle=0.5, states=600, steps=150, rng=rng)
    assert found.infeasible > 0


def test_equal_seeds_give_equal_trials() -> None:
    of = certificate(HEAVE)
    first, second, other = (
        drive([(HEAVE, of)], states=100, steps=20, rng=np.random.default_rng(seed)) for seed in (5, 5, 6)
    )
    assert first == second != other
