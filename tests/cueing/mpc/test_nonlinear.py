"""One Gauss-Newton step against the nonlinear problem, which is written once more and solved by IPOPT."""

import numpy as np
import pytest

from otolith import registry
from otolith.core.arrays import Mat
from otolith.core.frames import HEAVE, SURGE_PITCH
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.motion import TILT_RATE
from otolith.cueing.mpc.six_axis import Generator
from otolith.cueing.prediction import Adaptive
from otolith.interfaces import PlatformState, Reference, Status
from otolith.perception import Vestibular
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


def test_khusros_generator_follows_what_is_perceived_and_draws_all_other_states_to_zero() -> None:
    """The reference is what the organs pass on; a rate that is wanted turns the platform its way."""
    design = Design(platform=DAVSI, dofs=(SURGE_PITCH,), generator=Generator.KHUSRO)
    mpc, organs, predictor = registry.make_cueing("six-axis-nmpc", design), Vestibular(), Adaptive().begin()
    assert isinstance(mpc, Mpc)
    force, rate = np.zeros((3, 3)), np.zeros((3, 3))
    force[1:, 0], rate[1:, 1] = 1.0, 0.03
    for k in range(3):
        command = mpc.step(PlatformState(), Reference(specific_force=force[k], angular_rate=rate[k]))
        assert command.outcome.status is Status.DECIDED
        felt, turned = organs.force(force[: k + 1], 0.01)[-1], organs.rate(rate[: k + 1], 0.01)[-1]
        coming = predictor.ahead(Reference(specific_force=felt, angular_rate=turned), 0.01, 150)
        np.testing.assert_allclose(mpc.program.wanted, coming[:, [0, 4]], atol=1e-12)
    mpc.reset(PlatformState())
    mpc.step(PlatformState(), Reference(specific_force=np.zeros(3), angular_rate=np.array([0.0, 1.0, 0.0])))
    motion = mpc.problem.predicted(mpc.program.x, mpc.program.plan)
    assert motion[:, TILT_RATE].min() < -1e-4  # a longitudinal tilt is minus the pitch
    assert {weight.on for _, _, weight in mpc.problem._weights} == {"position", "velocity", "tilt"}
