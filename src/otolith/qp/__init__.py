"""Quadratic programs: problem, solution, certificate, engines. Knows nothing of motion cueing."""

from otolith.qp.dense import DenseSolver
from otolith.qp.problem import Qp, Solution, Status, kkt_residual

__all__ = ["DenseSolver", "Qp", "Solution", "Status", "kkt_residual"]
