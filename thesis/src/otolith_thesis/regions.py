"""What counts as a region in Tables 5.2, 5.8, C.1 and C.3: the toolbox's rule, and other definitions.

The thesis computes its explicit laws with the Multi-Parametric Toolbox 3 (section D.2). It takes a polyhedron
as full-dimensional if twice the radius of its largest ball exceeds `region_tol`, 1e-7 by default, in the
parameters' own units (Herceg, Kvasnica, Jones & Morari, 2013; class `Polyhedron`). The thesis names no bounds
on parameters except the limits of its states. So a state without a limit is bounded by `OPEN` here, beyond
which no region is found (`study-open-parameters`).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.explicit_problem import UNLIMITED, ExplicitSettings, explicit_problem
from otolith.cueing.mpc.rows import Limits
from otolith.mpqp import Law, ball_radii, enumerate_regions, overlapping_sets
from otolith.platforms import load

TOOLBOX: Final = 0.5e-7  # [SI] radius: half of `region_tol`
FINEST: Final = 1e-8  # [SI] radius of the smallest region that a definition below counts
OPEN: Final = (
    500.0  # [m/s] reach of a velocity without a limit; the reference reaches ten times as far [m/s²]
)
RULE: Final = (
    "A region counts when the largest ball in it is at least 1e-7 across in the parameters’ own units (SI), "
    "the rule of the thesis’s toolbox; beside it, when its radius is 1e-7 in the parameters’ unit box."
)


@dataclass(frozen=True, slots=True)
class Definition:
    """The size of the largest ball in a region from which the region counts."""

    radius: float
    own_units: bool

    @property
    def label(self) -> str:
        """Return the heading of its column."""
        return f"{2.0 * self.radius:.0e} across" if self.own_units else f"{self.radius:.0e} of box"


DEFINITIONS: Final = (
    *(Definition(radius, own_units=False) for radius in (1e-6, 1e-7, 1e-8, 1e-9)),
    *(Definition(radius, own_units=True) for radius in (5e-7, 1e-7, TOOLBOX, 2e-8, FINEST)),
)
CHOSEN: Final = Definition(TOOLBOX, own_units=True)
UNIT_BOX: Final = Definition(1e-7, own_units=False)


def law_of(settings: ExplicitSettings, limits: Limits | None = None, *, finest: float = FINEST) -> Law:
    """Return the explicit law of surge-pitch with every region that holds a ball of radius `finest` [SI].

    In the parameter box scaled to [-1, 1]^p the ball has at least the radius `finest` over half the widest
    range.
    """
    thesis = load("thesis")
    limits = limits or thesis.limits(SURGE_PITCH)
    problem = explicit_problem(SURGE_PITCH, limits, thesis.braking, settings)
    widest = float(np.max(problem.upper - problem.lower)) / 2.0
    return enumerate_regions(problem, tolerance=finest / widest)


def open_settings(reach: float = OPEN) -> ExplicitSettings:
    """Return the settings of Table C.1: N = 5, no blocking, unlimited parameters bounded by `reach`.

    The reference is bounded by ten times as much, because an input without a limit may follow it anywhere; at
    `UNLIMITED` it is bounded as in all other laws.
    """
    if reach == UNLIMITED:
        return ExplicitSettings(block_from=None)
    return ExplicitSettings(block_from=None, open_bound=reach, reference_bound=10.0 * reach)


def counts(law: Law) -> dict[str, int]:
    """Count the regions of the law, mirror images included, by every definition."""
    own = ball_radii(law)
    found = {}
    for definition in DEFINITIONS:
        large = (own if definition.own_units else law.radius) >= definition.radius
        found[definition.label] = int(2 * large.sum() - large[: law.alone].sum())
    return found


def overlapping(law: Law) -> int:
    """Count the active sets outside the law whose regions overlap with the law's, by the toolbox's rule."""
    return len(overlapping_sets(law, TOOLBOX))
