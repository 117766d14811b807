"""What the system grants a process that must wake in time, said in words.

Nothing here is a substitute for another thing: where real-time scheduling is refused, the loop is late now
and then, and the start says so with the two lines that change it.
"""

import ctypes
import gc
import os
import signal
from typing import Final

_ALL_NOW_AND_LATER: Final = 3  # MCL_CURRENT | MCL_FUTURE
_DIE_WITH_PARENT: Final = 1  # PR_SET_PDEATHSIG
HINT: Final = (
    "to have it, write to /etc/security/limits.d/otolith.conf: "
    "'@otolith - rtprio 30' and '@otolith - memlock unlimited'"
)


def take_rights(priority: int) -> list[str]:
    """Ask for real-time scheduling and locked memory, and end garbage collection; return sentences."""
    said = []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        said.append(f"real-time scheduling granted (FIFO {priority})")
    except OSError as error:
        said.append(f"real-time scheduling refused ({error.strerror}); {HINT}")
    locked = ctypes.CDLL(None, use_errno=True).mlockall(_ALL_NOW_AND_LATER) == 0
    said.append("memory locked" if locked else f"memory not locked ({os.strerror(ctypes.get_errno())})")
    gc.collect()
    gc.freeze()
    gc.disable()
    return said


def real_time_is_granted(priority: int) -> bool:
    """Return whether the system would grant real-time scheduling; nothing is left changed."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except OSError:
        return False
    os.sched_setscheduler(0, *before)
    return True


def die_with_parent(signal_number: int, parent: int) -> None:
    """Let the system send this process a signal when its parent, of that number, dies or has died."""
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal_number)
    if os.getppid() != parent:
        signal.raise_signal(signal_number)
