"""Motion platforms: limits and thresholds from a file, and the platforms that are shipped.

Modules that read or make a platform are imported on first use, so listing names needs neither pydantic nor
numba.
"""

from typing import TYPE_CHECKING

from otolith.core.lazy import on_first_use
from otolith.platforms.library import catalog, load

if TYPE_CHECKING:
    from otolith.platforms.axes import AxisLimits
    from otolith.platforms.platform import Braking, Platform, parse_platform
else:
    __getattr__ = on_first_use(
        __name__,
        {"AxisLimits": "axes", **dict.fromkeys(("Braking", "Platform", "parse_platform"), "platform")},
    )

__all__ = ["AxisLimits", "Braking", "Platform", "catalog", "load", "parse_platform"]
