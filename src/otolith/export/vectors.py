"""Test vectors: what a program is given and what it must answer, from a closed loop in Python."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith import registry
from otolith.compiled import SOLVERS, STATUSES
from otolith.core.arrays import Mat, Vec
from otolith.cueing.design import Design
from otolith.export.make import PLANT_PERIOD, Kind
from otolith.loop import Run, simulate
from otolith.loop.simulate import EDGE
from otolith.scenarios import Scenario

EFFORT: Final = 2  # outputs at the end, changes and residual, that a compiler's rounding may change
_FORCES: Final = ((0.9, 0.07), (1.2, 0.31), (1.5, 1.3))  # amplitudes [m/s²] and frequencies [Hz]
_RATES: Final = ((0.06, 0.11), (0.08, 0.45), (0.05, 1.7))  # [rad/s], [Hz]


@dataclass(frozen=True, slots=True)
class Vectors:
    """What went into every decision of a drive, and what came out."""

    inputs: Mat  # (m, inputs of the program)
    outputs: Mat  # (m, its outputs)
    free: int = EFFORT  # outputs at the end that may differ


@dataclass(frozen=True, slots=True)
class _Sines:
    """Three signals that are sums of sines, each with phases of its own."""

    parts: tuple[tuple[float, float], ...]
    phases: tuple[tuple[float, ...], ...]

    def __call__(self, t: Vec) -> Mat:
        amplitude, frequency = np.array(self.parts).T
        turns = 2.0 * math.pi * t[:, None, None] * frequency + np.array(self.phases)  # (n, axes, parts)
        signals: Mat = np.sin(turns) @ amplitude
        return signals


def drive(duration: float, seed: int = 0) -> Scenario:
    """Return a drive that asks something of all axes, and more of a platform than it can give.

    Parameters
    ----------
    duration : [s].
    seed : of the phases.
    """
    random = np.random.default_rng(seed)
    force, rate = (
        _Sines(parts, tuple(tuple(random.uniform(0.0, 2.0 * math.pi, len(parts))) for _ in range(3)))
        for parts in (_FORCES, _RATES)
    )
    return Scenario(name="sums of sines", duration=duration, specific_force=force, angular_rate=rate)


def vectors(
    design: Design, cueing: str, kind: Kind, reference: Scenario, *, plant: str | None = None
) -> Vectors:
    """Return the test vectors of a program, from a closed loop on a plant.

    Parameters
    ----------
    plant : a name in the registry; by default, the plant that the algorithm's model describes.
    """
    return simulated(design, cueing, kind, reference, plant=plant)[1]


def simulated(
    design: Design, cueing: str, kind: Kind, reference: Scenario, *, plant: str | None = None
) -> tuple[Run, Vectors]:
    """Return the closed loop from which `vectors` come, too; arguments are the same."""
    moved = registry.make_plant(plant or registry.cueing_named(cueing).plant, design.platform)
    algorithm = registry.make_cueing(cueing, design, dead_time=moved.dead_time)
    names = tuple(dof.name for dof in design.dofs)
    run = simulate(
        algorithm, moved, reference, platform=design.platform, dofs=names, plant_period=PLANT_PERIOD
    )
    at = np.arange(run.decisions, dtype=np.float64) * algorithm.period + EDGE
    wanted = np.hstack([reference.specific_force(at), reference.angular_rate(at)])
    every = run.samples // run.decisions
    motion = np.hstack([run.pose, run.twist, run.acceleration])
    if kind is Kind.COMMAND:
        before = np.vstack([np.zeros(18), motion[every - 1 : -1 : every]])
        return run, Vectors(np.hstack([wanted, before]), np.hstack([run.command, _outcome(run)]))
    ends = slice(every - 1, None, every)
    return run, Vectors(wanted, np.hstack([motion[ends], run.felt_force[ends], _outcome(run)]))


def _outcome(run: Run) -> Mat:
    """Return status, solver, changes and residual of all decisions, as a program gives them."""
    status = [[one.value for one in STATUSES].index(one) for one in run.status]
    solver = [[str(one) for one in SOLVERS].index(one) for one in run.solver]
    return np.column_stack([status, solver, run.changes, run.residual]).astype(np.float64)
