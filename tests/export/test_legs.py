"""The legs of a platform in C are told what `Hexapod.positions` gives."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest

import otolith
from otolith.export.legs import legs_program
from otolith.platforms.hexapod import Hexapod
from tests.export.fmus import COMPILER, needs_compiler
from tests.platforms.cranks import machine

POINTER = ctypes.POINTER(ctypes.c_double)


def told(hexapod: Hexapod, poses: np.ndarray, folder: Path) -> np.ndarray:
    """What the compiled program answers to poses (n, 6)."""
    program = legs_program(hexapod, "six", 0.01)
    (folder / "six.h").write_text(program.header)
    (folder / "six.c").write_text('#define SIX_IMPLEMENTATION\n#include "six.h"\n')
    warnings = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off"]
    command = [str(COMPILER), *warnings, "-O2", "-shared", "-fPIC", "-o", "six.so", "six.c", "-lm"]
    subprocess.run(command, check=True, cwd=folder)
    library, me = ctypes.CDLL(str(folder / "six.so")), ctypes.create_string_buffer(100_000)
    library.six_init(me)
    legs = np.empty((len(poses), 6))
    for pose, out in zip(np.ascontiguousarray(poses), legs, strict=True):
        assert library.six_step(me, pose.ctypes.data_as(POINTER), out.ctypes.data_as(POINTER)) == 0
    return legs


@needs_compiler
@pytest.mark.parametrize(
    ("hexapod", "reach"),
    [
        pytest.param(otolith.platform("davsi").six_legs(), 0.2, id="legs"),
        pytest.param(machine(seed=3), 0.03, id="cranks"),
        pytest.param(machine(push=False), 0.03, id="cranks that pull"),
    ],
)
def test_what_the_drives_are_told_is_that_of_python(hexapod: Hexapod, reach: float, tmp_path: Path) -> None:
    poses = np.random.default_rng(0).uniform(-reach, reach, (300, 6))
    expected = hexapod.positions(poses)
    assert np.isfinite(expected).mean() > 0.9
    np.testing.assert_allclose(told(hexapod, poses, tmp_path), expected, rtol=0.0, atol=1e-13)


def test_ports_say_lengths_or_angles_and_their_values_at_rest() -> None:
    legs, cranks = (legs_program(h, "six", 0.01) for h in (otolith.platform("davsi").six_legs(), machine()))
    assert {port.unit for port in legs.outputs} == {"m"}
    assert {port.unit for port in cranks.outputs} == {"rad"}
    at_rest = otolith.platform("davsi").six_legs().lengths(np.zeros(6))
    assert [port.start for port in legs.outputs] == list(at_rest)
