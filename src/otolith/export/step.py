"""One step of a program, as kernels: a decision alone, or a decision that a platform follows.

They are the kernels that a closed loop in Python runs. What a kernel asks of Python in between
(`otolith.compiled`) finds no answer in a program: the algorithm is called again at once, and brakes.
"""

import math
from typing import Any, NamedTuple

from otolith.compiled import DECIDE, NOTHING, STATUS
from otolith.core.arrays import Mat, Vec
from otolith.core.frames import GRAVITY
from otolith.core.jit import kernel
from otolith.core.methods import Method
from otolith.loop.closed import Loop, close

_decide = DECIDE.call


class Decision(NamedTuple):
    """A decision alone: the algorithm, and what goes in and out."""

    algorithm: Method
    wanted: Vec  # (6,) specific force and angular rate
    measured: Mat  # (3, 6) pose, twist and acceleration
    preview: Mat  # (0, 3)
    command: Vec  # (6,) accelerations
    result: Vec  # (5,) as `otolith.compiled.outcome_of` reads it


class Moved(NamedTuple):
    """A closed loop of one period, and what is felt at its end."""

    loop: Loop
    sensed: bool  # whether the plant senses the force
    force: Vec  # (3,) [m/s²]
    result: Vec  # (5,) that of the loop's only decision


@kernel
def decide_once(of: Any) -> int:
    """Decide one command; return the status."""
    again = 0
    while _decide(of.algorithm, (of.measured, of.wanted, of.preview, 0.0, again, of.command, of.result)):
        again = 1
    return int(of.result[STATUS])


@kernel
def move_once(of: Any) -> int:
    """Decide one command, and let the platform follow it for a period; return the status."""
    done, again = 0, 0
    while done == 0:
        done, request = close(of.loop, 0, 1, again)
        again = 1 if request != NOTHING else 0
    if of.sensed:
        for i in range(3):
            of.force[i] = of.loop.force[of.loop.every - 1, i]
    else:
        planar_force(of.loop.state, of.force)
    return int(of.result[STATUS])


@kernel
def planar_force(motion: Mat, force: Vec) -> None:
    """Write the force (3,) [m/s²] of the planar models, as `otolith.core.frames.specific_force` does."""
    roll, pitch = motion[0, 3], motion[0, 4]
    force[0] = motion[2, 0] - GRAVITY * math.sin(pitch)
    force[1] = motion[2, 1] + GRAVITY * (math.cos(pitch) * math.sin(roll))
    force[2] = motion[2, 2] + GRAVITY * (math.cos(pitch) * math.cos(roll) - 1.0)
