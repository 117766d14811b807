"""Optimal control over a horizon that is known in full and thousands of steps long.

The room knows nothing of motion cueing. It holds linear dynamics, bounds, discs, and a smooth cost that the
caller supplies as a `Cost`.
"""

from otolith.ocp.certificate import Certificate, certify
from otolith.ocp.interior import Breakdown, solve
from otolith.ocp.problem import Answer, Cost, Disc, Dynamics, Expansion

__all__ = ["Answer", "Breakdown", "Certificate", "Cost", "Disc", "Dynamics", "Expansion", "certify", "solve"]
