"""A vertex at which nearly as many rows meet as there are inputs, and some nearly depend on each other.

The problem is one of a lap at 120 km/h, cued by `predictive` in 4 DOF on `davsi-4dof`, with the plan of the
period before. From there the sets of the engine exchange the same rows for ever, and the multipliers of the
set that is right do not settle to the last digit.
"""

from pathlib import Path

import numpy as np
import pytest

from otolith import registry
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.platforms import load
from otolith.qp import Status
from otolith.qp.condensed import CondensedSolver
from otolith.qp.engines import StructuredEngine, expand

VERTEX = Path(__file__).with_name("data") / "degenerate_vertex.npz"


def test_a_degenerate_vertex_is_solved_by_its_certificate() -> None:
    design = Design(platform=load("davsi-4dof"), dofs=(SURGE_PITCH, SWAY_ROLL))
    mpc = registry.make_cueing("predictive", design)
    assert isinstance(mpc, Mpc)
    engine = mpc.engine
    assert isinstance(engine, StructuredEngine)
    engine.reset()
    with np.load(VERTEX) as vertex:
        engine.entrance.U[:] = vertex["plan"]
        for part in engine.memory._fields:
            getattr(engine.memory, part)[:] = vertex[part]
    found = engine.run()
    qp = expand(mpc.problem.structure, engine.memory, mpc.settings.blocks)
    solver = CondensedSolver(mpc.problem.structure, blocks=mpc.settings.blocks)
    dense, exact = solver.condense(qp), solver.solve(qp)
    assert (found.status, engine.undecided) == (Status.OPTIMAL, 0)
    costs = [u @ dense.H @ u / 2.0 + dense.g @ u for u in (found.U.ravel(), exact.U.ravel())]
    assert costs[0] == pytest.approx(costs[1], rel=1e-7)
    apart = (found.U - exact.U).ravel()
    assert apart @ dense.H @ apart / 2.0 < 1e-7 * abs(costs[1])  # in a flat cost: inputs weigh 2e-5
