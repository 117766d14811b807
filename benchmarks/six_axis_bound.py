"""What anything could reach on the drives of `six_axis.py table`: offline optima within limits per axis.

    python benchmarks/six_axis_bound.py [step-2] [sine-1] [lap120]

The legs of `davsi` allow a part of what its limits per axis allow, which `six-axis` keeps, too. So the
optimum within these limits, which knows the whole drive and has no washout, bounds what any controller can do
with the legs. What nobody can know is a step before it comes: beside the optimum of the whole drive stands
that of a platform that rests until then. Both with the tilt rates of the file, and with twice as much.
"""

import argparse
import tempfile
from pathlib import Path
from typing import Final

import numpy as np
from threadpoolctl import threadpool_limits

from otolith.cueing.optimum import optimum
from otolith.platforms import Platform
from otolith.scenarios import Scenario
from six_axis import BOX, CASES, DAVSI, FOUR, wanted_of

ONSET: Final = {"step-2": 1.0}  # [s] when what nobody can know begins


def tilting(platform: Platform, factor: float) -> Platform:
    """The platform with other tilt rates."""
    limits = platform.tilt_coordination
    changed = {name: factor * getattr(limits, name) for name in type(limits).model_fields}
    return platform.model_copy(update={"tilt_coordination": limits.model_copy(update=changed)})


def norm(platform: Platform, wanted: Scenario, onset: float) -> tuple[float, float]:
    """Norm of the RMSE along x and y of the best motion that rests until `onset` [s], and its certificate."""
    best = optimum(platform, FOUR, wanted.part(onset, wanted.duration) if onset else wanted)
    error = (best.run.felt_force - best.run.reference_force)[:, :2]
    squares = np.sum(np.mean(error**2, axis=0)) * (wanted.duration - onset) / wanted.duration
    return float(np.sqrt(squares)), best.certificate.worst


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("cases", nargs="*", choices=[*CASES, []])
    chosen = parser.parse_args().cases or list(CASES)
    with tempfile.TemporaryDirectory() as folder, threadpool_limits(limits=1):
        for case in chosen:
            wanted = wanted_of(case, Path(folder))
            for onset in dict.fromkeys([0.0, ONSET.get(case, 0.0)]):
                for factor in (1.0, 2.0):
                    (box, one), (axes, other) = (
                        norm(tilting(platform, factor), wanted, onset) for platform in (BOX, DAVSI)
                    )
                    print(
                        f"{case:7} {'all known' if not onset else f'at rest until {onset:g} s':20} "
                        f"tilt rate x {factor:g}: box {box:.4f}, axes of davsi {axes:.4f} m/s2, "
                        f"ratio {axes / box:.3f}; certificates up to {max(one, other):.0e}",
                        flush=True,
                    )


if __name__ == "__main__":
    main()
