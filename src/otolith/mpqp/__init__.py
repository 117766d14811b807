"""Multi-parametric quadratic programming: enumerate, evaluate, verify and export explicit laws.

The package does not know what a problem stands for.
"""

from typing import TYPE_CHECKING

from otolith.core.lazy import on_first_use

if TYPE_CHECKING:
    from otolith.mpqp.certify import Verification, verify
    from otolith.mpqp.counts import ball_radii, count_regions, overlapping_sets
    from otolith.mpqp.enumerate import Progress, enumerate_regions
    from otolith.mpqp.equality import Eliminated, eliminate
    from otolith.mpqp.export_c import CSource, export_c
    from otolith.mpqp.law import Evaluation, Evaluations, Law
    from otolith.mpqp.partial import HitRate, PartialLaw
    from otolith.mpqp.problem import InvalidProblem, NoRegions, ParametricQp
    from otolith.mpqp.separable import JointLaw, Part, enumerate_parts, separate
else:
    __getattr__ = on_first_use(
        __name__,
        {
            "CSource": "export_c",
            "Eliminated": "equality",
            "Evaluation": "law",
            "Evaluations": "law",
            "HitRate": "partial",
            "InvalidProblem": "problem",
            "JointLaw": "separable",
            "Law": "law",
            "NoRegions": "problem",
            "ParametricQp": "problem",
            "Part": "separable",
            "PartialLaw": "partial",
            "Progress": "enumerate",
            "Verification": "certify",
            "ball_radii": "counts",
            "count_regions": "counts",
            "eliminate": "equality",
            "enumerate_parts": "separable",
            "enumerate_regions": "enumerate",
            "export_c": "export_c",
            "overlapping_sets": "counts",
            "separate": "separable",
            "verify": "certify",
        },
    )

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
