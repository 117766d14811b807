"""First inputs of the structured engine against daqp at tight tolerance, on recorded problems, hard and soft.

Soft: all rows on tilt, position and braking at a penalty of 100 (eq. 6.2). Every second problem of the
benchmark's recordings is replayed. Run: python benchmarks/agreement.py
"""

from functools import partial

import numpy as np

from otolith.bench import SCENARIOS, record, replay
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import load
from otolith.qp.dense import DenseSolver
from otolith.qp.engines import CondensedEngine, StructuredEngine

SOFT = dict.fromkeys(("tilt_rate", "tilt", "position", "braking_position", "braking_tilt", "circle"), 100.0)
FORMS = {"hard": {}, "soft": SOFT}

if __name__ == "__main__":
    for pairs in ((SURGE_PITCH,), (SURGE_PITCH, SWAY_ROLL)):
        for form, soft in FORMS.items():
            cueing, steps = record(load("thesis"), pairs, SCENARIOS, MpcSettings(soft=soft))
            steps = steps[::2]
            ours = replay("structured", StructuredEngine, cueing, steps, passes=1)
            exact = partial(CondensedEngine, dense=partial(DenseSolver, primal_tolerance=1e-11))
            theirs = replay("dense", exact, cueing, steps, passes=1)
            both = ours.certified & theirs.certified
            gap = np.abs(ours.first - theirs.first)[both].max(axis=1)
            print(
                f"{2 * len(pairs)} DOF {form}, {len(steps)} problems: ours certifies {ours.certified.sum()},"
                f" daqp {theirs.certified.sum()}; first inputs differ by {gap.max():.1e} at most,"
                f" residual {ours.residual.max():.1e}",
                flush=True,
            )
