"""Exported C against Python, decision by decision.

    PYTHONPATH=. python benchmarks/export_equal.py [--strict] [DECISIONS [CUEING ...]]

Each algorithm drives the plant that it assumes, in Python, along sums of sines with new phases in every run;
the exported program is given what each decision saw. Reported: the largest difference of a command [m/s² or
rad/s²], the shares of decisions that differ by more than 1e-9 and 1e-6, and statuses that differ. With
`--strict` sums are fused in neither; kernels are then compiled anew, so NUMBA_CACHE_DIR and OTOLITH_CACHE
must name empty folders.
"""

import os
import sys
import tempfile
from pathlib import Path

PER_RUN = 2000  # decisions, after which both start anew
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
}


def compare(label: str, decisions: int, flags: list[str]) -> str:
    """Return a line about one algorithm."""
    import numpy as np
    from tests.export.in_c import Stepper

    from otolith import files
    from otolith.core.frames import dofs_named
    from otolith.cueing.design import Design
    from otolith.export.make import Kind, program_of
    from otolith.export.vectors import drive, vectors

    cueing = label.split()[0]
    platform = "davsi" if "heave" in CASES[label] else "thesis"
    design = Design(platform=files.read_platform(platform), dofs=dofs_named(CASES[label].split(",")))
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


def main() -> None:
    words = [word for word in sys.argv[1:] if word != "--strict"]
    strict = "--strict" in sys.argv
    if strict and not {"NUMBA_CACHE_DIR", "OTOLITH_CACHE"} <= os.environ.keys():
        sys.exit("--strict needs NUMBA_CACHE_DIR and OTOLITH_CACHE, which name empty folders")
    if strict:
        from otolith.core import jit, lanes

        jit._FREEDOMS.clear()
        lanes._FREEDOMS = ()  # type: ignore[misc,assignment]
    decisions = int(words[0]) if words else 100_000
    for label in words[1:] or CASES:
        print(compare(label, decisions, ["-O2", "-ffp-contract=off"] if strict else ["-O3"]), flush=True)


if __name__ == "__main__":
    main()
