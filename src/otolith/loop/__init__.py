"""The closed loop: a cueing algorithm drives a plant along a scenario, and a `Run` records it."""

from otolith.loop.keep import Keeper
from otolith.loop.run import Run
from otolith.loop.simulate import EDGE, ClosedLoop, simulate

__all__ = ["EDGE", "ClosedLoop", "Keeper", "Run", "simulate"]
