"""Quadratic programs: problem, solution, certificate, engines. Knows nothing of motion cueing."""

from otolith.qp.certificate import kkt_residual
from otolith.qp.dense import DenseSolver
from otolith.qp.problem import Qp, Solution, Status

__all__ = ["DenseSolver", "Qp", "Solution", "Status", "kkt_residual"]
