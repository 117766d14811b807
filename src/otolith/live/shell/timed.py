"""A session that nobody speaks to: it arms and engages by itself, and is cued for a time."""

import time
from collections.abc import Callable
from typing import Final

from otolith.core.errors import OtolithError
from otolith.live.messages import State, Word
from otolith.live.shell.supervise import Live

LOOK: Final = 0.02  # [s]
PATIENCE: Final = 60.0  # [s] from the first look until it is engaged: a base rises, a game is started


class NotEngaged(OtolithError):
    """A session that was to arm and engage by itself was not cued at all."""


def cued_for(
    live: Live,
    seconds: float,
    look: Callable[[], None],
    *,
    patience: float = PATIENCE,
    now: Callable[[], float] = time.monotonic,
) -> None:
    """Arm, engage, and return after a time of being engaged, or at a fault or the output's end before.

    Parameters
    ----------
    look : is called every 20 ms; an exception ends it.
    patience : [s] that it asks to arm and to engage.

    Raises
    ------
    NotEngaged : it is not engaged by then.
    """
    begin, engaged_at = now(), None
    words = {State.IDLE: Word.ARM, State.READY: Word.ENGAGE}
    while live.alive("output"):
        state = live.look()
        look()
        if engaged_at is None and state in words:
            live.say(words[state])
        if engaged_at is None and state is State.ENGAGED:
            engaged_at = now()
        if state is State.FAULT or (engaged_at is not None and now() - engaged_at > seconds):
            return
        waits = engaged_at is None and state is not State.ENGAGING  # a platform may take long to rise
        if waits and now() - begin > patience:
            raise NotEngaged(
                f"the session is {state or 'silent'} after {patience:g} s, must be engaged by then; "
                "what kept it from arming stands above"
            )
        live.sign()
        time.sleep(LOOK)
