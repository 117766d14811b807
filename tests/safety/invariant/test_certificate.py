"""A certificate is refused for every mutilation."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.core.errors import CorruptFile
from otolith.safety.invariant.axis import Axis, AxisSet
from otolith.safety.invariant.certificate import AxisCertificate, check
from otolith.safety.invariant.contraction import Cell, certified_ahead
from tests.safety.invariant.test_contraction import FAST, HEAVE, SHARED, SURGE

AXES = {"surge": SURGE, "shared": SHARED, "heave": HEAVE, "fast": FAST}


def certificate(axis: Axis) -> AxisCertificate:
    ahead = certified_ahead((axis,), 0.01)
    assert ahead is not None
    return AxisCertificate.of(AxisSet(axis, ahead))


def with_cell(of: AxisCertificate, number: int, cell: Cell) -> AxisCertificate:
    return replace(of, cells=(*of.cells[:number], cell, *of.cells[number + 1 :]))


@pytest.mark.parametrize("name", AXES)
def test_a_certificate_passes_as_built_and_after_storing(name: str) -> None:
    of = certificate(AXES[name])
    for one in (of, AxisCertificate.from_arrays(of.to_arrays())):
        found = check(one, AXES[name])
        assert found.passed
        assert 0.9 < found.shrink < 1.0


@pytest.mark.parametrize("name", AXES)
def test_every_vertex_counts(name: str) -> None:
    """Whichever is left out is missed."""
    axis, of = AXES[name], certificate(AXES[name])
    for number, cell in enumerate(of.cells):
        for i in range(len(cell.vertices)):
            fewer = Cell(cell.side, np.delete(cell.vertices, i, axis=0), np.delete(cell.commands, i))
            found = check(with_cell(of, number, fewer), axis)
            assert found.missing == 1
            assert not found.passed


@pytest.mark.parametrize("name", AXES)
@pytest.mark.parametrize("factor", [0.98, 1.02])
def test_every_facet_counts(name: str, factor: float) -> None:
    """Whichever is moved no longer belongs to the vertices, or to the platform."""
    axis, of = AXES[name], certificate(AXES[name])
    touching = np.abs(np.vstack([cell.vertices for cell in of.cells]) @ of.forms.T - of.upper)
    for row in np.flatnonzero((touching < 1e-9 * of.upper).any(axis=0)):
        upper = of.upper.copy()
        upper[row] *= factor
        assert not check(replace(of, upper=upper), axis).passed
    forms = of.forms.copy()
    forms[-1, 1] *= factor
    assert not check(replace(of, forms=forms), axis).passed


@pytest.mark.parametrize("name", AXES)
def test_every_command_counts(name: str) -> None:
    """One beyond its bound, and one that leads out of the set, are refused."""
    axis, of = AXES[name], certificate(AXES[name])
    cell = of.cells[0]
    beyond = cell.commands.copy()
    beyond[0] = 1.001 * axis.command
    assert check(with_cell(of, 0, cell._replace(commands=beyond)), axis).refused == 1
    outwards = np.sign(cell.vertices[:, 1] + 1e-9 * cell.vertices[:, 0]) * axis.command
    assert check(with_cell(of, 0, cell._replace(commands=outwards)), axis).shrink > 1.0


def test_a_set_for_one_axis_alone_does_not_prove_two_in_a_circle() -> None:
    """The cells on both sides of z = 0 are asked for, and one of them does not do."""
    alone, shared = certificate(SURGE), certificate(SHARED)
    assert not check(alone, SHARED).passed
    assert not check(replace(shared, cells=shared.cells[:1]), SHARED).passed
    assert not check(replace(shared, cells=shared.cells[:1] * 2), SHARED).passed


def test_a_set_of_another_platform_is_refused() -> None:
    """One with less reach, less speed, less command, or more lag."""
    of, limits = certificate(HEAVE), HEAVE.limits
    for narrower in (
        replace(limits, position=(-0.41, 0.42)),
        replace(limits, velocity=0.6),
        replace(limits, command=9.9),
    ):
        assert not check(of, replace(HEAVE, limits=narrower)).passed
    assert not check(of, replace(HEAVE, lag=0.03)).passed


def test_damaged_arrays_are_refused_in_a_sentence() -> None:
    arrays = certificate(HEAVE).to_arrays()
    for name in arrays:
        with pytest.raises(CorruptFile, match="lacks the array"):
            AxisCertificate.from_arrays({key: value for key, value in arrays.items() if key != name})
    for name, bad in (
        ("forms", np.zeros((2, 2))),
        ("upper", -arrays["upper"]),
        ("lower", arrays["lower"] * np.nan),
    ):
        with pytest.raises(CorruptFile, match="damaged"):
            AxisCertificate.from_arrays(arrays | {name: bad})
