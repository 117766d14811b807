"""The explicit problem of any set of axes as one mpQP, and its law, found part by part.

The joint problem is assembled as it stands, block by block; that it falls apart is then found from
its data (`otolith.mpqp.separate`), not assumed.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.linalg import block_diag

from otolith.core.errors import InputError, one_of
from otolith.core.frames import PAIRS
from otolith.mpc.design import explicit_limits
from otolith.mpc.explicit import ExplicitSettings, explicit_problem
from otolith.mpc.single_axis import SINGLE_AXES, axis_problem
from otolith.mpqp import ParametricQp, Progress
from otolith.mpqp.separable import JointLaw, enumerate_parts
from otolith.platforms import Platform


def problems(platform: Platform, dofs: Sequence[str], settings: ExplicitSettings) -> list[ParametricQp]:
    """One explicit problem for each of `dofs`: names of axis pairs, "heave" or "yaw"."""
    known = [*PAIRS, *SINGLE_AXES]
    for name in dofs:
        if name not in known:
            raise InputError("--dofs", repr(name), one_of(known, name, otherwise=", or several with commas"))
    pairs = tuple(PAIRS[name] for name in dofs if name in PAIRS)
    limits = dict(zip(pairs, explicit_limits(platform, pairs), strict=True))
    return [
        explicit_problem(limits[PAIRS[name]], platform.braking, settings)
        if name in PAIRS
        else axis_problem(platform, name, settings)
        for name in dofs
    ]


def joint_problem(parts: Sequence[ParametricQp]) -> ParametricQp:
    """Several problems beside each other as one."""
    blocks = {name: block_diag(*[getattr(part, name) for part in parts]) for name in ("H", "F", "G", "S")}
    vectors = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in ("f", "w", "lower", "upper")
    }
    return ParametricQp(**blocks, **vectors)


def joint_law(
    platform: Platform,
    dofs: Sequence[str],
    settings: ExplicitSettings,
    *,
    tolerance: float = 1e-7,
    progress: Callable[[Progress], None] | None = None,
) -> JointLaw:
    """Enumerate the explicit law of a set of axes."""
    whole = joint_problem(problems(platform, dofs, settings))
    return enumerate_parts(whole, tolerance=tolerance, progress=progress)
