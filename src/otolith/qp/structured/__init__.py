"""Our own engine for `StageQp`: compiled for one structure, certified, microseconds per problem.

To read it: `layout` (where everything lies), `emit` with `cost` and `blocks` (the recursions over stages,
written out for the non-zeros), then the kernels in the order `working` (a working set and its exchange),
`interior` (the fallback), `certify` (who judges), `solve` (one call). `generate` makes the module of a
structure from them, `engine` is its owner.
"""

from otolith.qp.structured.engine import StructuredSettings, StructuredSolver

__all__ = ["StructuredSettings", "StructuredSolver"]
