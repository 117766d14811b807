"""Tools of these tests: a task without any MPC, a loop without a lag, the fit of a sine."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.frames import SURGE_PITCH, Dof
from otolith.cueing.washout.feedforward import Washout
from otolith.cueing.washout.tuning import Corners, Tuning, load_tuning
from otolith.loop import Run, simulate
from otolith.plant.ideal import Ideal
from otolith.platforms import Platform, load
from otolith.scenarios import Scenario

DAVSI, TUNING = load("davsi"), load_tuning("davsi")


@dataclass(frozen=True, kw_only=True)
class Task:
    platform: Platform = DAVSI
    dofs: tuple[Dof, ...] = (SURGE_PITCH,)
    tuning: Tuning = TUNING
    corners: Corners = field(default_factory=Corners)


Signal = Callable[[Vec], Vec]


def still(t: Vec) -> Vec:
    return np.zeros((len(t), 3))


def drive(washout: Washout, duration: float, force: Signal = still, rate: Signal = still, **more: Any) -> Run:
    """Close the loop on the platform without a lag."""
    wanted = Scenario(name="by hand", duration=duration, specific_force=force, angular_rate=rate)
    return simulate(washout, Ideal(lag=0.0), wanted, platform=Task().platform, dofs=("surge-pitch",), **more)


def fitted(t: Vec, y: Vec, omega: float) -> complex:
    """The amplitude c of y ≈ Im(c e^(jωt)) by least squares, t after the transient, whole periods."""
    t_last = t[-1]
    whole = np.floor((t_last - 0.5 * t_last) * omega / (2 * np.pi)) * 2 * np.pi / omega
    keep = t > t_last - whole
    A = np.column_stack([np.sin(omega * t[keep]), np.cos(omega * t[keep])])
    s, c = np.linalg.lstsq(A, y[keep], rcond=None)[0]
    return complex(s, c)


def along(axis: int, signal: Callable[[Vec], Vec]) -> Signal:
    """A scalar signal along one axis."""

    def signals(t: Vec) -> Vec:
        values = np.zeros((len(t), 3))
        values[:, axis] = signal(t)
        return values

    return signals
