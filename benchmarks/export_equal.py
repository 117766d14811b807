"""Exported C against Python, decision by decision.

    PYTHONPATH=. python benchmarks/export_equal.py [--strict | --given-up] [DECISIONS [CUEING ...]]

Each algorithm drives the plant that it assumes, in Python, along sums of sines with new phases in every run;
the exported program is given what each decision saw. Reported: the largest difference of a command [m/s² or
rad/s²], the shares of decisions that differ by more than 1e-9 and 1e-6, and statuses that differ. With
`--strict` sums are fused in neither; kernels are then compiled anew, so NUMBA_CACHE_DIR and OTOLITH_CACHE
must name empty folders.

With `--given-up` Python decides from random motions, a quarter each of 0.3, 0.6, 1.0 and 1.3 times what the
limits allow. Reported: how many problems the structured engine gave up (a program has no second engine), and
how the decisions ended.
"""

import os
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from otolith.cueing.design import Design

PER_RUN = 2000  # decisions, after which both start anew
SIZES = (0.3, 0.6, 1.0, 1.3)  # of random motions, as shares of what the limits allow
CASES = {
    "classical": "surge-pitch,sway-roll,heave,yaw",
    "adaptive": "surge-pitch,sway-roll,heave,yaw",
    "optimal": "surge-pitch,sway-roll,heave,yaw",
    "optimal-nonlinear": "surge-pitch,sway-roll,heave,yaw",
    "implicit": "surge-pitch",
    "predictive": "surge-pitch",
    "implicit 4 DOF": "surge-pitch,sway-roll",
    "predictive 4 DOF": "surge-pitch,sway-roll",
    "linear-mpc": "surge-pitch,sway-roll",
    "implicit-sensed": "surge-pitch",
    "six-axis": "surge-pitch,sway-roll,heave,yaw",
}


def compare(label: str, decisions: int, flags: list[str]) -> str:
    """Return a line about one algorithm."""
    import numpy as np
    from tests.export.in_c import Stepper

    from otolith.export.make import Kind, program_of
    from otolith.export.vectors import drive, vectors

    cueing = label.split()[0]
    design = _design(label)
    program = program_of(design, cueing, "compared", Kind.COMMAND)
    off, statuses, fallbacks = [], 0, 0
    with tempfile.TemporaryDirectory() as folder:
        stepper = Stepper(program, Path(folder), *flags)
        for seed in range(max(1, decisions // PER_RUN)):
            checks = vectors(design, cueing, Kind.COMMAND, drive(PER_RUN * program.period, seed))
            stepper.begin()
            status, out = stepper.run(checks.inputs)
            off.append(np.abs(out[:, :6] - checks.outputs[:, :6]).max(axis=1))
            statuses += int(np.count_nonzero(status != checks.outputs[:, 6]))
            fallbacks += int(np.count_nonzero(checks.outputs[:, 6]))
    worst = np.concatenate(off)
    return (
        f"{label:18} {len(worst):7,} decisions: largest {worst.max():.1e}, beyond 1e-9 "
        f"{np.mean(worst > 1e-9):.4%}, beyond 1e-6 {np.mean(worst > 1e-6):.4%}, other status {statuses}, "
        f"fallbacks in Python {fallbacks}"
    )


def _design(label: str) -> "Design":
    """Return the design of a case."""
    from otolith import files
    from otolith.core.frames import dofs_named
    from otolith.cueing.design import Design

    platform = "davsi" if "heave" in CASES[label] else "thesis"
    return Design(platform=files.read_platform(platform), dofs=dofs_named(CASES[label].split(",")))


def given_up(label: str, motions: int) -> str:
    """Return a line about the problems of random motions that the engines of one algorithm gave up."""
    import numpy as np

    from otolith import registry
    from otolith.cueing.design import mpcs_of
    from otolith.interfaces import PlatformState, Reference

    design, random = _design(label), np.random.default_rng(5)
    algorithm = registry.make_cueing(label.split()[0], design)
    ended: Counter[str] = Counter()
    for k in range(motions):
        motion, size = np.zeros((3, 6)), SIZES[4 * k // motions]
        for dof in design.dofs:
            for axis, sign, limits in zip(dof.axes, dof.signs, design.platform.limits(dof), strict=True):
                low, high = sorted(sign * bound for bound in limits.position)
                most = (0.5 * (high - low), limits.velocity, min(limits.acceleration, limits.command))
                shares = size * random.uniform(-1.0, 1.0, 3)
                motion[:, axis] = shares * np.minimum(most, (np.inf, 10.0, 6.0 if axis < 3 else 1.0))
                motion[0, axis] += 0.5 * (low + high)
        force, rate = random.uniform(-6.0, 6.0, 3), random.uniform(-1.0, 1.0, 3)
        command = algorithm.step(
            PlatformState.of_motion(motion, None), Reference(specific_force=force, angular_rate=rate)
        )
        ended[f"{command.outcome.status} {command.outcome.solver}"] += 1
    lost = sum(getattr(mpc.engine, "undecided", 0) for mpc in mpcs_of(algorithm))
    return f"{label:18} {motions:7,} motions: {lost} given up; {dict(ended)}"


def main() -> None:
    words = [word for word in sys.argv[1:] if not word.startswith("--")]
    strict = "--strict" in sys.argv
    if strict and not {"NUMBA_CACHE_DIR", "OTOLITH_CACHE"} <= os.environ.keys():
        sys.exit("--strict needs NUMBA_CACHE_DIR and OTOLITH_CACHE, which name empty folders")
    if strict:
        from otolith.core import jit, lanes

        jit._FREEDOMS.clear()
        lanes._FREEDOMS = ()  # type: ignore[misc,assignment]
    decisions = int(words[0]) if words else 100_000
    for label in words[1:] or CASES:
        if "--given-up" in sys.argv:
            print(given_up(label, decisions), flush=True)
            continue
        print(compare(label, decisions, ["-O2", "-ffp-contract=off"] if strict else ["-O3"]), flush=True)


if __name__ == "__main__":
    main()
