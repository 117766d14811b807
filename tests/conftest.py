"""Shared by all tests: a run without any algorithm behind it, made by hand."""

import numpy as np
import pytest

from otolith.core.frames import SURGE_PITCH
from otolith.loop import Run
from otolith.platforms import load


@pytest.fixture
def handmade() -> Run:
    """One second, 10 decisions, 100 samples: position ramps to 0.1 m, tilt stays, 0.2 m/s² is wanted."""
    n, m = 100, 10
    time = np.arange(1, n + 1, dtype=float) * 0.01
    pose, twist, acceleration = np.zeros((n, 6)), np.zeros((n, 6)), np.zeros((n, 6))
    pose[:, SURGE_PITCH.translation] = 0.1 * time
    twist[:, SURGE_PITCH.translation] = 0.1
    felt, wanted = np.zeros((n, 3)), np.zeros((n, 3))
    wanted[:, 0] = 0.2
    return Run(
        scenario="by hand",
        cueing="nobody",
        plant="none",
        platform=load("thesis"),
        dofs=("surge-pitch",),
        settings={"scale": 1.0},
        period=0.1,
        plant_period=0.01,
        time=time,
        reference_force=wanted,
        reference_rate=np.zeros((n, 3)),
        felt_force=felt,
        pose=pose,
        twist=twist,
        acceleration=acceleration,
        command_time=np.arange(m, dtype=float) * 0.1,
        command=np.zeros((m, 6)),
        status=("decided",) * 9 + ("fallback",),
        solver=("optimal",) * 9 + ("infeasible",),
        changes=np.array([0, 0, 0, 0, 0, 0, 0, 0, 2, 8]),
        residual=np.array([1e-12] * 9 + [np.inf]),
        guess_missed=np.array([False] * 9 + [True]),
        step_time=np.linspace(1e-6, 10e-6, m),
    )
