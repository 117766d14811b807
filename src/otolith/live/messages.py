"""The values that pass between the parts of live operation: what comes in, what goes out, and the states.

SI units and radians, axes x forward, y left, z up. Times are integer nanoseconds of the monotonic clock,
unless the name says that they are the sender's.
"""

from dataclasses import dataclass
from enum import IntFlag, StrEnum

from otolith.core.arrays import Vec, freeze


class Flag(IntFlag):
    """What a source says about its own state: the flag word of the generic packet."""

    RUNNING = 1
    PAUSED = 2
    REPLAY = 4
    TELEPORTED = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Telemetry:
    """One sample of a source, as its packet states it: decoded into numbers, in the source's own axes.

    A field is None where the source does not send it. Numbers are passed on as received: whether they are
    finite and plausible is judged in `otolith.live.core.health`.
    """

    sequence: int | None = None  # counts the packets of the source
    sender_ns: int | None = None  # [ns] of the sender's own clock
    flags: Flag | None = None
    acceleration: Vec | None = None  # (3,) [m/s²]
    angular_rate: Vec | None = None  # (3,) [rad/s]
    attitude: Vec | None = None  # (4,) unit quaternion w, x, y, z, from the body to the world
    velocity: Vec | None = None  # (3,) [m/s]
    position: Vec | None = None  # (3,) [m]
    speed: float | None = None  # [m/s]
    source_id: int = 0

    def __post_init__(self) -> None:
        shapes: dict[str, tuple[int, ...]] = {
            "acceleration": (3,),
            "angular_rate": (3,),
            "attitude": (4,),
            "velocity": (3,),
            "position": (3,),
        }
        freeze(self, **{name: shape for name, shape in shapes.items() if getattr(self, name) is not None})


class State(StrEnum):
    """States of the session, which belong to the process that talks to the device."""

    IDLE = "idle"
    CHECKING = "checking"
    ENGAGING = "engaging"
    READY = "ready"
    ENGAGED = "engaged"
    HOLDING = "holding"
    RETURNING = "returning"
    PARKING = "parking"
    PARKED = "parked"
    FAULT = "fault"


class DeviceState(StrEnum):
    """States of a device, in the words that all devices share."""

    OFF = "off"
    IDLE = "idle"
    STANDBY = "standby"
    ENGAGED = "engaged"
    PARKING = "parking"
    FAULT = "fault"
    UNKNOWN = "unknown"


class Word(StrEnum):
    """Words of the operator."""

    ARM = "arm"
    ENGAGE = "engage"
    RETURN = "return"
    STOP = "stop"
    PARK = "park"
    REARM = "rearm"


@dataclass(frozen=True, slots=True, kw_only=True)
class SetPoint:
    """Where the platform should be at one time; six-vectors as in `otolith.interfaces.PlatformState`."""

    sequence: int
    time_ns: int  # [ns] monotonic
    pose: Vec  # (6,) [m ×3, rad ×3]
    twist: Vec  # (6,) [m/s ×3, rad/s ×3]
    acceleration: Vec  # (6,) [m/s² ×3, rad/s² ×3]
    state: State
    token: int  # names the session, so that a device can refuse a second sender

    def __post_init__(self) -> None:
        freeze(self, pose=(6,), twist=(6,), acceleration=(6,))


@dataclass(frozen=True, slots=True, kw_only=True)
class Feedback:
    """What a device reports about itself."""

    pose: Vec | None = None  # (6,) [m ×3, rad ×3] measured
    state: DeviceState = DeviceState.UNKNOWN
    faults: tuple[str, ...] = ()  # in the device's own words
    sequence: int | None = None

    def __post_init__(self) -> None:
        if self.pose is not None:
            freeze(self, pose=(6,))
