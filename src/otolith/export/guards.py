"""What stands between set-points and drives as programs: the gate of live operation, and the supervisor.

They are the kernels that live operation and the plants in Python run. Neither knows the algorithm whose
commands or poses it is given; both begin at rest in the neutral pose.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final, NamedTuple

import numpy as np

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.core.jit import kernel
from otolith.export.header import Part, header
from otolith.export.program import MOTION, Port, Program, check_name, per_axis
from otolith.export.translate.render import Rendered
from otolith.export.translate.unit import translated
from otolith.export.vectors import Vectors
from otolith.live.core.bounds import Bounds
from otolith.live.core.gate import Gate, Refusal
from otolith.live.core.rollout import Track, follow
from otolith.platforms import Platform
from otolith.platforms.hexapod import Hexapod
from otolith.platforms.kinematics import leg_motion
from otolith.safety.law import Reach
from otolith.safety.supervisor import REASONS, Keeps, Supervisor, supervise

STEP: Final = 1e-3  # [s] between two set-points, unless another is asked for
LONGEST: Final = 0.05  # [s]
LAW: Final = 0.01  # [s] period of the law that leads the gate's set-points to rest
STEPS: Final = 2000  # of the test vectors
_FREQUENCIES: Final = (0.15, 0.45)  # [Hz] between which the sines of the test vectors are
_EXCESS: Final = 1.5  # times a limit that they ask for at most …
_POSE: Final = np.array([0.4] * 3 + [0.5] * 3)  # [m ×3, rad ×3] … and poses
_NONE: Final = 0.003  # share of them that are no numbers


class Guard(StrEnum):
    """What is asked before a platform moves."""

    GATE = "gate"  # moves set-points as commands say, as long as limits and the way to rest allow
    SUPERVISOR = "supervisor"  # keeps the limits of six legs, whatever the set-points


class SetPoints(StrEnum):
    """What the supervisor is given."""

    POSE = "pose"
    LEGS = "legs"


@dataclass(frozen=True, slots=True, kw_only=True)
class Guarding:
    """A guard at work: its kernel, what it reads and remembers, and what goes in and out."""

    step: Callable[[Any], int]
    values: Any  # named tuple that the kernel takes
    period: float  # [s]
    title: str
    about: str
    returns: str
    read: list[tuple[tuple[Port, ...], Part]]
    write: list[tuple[tuple[Port, ...], Part]]
    asked: Vec  # (6,) amplitudes of the test vectors' commands or set-points


class _Gated(NamedTuple):
    track: Track
    command: Vec  # (6,)
    period: float  # [s]
    bounds: Bounds
    reach: Reach
    refused: Vec  # (2,) why, and at which axis or leg


class _Kept(NamedTuple):
    by_pose: bool  # whether set-points are poses
    pose: Mat  # (3, 6) of the set-point; its accelerations are not used
    wanted: Mat  # (3, 6) coordinates, speeds and accelerations of the legs there
    given: Mat  # (2, 6) lengths and speeds, or angles and rates of cranks
    passed: Mat  # (2, 6) the same, passed on
    unit: float  # [m] of a length, or radius of the cranks
    lengths: Vec  # (6,) [m] as the supervisor knows them
    speeds: Vec  # (6,) [m/s]
    keeps: Keeps
    period: float  # [s]
    reduced: Vec  # (2,) why, and because of which leg


@kernel
def gate_once(of: Any) -> int:
    """Move the set-point by one step; return why the command was refused, or 0."""
    code, i = follow(of.track, of.command, of.period, of.bounds, of.reach)
    of.refused[0], of.refused[1] = code, i + 1 if code != 0 else 0
    return code


@kernel
def keep_once(of: Any) -> int:
    """Pass the legs on as far as they keep their limits; return why they were slowed, or 0."""
    if of.by_pose:
        of.wanted[2, :] = 0.0
        leg_motion(of.pose[0], of.pose[1], of.pose[2], of.keeps.joints.actuators, of.wanted)
    else:
        for row in range(2):
            for i in range(6):
                of.wanted[row, i] = of.given[row, i] * of.unit
    reason, leg = supervise(of.wanted[0], of.wanted[1], of.lengths, of.speeds, of.keeps, of.period)
    for i in range(6):
        of.passed[0, i], of.passed[1, i] = of.lengths[i] / of.unit, of.speeds[i] / of.unit
    of.reduced[0], of.reduced[1] = reason, leg + 1
    return reason


def gating(platform: Platform, *, period: float = STEP) -> Guarding:
    """Return the gate of one platform, for set-points every `period` [s].

    Raises
    ------
    InputError : the period is too short or too long.
    """
    _check_period(period)
    gate = Gate(platform, lag=platform.actuators.lag_s, period=LAW)
    track = Track(np.zeros((3, 6)), np.zeros(6), np.full(1, -1.0))
    of = _Gated(track, np.zeros(6), period, gate.bounds, gate.reach, np.zeros(2))
    command = per_axis("command", "/s2", "acceleration of {} that is asked for")
    words = ", ".join(f"{one.value} {one.name.lower().replace('_', ' ')}" for one in Refusal)
    why = (
        Port("refusal", "", words),
        Port("where", "", "axis or leg from 1 on that is the reason, 0 for none"),
    )
    motion = [(MOTION[row], (track.motion, 6 * row, 6 * row + 6)) for row in range(3)]
    return Guarding(
        step=gate_once,
        values=of,
        period=period,
        title=f"the gate of platform {platform.name}",
        about="A step moves the set-point by one period under the accelerations that are asked for, if it "
        "and the way to rest from it keep every limit of the platform; else along the way to rest. A command "
        "that is no number is refused, too, so it says that there is none.",
        returns="0 where the command was followed; else why it was refused, and the set-point goes to rest",
        read=[(command, (of.command, 0, 6))],
        write=[*motion, (why, (of.refused, 0, 2))],
        asked=_EXCESS * gate.reach.command,
    )


def supervising(
    hexapod: Hexapod, name: str, *, period: float = STEP, set_points: SetPoints = SetPoints.POSE
) -> Guarding:
    """Return the supervisor of the six legs of a platform with a name, for set-points every `period` [s].

    Raises
    ------
    InputError : the period is too short or too long.
    """
    _check_period(period)
    supervisor = Supervisor(hexapod, period=period)
    unit = 1.0 if hexapod.cranks is None else hexapod.actuators.radius
    of = _Kept(
        by_pose=set_points is SetPoints.POSE,
        pose=np.zeros((3, 6)),
        wanted=np.zeros((3, 6)),
        given=np.zeros((2, 6)),
        passed=np.array([supervisor.lengths, supervisor.speeds]) / unit,
        unit=unit,
        lengths=supervisor.lengths,
        speeds=supervisor.speeds,
        keeps=supervisor.keeps,
        period=period,
        reduced=np.zeros(2),
    )
    why = (
        Port("reason", "", ", ".join(f"{i} {one}" for i, one in enumerate(["none", *REASONS[1:]]))),
        Port("leg", "", "leg from 1 on that is the reason, 0 for none"),
    )
    inputs = [(MOTION[row], (of.pose, 6 * row, 6 * row + 6)) for row in range(2)]
    legs = _legs(hexapod, "leg_{}", "set-point of ")
    return Guarding(
        step=keep_once,
        values=of,
        period=period,
        title=f"the supervisor of the legs of platform {name}",
        about="A step passes on what the legs can do of a set-point at the end of the period. It keeps "
        "lengths, speeds, accelerations and angles of joints, and passes only poses that are proved to hold. "
        "All legs are slowed in proportion: the platform goes where it is sent, later or less far.",
        returns="0 while the legs follow; else why they were slowed",
        read=inputs if of.by_pose else [(legs[row], (of.given, 6 * row, 6 * row + 6)) for row in range(2)],
        write=[
            *(
                (ports, (of.passed, 6 * row, 6 * row + 6))
                for row, ports in enumerate(_legs(hexapod, "passed_{}"))
            ),
            (why, (of.reduced, 0, 2)),
        ],
        asked=_POSE if of.by_pose else np.full(6, 0.5 * _EXCESS * np.ptp(hexapod.stroke) / unit),
    )


def program_of_guard(of: Guarding, name: str) -> Program:
    """Return a guard as a program; raises `InputError` for a name that C does not take."""
    check_name(name)
    step: Any = of.step  # as compiled, which its type does not say
    unit, function = translated(step.py_func, of.values)
    parts = [part for _, part in (*of.read, *of.write)]
    text = header(
        Rendered(unit, function, name, [array for array, _, _ in parts]),
        of.title,
        of.about,
        returns=of.returns,
        period=of.period,
        inputs=[ports for ports, _ in of.read],
        outputs=[ports for ports, _ in of.write],
        read=[part for _, part in of.read],
        write=[part for _, part in of.write],
    )
    ports = [tuple(port for ports, _ in some for port in ports) for some in (of.read, of.write)]
    return Program(name=name, period=of.period, inputs=ports[0], outputs=ports[1], header=text)


def vectors_of_guard(of: Guarding, steps: int = STEPS, seed: int = 0) -> Vectors:
    """Return test vectors: what is asked swells beyond the limits, then jumps; some of it is no number.

    The guard is worked with and left there.
    """
    random = np.random.default_rng(seed)
    t = np.arange(steps)[:, None] * of.period
    turn, swell = 2.0 * math.pi * random.uniform(*_FREQUENCIES, 6), np.linspace(0.0, 1.0, steps)[:, None]
    signals = [swell * np.sin(turn * t), swell * turn * np.cos(turn * t)]
    jumps = random.uniform(-1.0, 1.0, (2, 6))
    for signal, jump in zip(signals, jumps, strict=True):
        signal[-steps // 4 :] = jump
    asked = np.hstack([of.asked * signal for signal, _ in zip(signals, of.read, strict=False)])
    inputs = asked + [port.start for ports, _ in of.read for port in ports]
    inputs[random.random(steps) < _NONE] *= np.nan
    outputs = np.array([_stepped(of, row) for row in inputs])
    return Vectors(inputs, outputs, free=0)


def _stepped(of: Guarding, given: Vec) -> Vec:
    """Step once with `given` (inputs,); return the outputs."""
    step: Any = of.step
    at = 0
    for _, (array, first, last) in of.read:
        array.reshape(-1)[first:last] = given[at : at + last - first]
        at += last - first
    step.py_func(of.values)  # what it calls is compiled, and has been for the Python side
    return np.concatenate([array.reshape(-1)[first:last] for _, (array, first, last) in of.write])


def _legs(hexapod: Hexapod, name: str, words: str = "") -> list[tuple[Port, ...]]:
    """Return the ports of lengths and speeds, or of angles and rates of cranks."""
    measure, what = ("m", "length of leg") if hexapod.cranks is None else ("rad", "angle of crank")
    start = hexapod.positions(np.zeros(6))
    return [
        tuple(
            Port(
                name.format(f"{kind}{i + 1}"),
                measure + per,
                f"{words}{rate}{what} {i + 1}",
                float(start[i]) * (not per),
            )
            for i in range(6)
        )
        for kind, per, rate in (("", "", ""), ("rate_", "/s", "rate of the "))
    ]


def _check_period(period: float) -> None:
    if not 1e-5 <= period <= LONGEST:
        raise InputError("--period", f"{period:g} s", f"0.00001 to {LONGEST:g} s between two set-points")
