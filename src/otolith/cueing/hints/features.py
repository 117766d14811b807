"""The input of a hint: fifteen numbers per axis pair that show which limits are near.

Notation: x = [ω θ v s a α] of one pair (α the tilt acceleration), r the wanted force, g gravity:

    ω θ v s a α, r, r − a − g sin θ, r − g sin θ, the two braking rows (eq. C.2), s + v/2, v + a/2, |ω|, |s|.

All except the last two change sign with the motion, so a mirrored motion has mirrored features.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.frames import GRAVITY, Dof
from otolith.core.jit import kernel
from otolith.cueing.mpc.rows import BrakingRows, braking_rows
from otolith.platforms import Platform

FEATURES: Final = 15  # number per pair
_EVEN: Final = 2  # number of even features, which are the last
TILT_RATE, TILT, VELOCITY, POSITION, ACCELERATION = range(5)  # as in otolith.cueing.mpc.rows


def braking_forms(platform: Platform, pairs: Sequence[Dof]) -> Mat:
    """Return the two braking rows of every pair as linear forms of its states (P, 2, 6), imposed or not."""
    rows = [
        braking_rows(pair, platform.limits(pair), platform.braking, BrakingRows.POSITION) for pair in pairs
    ]
    return np.array([[row.coefficients for row in of_pair] for of_pair in rows])


def mirror_signs(pairs: int) -> Vec:
    """Return the factors of the features when the motion is mirrored (15P,)."""
    of_pair = np.ones(FEATURES)
    of_pair[:-_EVEN] = -1.0
    return np.tile(of_pair, pairs)


@kernel
def describe(x: Vec, wanted: Vec, braking: Mat, features: Vec) -> None:
    """Write the features (15P,) of states (6P,) and wanted forces (P,)."""
    for p in range(len(wanted)):
        s, f, r = 6 * p, 15 * p, wanted[p]
        gravity = GRAVITY * math.sin(x[s + TILT])
        for i in range(6):
            features[f + i] = x[s + i]
        features[f + 6] = r
        features[f + 7] = r - x[s + ACCELERATION] - gravity
        features[f + 8] = r - gravity
        for row in range(2):
            features[f + 9 + row] = 0.0
            for i in range(6):
                features[f + 9 + row] += braking[p, row, i] * x[s + i]
        features[f + 11] = x[s + POSITION] + 0.5 * x[s + VELOCITY]
        features[f + 12] = x[s + VELOCITY] + 0.5 * x[s + ACCELERATION]
        features[f + 13] = abs(x[s + TILT_RATE])
        features[f + 14] = abs(x[s + POSITION])


@kernel
def describe_all(x: Mat, wanted: Mat, braking: Mat, features: Mat) -> None:
    """Write the features (n, 15P) of states (n, 6P) and wanted forces (n, P), row by row as `describe`."""
    for i in range(len(x)):
        describe(x[i], wanted[i], braking, features[i])
