"""The values that pass between the parts of live operation: what comes in, what goes out, and the states.

SI units and radians, axes x forward, y left, z up. Times are integer nanoseconds of the monotonic clock,
unless the name says that they are the sender's.
"""

from dataclasses import dataclass
from enum import IntEnum, IntFlag, StrEnum

from otolith.core.arrays import Mat, Vec, freeze, frozen_array
from otolith.live.core.parameters import Parameters


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
    token: int | None = None  # of the session that the device follows; None where it does not say

    def __post_init__(self) -> None:
        if self.pose is not None:
            freeze(self, pose=(6,))


class Rung(IntEnum):
    """How strong a reaction is; a higher one includes the lower ones."""

    NONE = 0
    HOLD = 1  # R1: the last reference is held, then decays
    FADE = 2  # R2: the reference fades to zero
    RETURN = 3  # R3: brake to rest, then return to neutral; left by the operator's word only
    FAULT = 4  # R4: set-points end, so that the device's own watchdog acts; left by the operator's word only


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """What the controller wants of the output: commanded accelerations by time, and a reaction to faults."""

    sequence: int
    generation: int  # of the engagement it was decided for; any other is refused
    time_ns: int  # [ns] from which the first stage counts
    period_ns: int  # [ns] of one stage
    stages: Mat  # (K, 6) [m/s² ×3, rad/s² ×3] commanded accelerations; they end at rest; K = 0: only alive
    rung: Rung = Rung.NONE
    reason: str = ""  # of the rung
    healthy: bool = False  # telemetry has been good long enough to be cued
    telemetry_ns: int = 0  # [ns] arrival of the packet that the plan answers
    outcome: str = ""  # status of the decision, for the log
    residual: float = 0.0

    def __post_init__(self) -> None:
        stages = frozen_array(self.stages)
        if stages.ndim != 2 or stages.shape[1] != 6:
            raise ValueError(f"stages have shape {stages.shape}, expected (K, 6)")
        object.__setattr__(self, "stages", stages)

    def command(self, now_ns: int) -> Vec | None:
        """Return the stage (6,) that counts at a time; None before the first and after the last."""
        k = (now_ns - self.time_ns) // self.period_ns
        return self.stages[k] if 0 <= k < len(self.stages) else None


@dataclass(frozen=True, slots=True, kw_only=True)
class Vitals:
    """What the controller shows to whoever looks on; nothing is decided by it."""

    time_ns: int
    asked: Vec  # (3,) [m/s²] force that the last decision should let feel; NaN without one
    missed: int  # periods in which a decision was not ready, since the session began
    clock_ns: int | None  # [ns] our clock less the sender's as the newest packet came; None without a clock
    parameters: Parameters  # that are asked for

    def __post_init__(self) -> None:
        freeze(self, asked=(3,))


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """What the output tells the controller: where the set-points are, and what is done with its plans."""

    time_ns: int
    motion: Mat  # (3, 6) pose, twist, acceleration of the set-points
    state: State
    generation: int  # of the current engagement
    follows: int = -1  # sequence of the plan that is followed; −1: none, the output decides itself
    measured: Vec | None = None  # (6,) [m ×3, rad ×3] where the device says that it is

    def __post_init__(self) -> None:
        freeze(self, motion=(3, 6))
        if self.measured is not None:
            freeze(self, measured=(6,))
