"""The two roles, Cueing and Plant, and the values that pass between them.

Everything that decides motion implements `Cueing`; everything that moves implements `Plant`. These protocols
are the whole contract between algorithms, simulator, real platforms and user interfaces. Six-vectors are
ordered surge, sway, heave [m], roll, pitch, yaw [rad]; see `otolith.core.frames`.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final, Protocol, Self

import numpy as np

from otolith.core.arrays import Mat, Vec, freeze, frozen_array


@dataclass(frozen=True, slots=True, kw_only=True)
class PlatformState:
    """State of the platform: its pose relative to the neutral pose, and the pose's derivatives.

    It is given in world; on a base that moves (`otolith.platforms.carriers`), in the frame of the base.
    """

    pose: Vec = field(default_factory=lambda: np.zeros(6))  # (6,) [m ×3, rad ×3]
    twist: Vec = field(default_factory=lambda: np.zeros(6))  # (6,) [m/s ×3, rad/s ×3]
    acceleration: Vec = field(default_factory=lambda: np.zeros(6))  # (6,) [m/s² ×3, rad/s² ×3]
    specific_force: Vec | None = None  # (3,) [m/s²] at the driver's head, where the plant senses it
    base: "PlatformState | None" = None  # of the base that carries the platform, if there is one, in world

    def __post_init__(self) -> None:
        freeze(self, pose=(6,), twist=(6,), acceleration=(6,))
        if self.specific_force is not None:
            freeze(self, specific_force=(3,))

    @classmethod
    def of_motion(cls, motion: Mat, force: Vec | None = None) -> Self:
        """Make a state from rows pose, twist and acceleration (3, 6) that a plant has computed.

        Rows (6, 6) are those of the platform, then those of its base. They are copied once and not checked
        again, since plants make thousands of states per second.
        """
        state, rows = object.__new__(cls), motion.copy()
        rows.setflags(write=False)
        felt = None if force is None else frozen_array(force)
        base = cls.of_motion(rows[3:]) if len(rows) > 3 else None
        for name, value in zip(cls.__slots__, (*rows[:3], felt, base), strict=True):
            object.__setattr__(state, name, value)
        return state

    def write(self, motion: Mat) -> None:
        """Write pose, twist and acceleration into rows (3, 6), and those of the base into the next three.

        Rows of a base that this state does not have become zero.
        """
        motion[0], motion[1], motion[2] = self.pose, self.twist, self.acceleration
        if len(motion) > 3:
            (self.base or _AT_REST).write(motion[3:])


_AT_REST: Final = PlatformState()


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """What the driver should feel, in the driver's frame: now and, if a preview is known, soon."""

    specific_force: Vec  # (3,) [m/s²], without the constant 1 g
    angular_rate: Vec = field(default_factory=lambda: np.zeros(3))  # (3,) [rad/s]
    preview: Mat | None = None  # (K, 3) [m/s²] forces foreseen for the ends of the next K periods
    age: float = 0.0  # [s] age of the reference relative to the state that comes with it

    def __post_init__(self) -> None:
        freeze(self, specific_force=(3,), angular_rate=(3,))


class Status(StrEnum):
    """Who decided a command: the algorithm itself, or the fallback, which brakes to rest, and why."""

    DECIDED = "decided"  # by the algorithm; certified where the algorithm solves a problem
    FALLBACK = "fallback"  # fallback: the algorithm found no answer that it can certify
    REFUSED = (
        "refused"  # fallback: the platform could not stop inside its limits after the algorithm's command
    )
    INVALID = "invalid"  # fallback: the state or the reference is not finite or not plausible


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How a command was obtained; the status says whether it is the algorithm's own."""

    status: Status
    solver: str = ""  # status of the solver, e.g. "infeasible"; empty where none was used
    changes: int = 0  # working-set changes of the active-set solver
    residual: float = 0.0  # largest violation of the optimality conditions (the certificate)
    guess_missed: bool = False  # a guess was requested but not available


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """Set-points for the next period, and what to do if no further command arrives."""

    acceleration: Vec  # (6,) [m/s² ×3, rad/s² ×3] commanded during the period
    pose: Vec  # (6,) predicted at the period's end
    twist: Vec  # (6,) predicted at the period's end
    plan: Vec  # (K, 6) commanded accelerations of the following periods; they end at rest
    outcome: Outcome
    base: "Command | None" = None  # of the base that carries the platform; None where it is left at rest

    def accelerations(self, carriers: int) -> Vec:
        """Return the accelerations (6·carriers,): those of the platform, then those of its base if 2."""
        if carriers == 1:
            return self.acceleration
        base = np.zeros(6) if self.base is None else self.base.acceleration
        return np.concatenate([self.acceleration, base])


class Predictor(Protocol):
    """Predicts what will be wanted in the coming periods, from what was wanted until now.

    It is causal by construction: it receives one reference after the other, once per period, and knows no
    more of the future than `Reference.preview` contains.
    """

    def reset(self) -> None:
        """Discard the past."""

    def ahead(self, reference: Reference, dt: float, n: int) -> Mat:
        """Return what will be wanted at the ends of the next n periods of dt [s].

        The rows (n, 6) are specific force [m/s²] and angular rate [rad/s] in the driver's frame. NaN is
        passed on unchanged, so that the algorithm sees it.
        """


class Cueing(Protocol):
    """Turns the desired vehicle motion into platform motion, once per period.

    An algorithm that may exceed a limit at a price lists it in an attribute `soft`, a set of names such as
    "surge-pitch tilt_rate". Without this attribute every limit counts as hard when a run is judged.
    """

    @property
    def period(self) -> float:
        """Time between two calls of `step` [s]; an MPC is discretised for exactly this one."""

    def reset(self, state: PlatformState) -> None:
        """Discard the past and start from `state`."""

    def step(self, state: PlatformState, reference: Reference) -> Command:
        """Decide one command. In trouble, return a safe command whose outcome gives the reason; never
        raise.
        """


class Plant(Protocol):
    """Moves as commanded: an ideal platform, one with actuators, a hexapod, or a real one."""

    @property
    def dead_time(self) -> float | None:
        """Time before a command takes effect [s], as the manufacturer states it.

        None where the plant moves exactly as the algorithms' models predict, so that its measured state can
        be used without correction.
        """

    def reset(self, state: PlatformState) -> None:
        """Place the platform in `state`."""

    def step(self, command: Command, dt: float) -> PlatformState:
        """Follow `command` for `dt` seconds and return the state reached."""
