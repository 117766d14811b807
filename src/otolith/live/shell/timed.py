"""A session that nobody speaks to: it arms and engages by itself, and is cued for a time."""

import time
from collections.abc import Callable
from typing import Final

from otolith.live.messages import State, Word
from otolith.live.shell.supervise import Live

LOOK: Final = 0.02  # [s]


def cued_for(live: Live, seconds: float, look: Callable[[], None]) -> None:
    """Arm, engage, and return after a time of being engaged, or at a fault or the output's end before.

    Parameters
    ----------
    look : is called every 20 ms; an exception ends it.
    """
    engaged_at: float | None = None
    words = {State.IDLE: Word.ARM, State.READY: Word.ENGAGE}
    while live.alive("output"):
        state = live.look()
        look()
        if engaged_at is None and state in words:
            live.say(words[state])
        if engaged_at is None and state is State.ENGAGED:
            engaged_at = time.monotonic()
        if state is State.FAULT or (engaged_at is not None and time.monotonic() - engaged_at > seconds):
            return
        live.sign()
        time.sleep(LOOK)
