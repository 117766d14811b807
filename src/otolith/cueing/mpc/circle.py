"""The circle within which surge and sway of a platform stay together (section 4.2)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.mpc.motion import ACCELERATION, POSITION, VELOCITY, first_states
from otolith.cueing.mpc.rows import circle_weights
from otolith.cueing.mpc.settings import MpcSettings
from otolith.platforms import Platform
from otolith.safety.invariant.axis import AxisSet


@dataclass(frozen=True, slots=True)
class Circle:
    """The circle within which surge and sway stay together (section 4.2)."""

    radius: float  # [m]
    weights: Vec  # (3,) of velocity, position and acceleration in the quantity that is limited
    states: Ints  # (2, 3) indices in x of these states of surge and of sway

    def distance(self, X: Mat) -> Mat:
        """Return the distances (n, 1) [m] from the centre in motions X (n, nx)."""
        distance: Mat = np.linalg.norm(X[:, self.states] @ self.weights, axis=1, keepdims=True)
        return distance


def circle_of(
    platform: Platform, dofs: Sequence[Dof], sets: Sequence[tuple[AxisSet, ...]], settings: MpcSettings
) -> Circle | None:
    """Return the limit circle of surge and sway if the platform has one and both are cued."""
    pairs = (SURGE_PITCH, SWAY_ROLL)
    if platform.circle is None or not set(pairs) <= set(dofs):
        return None
    leads = settings.braking.leads
    weights = circle_weights(sets[dofs.index(SURGE_PITCH)][0]) if leads else np.array([0.0, 1.0, 0.0])
    first = first_states(dofs)
    begin = [first[dofs.index(dof)] for dof in pairs]
    return Circle(platform.circle, weights, np.add.outer(begin, [VELOCITY, POSITION, ACCELERATION]))
