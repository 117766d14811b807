"""Exported FMUs, driven by FMPy as a host drives them, beside `otolith run` on the same scenario.

    python benchmarks/fmu.py [--cueing NAME ...] [--scenario NAME] [--dofs NAME,...]

For each algorithm, version of FMI and communication step: the largest difference of the motion at the end of
every period, and the CPU time of one decision through FMPy, whose own calls from Python are part of it. Exits
with 1 where a difference is above 1e-9 of the largest value of its signal.
"""

import argparse
import sys
import tempfile
import time
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

import otolith
from otolith.core.arrays import Mat
from otolith.core.frames import dofs_named
from otolith.export.fmu import fmu
from otolith.export.fmu_binary import installed_compiler
from otolith.export.make import Kind, program_of
from otolith.export.program import Program
from otolith.loop.simulate import EDGE

BOUND: Final = 1e-9
PARTS: Final = (0.1, 1.0)  # periods per communication step


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cueing", nargs="+", default=["classical", "adaptive", "optimal", "predictive"])
    parser.add_argument("--scenario", default="sine-1")
    parser.add_argument("--dofs", default="surge-pitch")
    given = parser.parse_args()
    design = otolith.Design(platform=otolith.platform("thesis"), dofs=dofs_named(given.dofs.split(",")))
    wanted = otolith.Wanted(scenario=given.scenario)
    print(f"{'algorithm':16}{'FMI':>5}{'kB':>7}{'periods/step':>14}{'difference':>12}{'CPU us/period':>15}")
    worst = 0.0
    for cueing in given.cueing:
        run = otolith.Experiment(wanted=wanted, cueing=cueing, design=design).run()
        program = program_of(design, cueing, "cueing", Kind.PLATFORM)
        times = np.arange(len(run.command_time), dtype=np.float64) * run.period + EDGE
        scenario = wanted.along(design)
        inputs = np.hstack([scenario.specific_force(times), scenario.angular_rate(times)])
        motion = np.hstack([run.pose, run.twist, run.acceleration, run.felt_force])
        motion = motion[round(run.period / run.plant_period) - 1 :: round(run.period / run.plant_period)]
        for version in ("2.0", "3.0"):
            packed = fmu(program, version, [installed_compiler()])
            for part in PARTS:
                got, seconds = driven(packed, program, inputs, part)
                scale = np.maximum(np.abs(motion).max(axis=0), 1.0)
                gap = float((np.abs(got[:, : motion.shape[1]] - motion) / scale).max())
                worst = max(worst, gap)
                cost = 1e6 * seconds / len(times)
                size = len(packed) / 1000
                print(f"{cueing:16}{version:>5}{size:7.0f}{part:14g}{gap:12.1e}{cost:15.1f}", flush=True)
    sys.exit(worst > BOUND)


def driven(packed: bytes, program: Program, inputs: Mat, part: float) -> tuple[Mat, float]:
    """Return the outputs (n, outputs) at the end of every period, and the CPU seconds of all steps."""
    steps = round(1.0 / part)
    length, seconds, got = program.period / steps, 0.0, []
    first, last = 1 + len(program.inputs), 1 + len(program.inputs) + len(program.outputs)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "it.fmu").write_bytes(packed)
        zipfile.ZipFile(Path(folder) / "it.fmu").extractall(folder)
        slave, set_, get = instance(folder)
        for k, row in enumerate(inputs):
            set_(range(1, first), row)
            begun = time.process_time()
            for i in range(steps):
                slave.doStep(k * program.period + i * length, length)
            seconds += time.process_time() - begun
            got.append(get(range(first, last)))
        slave.terminate()
        slave.freeInstance()
    return np.array(got), seconds


def instance(folder: str) -> tuple[Any, Any, Any]:
    """Return an instance that is ready to step, and how its numbers are set and read."""
    described = fmpy.read_model_description(folder)
    names: Sequence[tuple[str, str]] = (
        ("guid", described.guid),
        ("unzipDirectory", folder),
        ("modelIdentifier", described.coSimulation.modelIdentifier),
    )
    if described.fmiVersion == "2.0":
        slave = FMU2Slave(**dict(names))
        slave.instantiate()
        slave.setupExperiment()
        set_, get = slave.setReal, slave.getReal
    else:
        slave = FMU3Slave(**dict(names))
        slave.instantiate()
        set_, get = slave.setFloat64, slave.getFloat64
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    return slave, set_, get


if __name__ == "__main__":
    main()
