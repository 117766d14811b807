"""What a session has to know of a device, and what it assumes of one that reports nothing."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from otolith.core.arrays import Vec
from otolith.live.core.session import POWERED
from otolith.live.messages import DeviceState, State

MS: Final = 1_000_000  # [ns]
ASSUMED: Final = 500 * MS  # that a device without replies takes to start, and to park


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """What the session has to know of a device."""

    park: Vec  # (6,) [m, rad] where it rests without power
    rate_hz: float = 60.0  # packets per second
    on_silence: Literal["holds", "parks", "falls"] = "parks"
    reports: bool = True  # False: it is driven in open loop, from and to the park pose that is declared
    engages_ns: int = 20_000 * MS  # time it may take to engage, or to park
    band: Vec  # (6,) [m, rad] by which the measured pose may differ from the set-point at rest …
    lag_s: float = 0.1  # … and this time of travel more in motion

    @classmethod
    def at(cls, park: Vec, **others: float | str | int) -> "Device":
        """Return a device with a band of 10 mm and 0.6 deg."""
        band = np.array([10e-3] * 3 + [np.radians(0.6)] * 3)
        return cls(park=np.asarray(park, dtype=np.float64), band=band, **others)  # type: ignore[arg-type]


def assumed(state: State, since_ns: int, rests_ns: int | None) -> DeviceState:
    """Return what is assumed of a device in open loop: it does what it is told, within `ASSUMED`.

    Parameters
    ----------
    state : of the session, for `since_ns` [ns].
    rests_ns : [ns] since a move has ended; None while it lasts, and without one.
    """
    if state is State.ENGAGING:
        return DeviceState.ENGAGED if since_ns > ASSUMED else DeviceState.IDLE
    if state is State.PARKING and rests_ns is not None:
        return DeviceState.IDLE if rests_ns > ASSUMED else DeviceState.ENGAGED
    return DeviceState.ENGAGED if state in POWERED else DeviceState.IDLE
