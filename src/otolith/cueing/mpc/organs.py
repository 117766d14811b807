"""The vestibular organs of the channels that an MPC tracks, as its kernels take them."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from otolith.core.lti import StateSpace
from otolith.cueing.mpc import kernels
from otolith.cueing.mpc.objective import Channel, Organ


def organs_of(felt: Sequence[Channel], period: float) -> kernels.Organs:
    """Return the organs of all channels in a row; that of a physical channel passes its input on."""
    nothing = StateSpace.gain(np.eye(1))
    organs = [Organ.of(nothing if channel.organ is None else channel.organ, period) for channel in felt]
    first = np.cumsum([0, *(len(organ.A) for organ in organs)])
    flat = {
        name: np.concatenate([getattr(organ, name) for organ in organs]) for name in ("B", "B0", "B1", "C")
    }
    return kernels.Organs(
        first=first,
        A=block_diag(*(organ.A for organ in organs)),
        **flat,
        D=np.array([organ.D for organ in organs]),
        here=np.zeros(first[-1]),
        there=np.zeros(first[-1]),
        felt_here=np.zeros(len(felt)),
        felt_there=np.zeros(len(felt)),
    )
