"""Runs of noise, the same on every computer, whose summaries are stored in `data/summaries.json`."""

from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Mat
from otolith.loop import Run
from otolith.platforms import load
from otolith.safety.supervisor import Intervention, Reason

SAMPLES, DECISIONS = 600, 60


def _smooth(rng: np.random.Generator, columns: int, scale: float) -> Mat:
    """Sums of five sines of random size and phase, (SAMPLES, columns)."""
    t = np.arange(1, SAMPLES + 1)[:, None, None] / SAMPLES
    size, phase = rng.normal(size=(columns, 5)), rng.uniform(0.0, 2.0 * np.pi, (columns, 5))
    waves: Mat = scale * np.sum(size * np.sin(2.0 * np.pi * np.arange(1, 6) * t + phase), axis=2)
    return waves


def noisy(platform: str, dofs: tuple[str, ...], *, seed: int) -> Run:
    """A run that misleads, passes limits, fails at times and is held back by a supervisor."""
    rng = np.random.default_rng(seed)
    kinds = ("decided", "decided", "decided", "fallback", "refused", "invalid")
    status = tuple(kinds[k] for k in rng.integers(0, len(kinds), DECISIONS))
    failed = np.array([one != "decided" for one in status])
    acceleration = _smooth(rng, 6, 0.8)
    return Run(
        scenario="noise",
        cueing="nobody",
        plant="none",
        platform=load(platform),
        dofs=dofs,
        settings={"scale": 1.0, "weights": {"preset": "none"}},
        soft=("surge-pitch tilt_rate", "heave velocity"),
        period=0.1,
        plant_period=0.01,
        time=np.arange(1, SAMPLES + 1, dtype=float) * 0.01,
        reference_force=_smooth(rng, 3, 0.4),
        reference_rate=_smooth(rng, 3, 0.1),
        felt_force=_smooth(rng, 3, 0.4),
        pose=_smooth(rng, 6, 0.12),
        twist=_smooth(rng, 6, 0.1),
        acceleration=acceleration,
        command_time=np.arange(DECISIONS, dtype=float) * 0.1,
        command=acceleration[::10],
        status=status,
        solver=tuple("infeasible" if one == "fallback" else "" for one in status),
        changes=rng.poisson(3.0, DECISIONS),
        residual=np.where(failed, np.inf, rng.uniform(0.0, 1e-9, DECISIONS)),
        guess_missed=rng.uniform(size=DECISIONS) < 0.1,
        step_time=1e-6 * rng.uniform(50.0, 500.0, DECISIONS),
        interventions=(
            Intervention(start=0.5, end=0.75, reason=Reason.SPEED, leg=2, behind=0.002),
            Intervention(start=1.5, end=2.0, reason=Reason.SPEED, leg=3, behind=0.004),
        ),
    )


_PAIRS: Final = noisy("thesis", ("surge-pitch", "sway-roll"), seed=1)
STORED: Final = {
    "surge and pitch alone": noisy("thesis", ("surge-pitch",), seed=2),
    "two pairs": _PAIRS,
    "six axes": noisy("davsi", ("surge-pitch", "sway-roll", "heave", "yaw"), seed=3),
    "yaw alone": noisy("davsi", ("yaw",), seed=4),
    "felt as wanted, no certificate": replace(
        _PAIRS, felt_force=_PAIRS.reference_force, residual=np.full(DECISIONS, np.nan), interventions=()
    ),
    "no motion, nothing wanted": replace(
        _PAIRS,
        reference_force=np.zeros((SAMPLES, 3)),
        felt_force=np.zeros((SAMPLES, 3)),
        pose=np.zeros((SAMPLES, 6)),
        twist=np.zeros((SAMPLES, 6)),
        acceleration=np.zeros((SAMPLES, 6)),
        status=("decided",) * DECISIONS,
        solver=("",) * DECISIONS,
        residual=np.zeros(DECISIONS),
    ),
}
COMPARED: Final = [
    replace(run, cueing=name) for name, run in zip(("implicit", "other"), STORED.values(), strict=False)
]
