"""Synthetic runs: a plausible washout-like motion, exact in its kinematics, of any length."""

from typing import Any, Protocol

import numpy as np
import pytest

from otolith.core.arrays import Vec
from otolith.core.frames import DOFS, GRAVITY, specific_force
from otolith.loop import Run
from otolith.platforms import load
from otolith.report import page

PERIOD, EVERY = 0.01, 10


class MakeRun(Protocol):
    """Builds a run of `steps` decisions; every field may be overridden."""

    def __call__(
        self,
        steps: int = ...,
        *,
        dofs: tuple[str, ...] = ...,
        amplitude: float = ...,
        seed: int = ...,
        **fields: Any,
    ) -> Run:
        """A run with a washout-like motion of this amplitude [m/s²]."""


def _motion(want: Vec, t: Vec, dt: float) -> tuple[Vec, Vec]:
    """Position with derivatives (3, n), and tilt with derivatives (3, n), of a spring-like washout."""
    position, tilt = np.zeros((3, len(t))), np.zeros((3, len(t)))
    s = v = a = th = w = alpha = 0.0
    for k in range(len(t)):
        a = want[k] - GRAVITY * np.sin(th) - 6.0 * s - 2.0 * v
        aim = np.clip(3.0 * (np.arcsin(np.clip(want[k] / GRAVITY, -0.5, 0.5)) - th), -0.052, 0.052)
        alpha = np.clip(20.0 * (aim - w), -0.6, 0.6)
        s, v, th, w = s + v * dt, v + a * dt, th + w * dt, w + alpha * dt
        position[:, k], tilt[:, k] = (s, v, a), (th, w, alpha)
    return position, tilt


@pytest.fixture
def make_run() -> MakeRun:
    """See the class."""

    def build(
        steps: int = 400,
        *,
        dofs: tuple[str, ...] = ("surge-pitch",),
        amplitude: float = 1.0,
        seed: int = 1,
        **fields: Any,
    ) -> Run:
        rng = np.random.default_rng(seed)
        n, dt = steps * EVERY, PERIOD / EVERY
        t = dt * np.arange(1, n + 1, dtype=float)
        reference = np.zeros((n, 3))
        pose, twist, acceleration = np.zeros((n, 6)), np.zeros((n, 6)), np.zeros((n, 6))
        for name in (one for one in dofs if DOFS[one].is_pair):
            pair = DOFS[name]
            want = amplitude * np.sin(2 * np.pi * 0.2 * t + pair.translation) + amplitude * (
                (t > 1) & (t < 4)
            )
            reference[:, pair.translation] = want
            position, tilt = _motion(want, t, dt)
            for series, line, turn in zip((pose, twist, acceleration), position, tilt, strict=True):
                series[:, pair.translation], series[:, pair.rotation] = line, pair.sign * turn
        values: dict[str, Any] = {
            "scenario": "step-sine-1",
            "cueing": "hybrid-all",
            "plant": "ideal",
            "platform": load("thesis"),
            "dofs": dofs,
            "settings": {"horizon": 50, "weights": {"preset": "thesis-fit"}},
            "period": PERIOD,
            "plant_period": dt,
            "time": t,
            "reference_force": reference,
            "reference_rate": np.zeros((n, 3)),
            "felt_force": specific_force(acceleration[:, :3], pose[:, 3:]),
            "pose": pose,
            "twist": twist,
            "acceleration": acceleration,
            "command_time": PERIOD * np.arange(steps),
            "command": acceleration[::EVERY],
            "status": ("decided",) * steps,
            "solver": ("optimal",) * steps,
            "changes": rng.poisson(1.5 * rng.gamma(1.0, 1.0, steps)),
            "residual": np.full(steps, 1e-12),
            "guess_missed": np.zeros(steps, dtype=np.bool_),
            "step_time": 1e-6 * rng.lognormal(5.0, 0.4, steps),
        }
        return Run(**(values | fields))

    return build


@pytest.fixture
def light(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave plotly's megabyte out where a test does not need it."""
    real = page.asset
    monkeypatch.setattr(
        page, "asset", lambda name: "/* plotly */" if name.startswith("plotly") else real(name)
    )
