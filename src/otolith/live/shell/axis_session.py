"""The axis test as a session of real processes: one motion after the other, each watched by a person."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, Protocol

from otolith.core.errors import OtolithError
from otolith.live.axis_test import LEGS, AxisTest, Judge, goal_of, movable, seen
from otolith.live.messages import State, Word
from otolith.live.session import Session
from otolith.live.shell.processes import run_axis_test
from otolith.live.shell.supervise import Live, only_session

PATIENCE: Final = 30.0  # [s] for a state that has to come, and for a motion
LOOK: Final = 0.02  # [s]


class Watcher(Protocol):
    """Who stands beside the platform."""

    def tell(self, sentence: str) -> None:
        """Show a sentence about the session."""

    def look(self) -> None:
        """Be called every 20 ms; an exception ends the test, and the platform parks."""

    def ready(self, name: str) -> bool:
        """Return whether the motion may begin; asked until it may."""

    def saw(self, name: str) -> bool | None:
        """Return whether the platform was seen to move as it should; None for not yet known."""


def untested(session: Session, names: Sequence[str]) -> list[str]:
    """Return the axes that are left before a test counts: none after all axes, or all legs."""
    every = movable(session.gate())
    return [] if set(names) >= set(LEGS) else [name for name in every if name not in names]


class NotReached(OtolithError):
    """A state that a test needs was not reached."""


def check(session: Session, names: Sequence[str]) -> None:
    """Let the gate judge every test before anything moves.

    Raises
    ------
    InputError, AxisRefused : a name is no axis or leg of the platform, or its test is refused.
    """
    AxisTest([goal_of(name, session.platform) for name in names], session.gate(), session.period).check(names)


def played(
    session: Session,
    names: Sequence[str],
    watcher: Watcher,
    *,
    before_the_end: Callable[[], object] = lambda: None,
) -> list[str]:
    """Play the tests and ask after each; return a sentence for each one that failed.

    Whatever ends it, the platform comes to rest, returns and parks: a watcher's exception is a *stop*.
    """
    check(session, names)
    wrong: list[str] = []
    with only_session(session.device, watcher.tell) as lock:
        live = Live(session, watcher.tell, lock=lock, controller=partial(run_axis_test, tuple(names)))
        try:
            live.start(watcher.look)
            watcher.look()  # who said stop at the last moment of the start does not see it rise
            live.say(Word.ARM)
            _reach(live, State.READY, watcher)
            for name in names:
                while not watcher.ready(name):
                    _wait(live, LOOK, watcher)
                judge = Judge(goal_of(name, session.platform))
                wrong += _one(live, name, judge, watcher)
                if judge.cut_short:  # that is kept until the session ends: no other motion may begin
                    break
        except BaseException:
            if live.alive("output"):
                live.say(Word.STOP)
                live.look()
            raise
        finally:
            before_the_end()
            live.end()
    return wrong


def _one(live: Live, name: str, judge: Judge, watcher: Watcher) -> list[str]:
    live.say(Word.ENGAGE)
    _reach(live, State.ENGAGED, watcher)
    begin = time.monotonic()
    while not judge.over and time.monotonic() - begin < PATIENCE:
        _wait(live, LOOK, watcher)
        judge.look(live.report)
    live.say(Word.RETURN)
    _reach(live, State.READY, watcher)
    wrong = [f"{name}: {sentence}" for sentence in judge.wrong()]
    if judge.cut_short:
        return wrong
    while (answer := watcher.saw(name)) is None:
        _wait(live, LOOK, watcher)
    if not answer:
        wrong.append(f"{name}: it was not seen to move {seen(name)}")
    return wrong


def _wait(live: Live, seconds: float, watcher: Watcher) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        live.look()
        watcher.look()
        time.sleep(LOOK)


def _reach(live: Live, state: State, watcher: Watcher) -> None:
    begin = time.monotonic()
    while live.look() is not state:
        watcher.look()
        late = f" within {PATIENCE:.0f} s" if time.monotonic() - begin > PATIENCE else ""
        if late or live.look() is State.FAULT or not live.alive("output"):
            raise NotReached(f"the session did not become {state}{late}; it is {live.look()}")
        time.sleep(LOOK)
