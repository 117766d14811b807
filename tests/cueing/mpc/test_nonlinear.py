"""One Gauss-Newton step against the nonlinear problem, which is written once more and solved by IPOPT."""

import numpy as np
import pytest

from otolith import registry
from otolith.core.arrays import Mat
from otolith.core.frames import HEAVE, SURGE_PITCH
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.interfaces import PlatformState, Reference, Status
from otolith.plant import Ideal
from otolith.qp.blocked import block_starts
from tests.cueing.mpc.test_body import DAVSI, with_head

pytest.importorskip("casadi")


def planned(mpc: Mpc) -> Mat:
    """The inputs of all blocks (M, nu) in the last plan."""
    inputs: Mat = mpc.program.plan[block_starts(mpc.settings.lengths)]
    return inputs


def test_single_steps_stay_at_the_optimum_of_the_nonlinear_problem() -> None:
    """Along a drive with one jump, costs agree to a part in a thousand, and firm rows hold within margins."""
    design = Design(platform=with_head(DAVSI), dofs=(SURGE_PITCH, HEAVE))
    single, full = (registry.make_cueing(name, design) for name in ("six-axis", "six-axis-nmpc"))
    assert isinstance(single, Mpc)
    assert isinstance(full, Mpc)
    plant, state = Ideal(), PlatformState()
    for part in (single, full, plant):
        part.reset(state)
    for k in range(60):
        force = np.array([1.5 if k >= 10 else 0.2 * np.sin(0.3 * k), 0.0, 0.1])
        reference = Reference(specific_force=force)
        command = single.step(state, reference)
        if k % 20 == 3:
            exact = full.step(state, reference)
            assert exact.outcome.status is Status.DECIDED
            best, _ = full.engine.judge(planned(full))  # type: ignore[attr-defined]
            found, beyond = full.engine.judge(planned(single))  # type: ignore[attr-defined]
            assert best * (1.0 - 1e-6) - 1e-7 <= found < best + 1e-3 * (best + 1e-3)
            assert beyond < 0.02
            assert np.abs(command.acceleration - exact.acceleration).max() < 0.05
        state = plant.step(command, single.period)
