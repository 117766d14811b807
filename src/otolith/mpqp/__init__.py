"""Multi-parametric quadratic programming: enumerate, evaluate, verify and export explicit laws.

Knows nothing of what a problem stands for.
"""

from otolith.mpqp.certify import Verification, verify
from otolith.mpqp.enumerate import Progress, enumerate_regions
from otolith.mpqp.law import Evaluation, Evaluations, Law
from otolith.mpqp.problem import InvalidProblem, NoRegions, ParametricQp

__all__ = [
    "Evaluation",
    "Evaluations",
    "InvalidProblem",
    "Law",
    "NoRegions",
    "ParametricQp",
    "Progress",
    "Verification",
    "enumerate_regions",
    "verify",
]
