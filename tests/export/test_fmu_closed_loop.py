"""A real algorithm as an FMU: the motion of `otolith run`, sample by sample, and rest without a reference."""

import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu

import otolith
from otolith.export.fmu import fmu
from otolith.export.make import Kind, program_of
from otolith.export.program import Program
from otolith.loop.simulate import EDGE
from tests.export.fmus import COMPILER, VERSIONS, Host, host, needs_compiler

pytestmark = needs_compiler

WANTED = otolith.Wanted(scenario="step:amplitude=1.0,start=0.5,end=1.5,duration=3")
DESIGN = otolith.Design(platform=otolith.platform("thesis"), dofs=(otolith.SURGE_PITCH, otolith.SWAY_ROLL))


@pytest.fixture(scope="module")
def program() -> Program:
    return program_of(DESIGN, "classical", "washout", Kind.PLATFORM)


@pytest.fixture(scope="module", params=VERSIONS)
def folder(
    program: Program, request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    made: Path = tmp_path_factory.mktemp("washout")
    zipfile.ZipFile(BytesIO(fmu(program, request.param, [str(COMPILER)]))).extractall(made)
    return made


def feed(one: Host, force: np.ndarray, rate: np.ndarray) -> None:
    for axis, f, r in zip("xyz", force, rate, strict=True):
        one.set(f"wanted_force_{axis}", f)
        one.set(f"wanted_rate_{axis}", r)


def test_the_motion_is_that_of_otolith_run(program: Program, folder: Path) -> None:
    """Also at a fifth of a period per step; the scenario jumps, so a shift by one decision would show."""
    assert validate_fmu(str(folder)) == []
    run = otolith.Experiment(wanted=WANTED, cueing="classical", design=DESIGN).run()
    every = round(run.period / run.plant_period)
    motion = np.hstack([run.pose, run.twist, run.acceleration, run.felt_force])[every - 1 :: every]
    times = np.arange(len(motion), dtype=np.float64) * run.period + EDGE
    scenario = WANTED.along(DESIGN)
    names = [port.name for port in program.outputs[:21]]
    with host(folder) as one:
        for k, (force, rate) in enumerate(
            zip(scenario.specific_force(times), scenario.angular_rate(times), strict=True)
        ):
            feed(one, force, rate)
            for i in range(5):
                one.step(k * run.period + i * run.period / 5, run.period / 5)
            np.testing.assert_allclose([one.get(name) for name in names], motion[k], rtol=0.0, atol=1e-9)
        assert one.said == []
    assert np.ptp(motion[:, 0]) > 0.05


def test_without_a_finite_reference_it_brakes_to_rest_and_follows_again(folder: Path) -> None:
    with host(folder) as one:
        speeds = []
        for k in range(300):
            feed(one, np.array([np.nan if 100 <= k < 200 else 1.0, 0.0, 0.0]), np.zeros(3))
            one.step(k * 0.01, 0.01)
            assert one.get("status") == (3.0 if 100 <= k < 200 else 0.0)
            speeds.append([one.get(f"velocity_{axis}") for axis in ("surge", "pitch")])
        assert np.abs(speeds[99]).max() > 0.02
        assert np.abs(speeds[140:200]).max() < 1e-6
        assert np.abs(speeds[230:]).max() > 0.02
        assert one.said == ["from 1 s on a fallback brakes to rest, status 3 (invalid)"]
