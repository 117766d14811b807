"""Multi-parametric quadratic programming: enumerate, evaluate, verify and export explicit laws.

The package does not know what a problem stands for.
"""

from otolith.mpqp.certify import Verification, verify
from otolith.mpqp.counts import ball_radii, count_regions, overlapping_sets
from otolith.mpqp.enumerate import Progress, enumerate_regions
from otolith.mpqp.equality import Eliminated, eliminate
from otolith.mpqp.export_c import CSource, export_c
from otolith.mpqp.law import Evaluation, Evaluations, Law
from otolith.mpqp.partial import HitRate, PartialLaw
from otolith.mpqp.problem import InvalidProblem, NoRegions, ParametricQp
from otolith.mpqp.separable import JointLaw, Part, enumerate_parts, separate

__all__ = [
    "CSource",
    "Eliminated",
    "Evaluation",
    "Evaluations",
    "HitRate",
    "InvalidProblem",
    "JointLaw",
    "Law",
    "NoRegions",
    "ParametricQp",
    "Part",
    "PartialLaw",
    "Progress",
    "Verification",
    "ball_radii",
    "count_regions",
    "eliminate",
    "enumerate_parts",
    "enumerate_regions",
    "export_c",
    "overlapping_sets",
    "separate",
    "verify",
]
