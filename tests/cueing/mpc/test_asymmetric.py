"""A platform with unequal reaches, found by `benchmarks/asymmetric.py`: the first input is the optimum's.

The tilt waits at a limit that it shares with its braking rows, stage after stage: together these rows fix
it nearly twice, and the last 1e-9 rad of one of them are worth 1e-3 rad/s² of the first input. Without
foreseeing the multiplier steps to come the engine stopped there, certified, 6e-4 to 1e-3 away.
"""

import numpy as np
import pytest

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Platform
from otolith.qp import DenseSolver, Status
from otolith.qp.condensed import CondensedSolver
from otolith.qp.engines import StructuredEngine, expand

PLATFORM = Platform.model_validate(
    {
        "name": "unequal",
        "surge": {
            "position_m": [-0.1998480644505099, 0.05835165459720422],
            "velocity_mps": 20.0,
            "acceleration_mps2": 5.344009229169983,
        },
        "pitch": {"angle_deg": [-4.502217075173321, 1.0], "acceleration_degps2": 234.63329393494013},
        "tilt_coordination": {"pitch_degps": 3.857341522161761},
    }
)
STATE = np.array(
    [0.010064745497926847, 0.07840542433456783, 0.0, -0.1416900076058388, 0.0, 1.0394081862388873]
)
WANTED = 1.0455547240489664  # [m/s²]


@pytest.mark.parametrize("weight", [2.5384982838912997e-4, 1e-4, 1e-5])
def test_rows_that_nearly_depend_on_each_other_do_not_move_the_first_input(weight: float) -> None:
    settings = MpcSettings(control_weight=weight)
    formulation = Problem(PLATFORM, (SURGE_PITCH,), settings)
    engine = StructuredEngine(formulation.structure, tolerance=1e-6)
    formulation.begin(engine.memory)
    plan, wanted = np.zeros((settings.horizon, 2)), np.full((settings.horizon, 1), WANTED)
    formulation.write(engine.memory, STATE, plan, wanted, None)
    exact = CondensedSolver(formulation.structure, DenseSolver(primal_tolerance=1e-11))
    right = exact.solve(expand(formulation.structure, engine.memory))
    found = engine.run(right.working_set)
    assert (found.status, right.status) == (Status.OPTIMAL, Status.OPTIMAL)
    np.testing.assert_allclose(found.U[0], right.U[0], rtol=0.0, atol=5e-5)
