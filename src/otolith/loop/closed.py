"""A closed loop of any algorithm and any plant that offer a method of their role, compiled as a whole.

Period by period it does what `otolith.loop.simulate` otherwise does in Python, with the same kernels. So both
give the same numbers, bit for bit. This is checked by tests/loop/test_closed.py.
"""

import ctypes
import time
from typing import Any, Final, NamedTuple

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from otolith.compiled import DECIDE, FOLLOW, NOTHING
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.jit import kernel
from otolith.core.methods import Method

decide = DECIDE.call
follow = FOLLOW.call


class Loop(NamedTuple):
    """One loop and its record: m periods with `every` plant steps each, n = m · every."""

    decide: Method
    follow: Method
    every: int
    known: int  # K, number of coming periods whose forces the algorithm receives
    now: Mat  # (m, 6) specific force and angular rate wanted at the decisions
    forces: Mat  # (m + K, 3) specific force wanted, for the preview
    state: Mat  # (3, 6) motion of the platform; with a base (6, 6), here and in `motion`
    command: Mat  # (m, 6); with a base (m, 12)
    result: Mat  # (m, 5) as `otolith.compiled.outcome_of` reads it
    seconds: Vec  # (m,) [s] of every decision
    motion: Mat  # (n, 3, 6) pose, twist, acceleration
    force: Mat  # (n, 3) [m/s²] felt force; NaN if the plant does not sense it
    clock: int  # address of C's clock_gettime; 0 if there is none
    clock_of: int  # which clock it reads
    read: Ints  # (2,) memory for its result: seconds and nanoseconds


@kernel
def follow_once(method: Method, command: Vec, motion: Mat, force: Mat) -> int:
    """Let a plant follow one command; see `otolith.compiled.FOLLOW`. Python calls this kernel."""
    done: int = follow(method, (command, motion, force))
    return done


@kernel
def close(loop: Any, first: int, last: int, again: int) -> tuple[int, int]:
    """Run the periods from `first` up to `last`, or until the algorithm makes a request.

    Returns
    -------
    The next period, and the request. When the request has been met, the period is run again with `again` = 1.
    """
    for i in range(first, last):
        preview = loop.forces[i + 1 : i + 1 + loop.known]
        began = _seconds(loop)
        request = decide(
            loop.decide,
            (loop.state, loop.now[i], preview, 0.0, again, loop.command[i], loop.result[i]),
        )
        loop.seconds[i] += _seconds(loop) - began
        if request != NOTHING:
            return i, request
        again = 0
        moved = loop.motion[i * loop.every : (i + 1) * loop.every]
        follow(loop.follow, (loop.command[i], moved, loop.force[i * loop.every : (i + 1) * loop.every]))
        for row in range(loop.state.shape[0]):
            for axis in range(6):
                loop.state[row, axis] = moved[loop.every - 1, row, axis]
    return last, NOTHING


@kernel
def _seconds(loop: Any) -> float:
    """Return the CPU time of this thread [s]."""
    if loop.clock == 0:
        return 0.0
    _read_clock(loop.clock, loop.clock_of, loop.read)  # type: ignore[call-arg]
    seconds: float = loop.read[0] + 1e-9 * loop.read[1]
    return seconds


@intrinsic
def _read_clock(_typing: Any, _address: Any, _clock: Any, room: Any) -> Any:
    """Call C's clock_gettime."""

    def generate(context: Any, builder: Any, _: Any, values: Any) -> Any:
        number = ir.IntType(32)
        array = context.make_array(room)(context, builder, values[2])
        function = ir.FunctionType(number, [number, ir.IntType(64).as_pointer()]).as_pointer()
        builder.call(builder.inttoptr(values[0], function), [builder.trunc(values[1], number), array.data])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, room), generate


def thread_clock() -> tuple[int, int]:
    """Return the address of C's clock_gettime and the id of the thread's clock; zeros if there is none."""
    which = getattr(time, "CLOCK_THREAD_CPUTIME_ID", None)
    if which is None:
        return 0, 0
    return ctypes.cast(ctypes.CDLL(None).clock_gettime, ctypes.c_void_p).value or 0, which


CLOCK: Final = thread_clock()
