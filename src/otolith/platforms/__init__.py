"""Motion platforms: limits and thresholds from a file, and the ones that are shipped."""

from otolith.platforms.library import catalog, load
from otolith.platforms.platform import AxisLimits, Braking, Platform, parse_platform

__all__ = ["AxisLimits", "Braking", "Platform", "catalog", "load", "parse_platform"]
