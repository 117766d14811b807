"""Shared by the tests of live operation: a washout, which needs no compiled solver, on six legs."""

import numpy as np
import pytest

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.design import Design
from otolith.cueing.washout.tuning import load_tuning
from otolith.interfaces import Cueing
from otolith.live.core.gate import Gate
from otolith.platforms import Platform, load
from otolith.registry import make_cueing

PARK = np.array([0.0, 0.0, -0.15, 0.0, 0.0, 0.0])


@pytest.fixture(scope="session")
def machine() -> Platform:
    """Six legs of which every combination of the four axes is within reach."""
    return load("davsi-4dof")


@pytest.fixture(scope="session")
def gate(machine: Platform) -> Gate:
    return Gate(machine, lag=0.01, period=0.01)


@pytest.fixture(scope="session")
def travel(machine: Platform) -> Gate:
    return Gate(machine, lag=0.01, period=0.01, park=PARK)


@pytest.fixture
def washout(machine: Platform) -> Cueing:
    design = Design(platform=machine, dofs=(SURGE_PITCH, SWAY_ROLL), washout=load_tuning("davsi"))
    return make_cueing("classical", design)
