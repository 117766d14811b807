"""Export a washout as an FMU, simulate it with FMPy (pip install fmpy), and compare with Otolith itself."""

import tempfile
from pathlib import Path

import numpy as np
from fmpy import simulate_fmu

import otolith
from otolith.export.fmu import fmu
from otolith.export.fmu_binary import installed_compiler
from otolith.export.make import Kind, program_of

WANTED = otolith.Wanted(scenario="sine:amplitude=0.8,frequency=0.15,duration=8")

design = otolith.Design(platform=otolith.platform("thesis"))
program = program_of(design, "classical", "washout", Kind.PLATFORM)
run = otolith.Experiment(wanted=WANTED, cueing="classical", design=design).run()

# What the host feeds in at every decision; where a signal jumps, decisions see the value just after.
times = np.arange(len(run.command_time), dtype=np.float64) * run.period
scenario = WANTED.along(design)
force, rate = scenario.specific_force(times + 1e-9), scenario.angular_rate(times + 1e-9)
names = ["time", *(port.name for port in program.inputs)]
rows = np.column_stack([times, force, rate])
wanted = np.array([tuple(row) for row in rows], dtype=[(name, float) for name in names])

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "washout.fmu"
    file.write_bytes(fmu(program, "3.0", [installed_compiler()]))
    print(f"{file.name}: {file.stat().st_size / 1000:.0f} kB")
    result = simulate_fmu(
        str(file),
        input=wanted,
        output=["pose_surge", "felt_force_x"],
        stop_time=8.0,
        output_interval=run.period,
    )

every = round(run.period / run.plant_period)  # the run has ten samples of the motion per decision
for name, ours in (("pose_surge", run.pose[:, 0]), ("felt_force_x", run.felt_force[:, 0])):
    gap = np.abs(result[name][1:] - ours[every - 1 :: every]).max()
    print(f"{name}: largest difference from `otolith run` {gap:.1e}")
    if gap > 1e-9:
        raise SystemExit(f"{name} differs by {gap:.1e}, must be at most 1e-9")
