"""Our own engine for `StageQp`: Riccati recursions generated for one structure, in numba."""

from otolith.qp.structured.engine import StructuredSettings, StructuredSolver

__all__ = ["StructuredSettings", "StructuredSolver"]
