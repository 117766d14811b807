"""What every algorithm does on every scenario, stored, and compared with what was stored before.

    python benchmarks/equality.py store FILE
    python benchmarks/equality.py check FILE

A change of the code that should not change what is computed is held to it: per run the RMSE of the felt
force, the RMS of the platform's pose and the number of decisions by the fallback are those of the file,
within a relative `TOLERANCE`. Prints every difference and exits with 1 where there is one.
"""

import json
import sys
from collections.abc import Iterator
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from otolith import metrics, registry
from otolith.core.frames import DOFS, Dof
from otolith.cueing.design import Design
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import BLOCKS, MpcSettings
from otolith.interfaces import Status
from otolith.loop import Run, simulate
from otolith.platforms import load
from otolith.scenarios import SCENARIOS, Scenario, scenario

TOLERANCE = 1e-6
FLOOR = 1e-9  # [SI] figures below are zero but for rounding
SLOW_YAW = 0.1  # a signal of 1 m/s² is one of 0.1 rad/s about z

SIZES = {
    "2": ("surge-pitch",),
    "4": ("surge-pitch", "sway-roll"),
    "6": ("surge-pitch", "sway-roll", "heave", "yaw"),
}
SETTINGS: dict[str, dict[str, Any]] = {
    "default": {},
    "blocks": {"horizon": sum(BLOCKS), "blocks": BLOCKS},
    "printed": {"braking": BrakingRows.PRINTED},
    "position": {"braking": BrakingRows.POSITION, "terminal": True},
}
MPC, SENSED = ("implicit", "implicit-sensed", "linear-mpc"), ("implicit", "implicit-sensed")
GUESSING = ("implicit-trajectory", "hybrid-first", "hybrid-all")
WASHOUTS = ("classical", "optimal", "optimal-nonlinear", "adaptive")
BOTH = ("2", "4")
# Algorithms, settings, platforms, sizes. Those with a hint give the answers of `implicit`.
CASES = (
    (MPC, "default", ("thesis", "davsi"), BOTH),
    (MPC, "default", ("davsi",), ("6",)),
    (SENSED, "blocks", ("thesis",), BOTH),
    (SENSED, "position", ("thesis",), BOTH),
    (("implicit",), "printed", ("thesis",), BOTH),
    (GUESSING, "position", ("thesis",), ("2",)),
    (("explicit",), "default", ("thesis",), BOTH),
    (WASHOUTS, "default", ("thesis",), BOTH),
)


def reference(name: str, dofs: tuple[Dof, ...]) -> Scenario:
    """One scenario along all degrees of freedom at once."""
    along = [scenario(name, axis=dof.along).scaled(SLOW_YAW if dof.feels_rate else 1.0) for dof in dofs]
    return reduce(Scenario.combined_with, along)


def runs() -> Iterator[tuple[str, Run]]:
    for names, setting, platforms, sizes in CASES:
        for name in names:
            for platform in platforms:
                for size in sizes:
                    yield from runs_of(name, setting, platform, size)


def runs_of(name: str, setting: str, on: str, size: str) -> Iterator[tuple[str, Run]]:
    platform, dofs = load(on), tuple(DOFS[one] for one in SIZES[size])
    design = Design(platform=platform, dofs=dofs, mpc=MpcSettings(**SETTINGS[setting]))
    late = ["actuator"] if setting == "default" and size != "6" and name != "explicit" else []
    for moved in [registry.CUEING[name].plant, *late]:
        plant = registry.PLANTS[moved].load()(platform)
        cueing = registry.make_cueing(name, design, dead_time=plant.dead_time)
        for of in SCENARIOS:
            run = simulate(cueing, plant, reference(of, dofs), platform=platform, dofs=SIZES[size])
            yield f"{name} {setting} {on} {size} {moved} {of}", run


def figures(run: Run) -> dict[str, Any]:
    return {
        "rmse": metrics.tracking_rmse(run).tolist(),
        "pose": np.sqrt(np.mean(run.pose**2, axis=0)).tolist(),
        "failed": sum(status != Status.DECIDED for status in run.status),
    }


def difference(found: dict[str, Any], stored: dict[str, Any]) -> float:
    """Largest relative difference; a number of failed decisions counts as it is."""
    worst = float(abs(found["failed"] - stored["failed"]))
    for name in ("rmse", "pose"):
        now, before = np.array(found[name]), np.array(stored[name])
        worst = max(worst, float(np.max(np.abs(now - before) / np.maximum(np.abs(before), FLOOR))))
    return worst


def main(task: str, file: str) -> int:
    if task == "store":
        Path(file).write_text(json.dumps({name: figures(run) for name, run in runs()}))
        return 0
    stored, worst, beyond = json.loads(Path(file).read_text()), 0.0, 0
    for name, run in runs():
        off = difference(figures(run), stored[name])
        worst, beyond = max(worst, off), beyond + (off > TOLERANCE)
        if off > TOLERANCE:
            print(f"{name}: {off:.2g}", flush=True)
    print(f"{len(stored)} runs, {beyond} beyond {TOLERANCE:g}, largest relative difference {worst:.2g}")
    return int(beyond > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
