"""Heave and yaw beside the axis pairs: six degrees of freedom of an algorithm that cues pairs only.

Nothing couples heave and yaw to the pairs but what the driver's own turning adds, which is small of the
second order. So whatever cues the pairs, each of the two is a certified problem of its own: the
decoupled sub-problem of `otolith.mpc.linear`, with the horizon, lag, washout and engine of the implicit
MPC, tracking the physical force and rate as that one does.
"""

from collections.abc import Callable
from dataclasses import replace

from otolith.interfaces import Cueing
from otolith.mpc.design import Design
from otolith.mpc.linear import single_axes
from otolith.mpc.several import Beside


def with_singles(make: Callable[[Design], Cueing], design: Design) -> Cueing:
    """What `make` makes of the pairs of a design, and beside it the design's heave and yaw."""
    if not design.singles:
        return make(design)
    singles = single_axes(design)
    return Beside([make(replace(design, singles=())), singles]) if design.pairs else singles
