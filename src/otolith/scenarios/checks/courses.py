"""Two witnesses of the course over ground that contradict each other prove nothing."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.scenarios.channels import Channel
from otolith.scenarios.checks.remedies import spelled
from otolith.scenarios.checks.witnesses import witnesses

SPAN: Final = 2.0  # [s] over which turning is compared
TURNS: Final = 0.05  # [rad] rms in that time: less tells nothing
AGAINST: Final = -0.7  # correlation at which they surely turn the other way


def refuse_contradicting(channels: Mapping[str, Channel], source: str) -> None:
    """Refuse latitude and longitude that turn against a compass heading.

    One of them is written the other way round, such as a longitude that counts west as positive; believing
    it would mirror the drive.
    """
    sure = [witness for witness in witnesses(channels) if witness.absolute]
    placed = next((witness for witness in sure if witness.keys == ("lat", "lon")), None)
    compass = next((witness for witness in sure if witness.keys == ("heading",)), None)
    if placed is None or compass is None:
        return
    one, other = placed.course, compass.course
    t = np.arange(max(one.t[0], other.t[0]), min(one.t[-1], other.t[-1]) - SPAN, 0.5 * SPAN)
    t = t[one.known(t) & one.known(t + SPAN) & other.known(t) & other.known(t + SPAN)]
    a, b = one.on(t + SPAN) - one.on(t), other.on(t + SPAN) - other.on(t)
    size = float(np.sqrt(np.mean(a**2) * np.mean(b**2))) if len(t) else 0.0
    if size < TURNS**2 or float(np.mean(a * b)) > AGAINST * size:
        return
    ways = f"map lon={spelled(channels['lon'].column, -1.0)} if it counts the other way, or"
    raise InputError(
        f"{compass.name} in {source}",
        f"against latitude and longitude (correlation {float(np.mean(a * b)) / size:.2f})",
        f"turning the same way ({ways} leave out what is wrong with heading=none or lat=none)",
    )
