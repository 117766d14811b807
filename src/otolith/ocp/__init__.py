"""Optimal control over a horizon that is known as a whole, and thousands of steps long.

It knows nothing of motion cueing: linear dynamics, bounds, discs, and a smooth cost that is given as a role.
"""

from otolith.ocp.certificate import Certificate, certify
from otolith.ocp.interior import Breakdown, solve
from otolith.ocp.problem import Answer, Cost, Disc, Dynamics, Expansion

__all__ = ["Answer", "Breakdown", "Certificate", "Cost", "Disc", "Dynamics", "Expansion", "certify", "solve"]
