"""Otolith's own engine for `StageQp`: compiled for one structure, certified, microseconds per problem.

Suggested reading order: `layout` (where everything lies), `emit` with `cost` and `blocks` (the recursions
over stages, written out for the non-zeros), then the kernels `working` (a working set and its exchange),
`interior` (the fallback), `certify` (the judgement), `solve` (one call). `generate` builds a structure's
module from them, and `engine` owns it.
"""

from otolith.qp.structured.engine import StructuredSettings, StructuredSolver

__all__ = ["StructuredSettings", "StructuredSolver"]
