"""The errands that must have been done before a platform may be armed: this host is tested, and every axis.

Both leave the records of `otolith live check` and `otolith live axis`, and count as those do.
"""

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from otolith import files
from otolith.commander.errands import Talk
from otolith.commander.rig import axes_to_test, read_rig, session_of_rig
from otolith.core.errors import OtolithError
from otolith.live.axis_test import LEGS, seen
from otolith.live.permits import LATEST, SelfTest, keep_axis_test
from otolith.live.session import Session, session_of
from otolith.live.settings import settings_from
from otolith.live.shell.axis_session import check, played, untested
from otolith.live.shell.processes import OUTPUT
from otolith.live.shell.rights import real_time_is_granted
from otolith.live.shell.supervise import Live, only_session
from otolith.live.shell.timed import cued_for
from otolith.live.shell.virtual import base_at, surroundings

SECONDS: Final = 60.0  # of being cued, in the test of the host
PATIENCE: Final = 120.0  # [s] for an answer
MACHINE: Final = "davsi-4dof"  # whose base exists in software


class NotPassed(OtolithError):
    """A test was not passed; the text says why."""


class Beside:
    """Somebody at a page who stands beside the platform: see `otolith.live.shell.axis_session.Watcher`."""

    def __init__(self, talk: Talk) -> None:
        self._talk = talk
        self._asks: tuple[str, str] = ("", "")  # what is asked, of which axis
        self._since, self._word = 0.0, ""

    def tell(self, sentence: str) -> None:
        """Show a sentence on the page."""
        self._talk.tell(sentence)

    def look(self) -> None:
        """Hear the page: a stop is an exception."""
        for order in self._talk.heard():
            self._word = order.word

    def ready(self, name: str) -> bool:
        """Return whether somebody let this axis move."""
        if self._asked("ready", name) != "move":
            return False
        self._ask("moves", name)
        return True

    def saw(self, name: str) -> bool | None:
        """Return what was seen; None until it is said."""
        word = self._asked("saw", name)
        if word not in ("yes", "no"):
            return None
        self._talk.show(answers={**self._talk.shown.get("answers", {}), name: word})
        return word == "yes"

    def _asked(self, what: str, name: str) -> str:
        """Ask, unless that is asked already, and return the word that came since.

        Raises
        ------
        NotPassed : nobody answers.
        """
        if self._asks != (what, name):
            self._ask(what, name)
        if time.monotonic() - self._since > PATIENCE:
            raise NotPassed(f"{name}: nobody answered for {PATIENCE:.0f} s; the platform is parked")
        return self._word

    def _ask(self, what: str, name: str) -> None:
        self._asks, self._since, self._word = (what, name), time.monotonic(), ""
        self._talk.show(asks=what, axis=name, seen=seen(name))


def try_axes(folder: Path, talk: Talk, values: Mapping[str, Any]) -> str:
    """Move one axis or leg after the other, and keep the record if all were seen to move as they should.

    Parameters
    ----------
    folder : the Commander's. values : `what`, "axes" or "legs".

    Raises
    ------
    Ended : it was stopped; the platform is parked. NotPassed, OtolithError : see `played`.
    """
    session = session_of_rig(read_rig(folder), folder)
    names = LEGS if values["what"] == "legs" else tuple(axes_to_test(session))
    check(session, names)
    talk.show(axes=list(names), answers={}, asks="starts", axis="", seen="")
    wrong = played(session, names, Beside(talk))
    if wrong:
        raise NotPassed("; ".join(wrong))
    if left := untested(session, names):
        raise NotPassed(f"nothing is kept: {', '.join(left)} were not tested")
    return f"kept in {keep_axis_test(session, list(names))}: sessions with this device may arm"


def try_host(folder: Path, talk: Talk, values: Mapping[str, Any]) -> str:
    """Run a session with a base in software, and keep how late its output woke.

    Raises
    ------
    Ended : it was stopped; nothing is kept. NotPassed : this host wakes too late.
    """
    del values
    rig, real_time = read_rig(folder), real_time_is_granted(OUTPUT)
    tuning = {"tuning": rig.tuning} if rig.tuning else {}
    with surroundings(files.read_platform(MACHINE)) as (telemetry, base):
        fields = {
            "platform": MACHINE,
            "cueing": rig.cueing,
            **tuning,
            "input": {"source": "generic", "listen": f"127.0.0.1:{telemetry}"},
            "device": base_at(base),
        }
        live = _run(session_of(settings_from(fields, "the test"), None, source="the test", named={}), talk)
    test = SelfTest.of(live.output_timing.late, seconds=SECONDS, real_time=real_time)
    path = test.keep()
    late = f"99.9 % of its wake-ups were at most {1e3 * test.p999:.2g} ms late"
    if not test.punctual:
        raise NotPassed(f"this computer does not pass: {late}, must be at most {1e3 * LATEST:g} ms")
    return f"this computer passes: {late}; kept in {path}"


def _run(session: Session, talk: Talk) -> Live:
    """Run a session for `SECONDS`; return it as it ended."""

    def hear() -> None:
        talk.heard()

    def look() -> None:
        hear()
        if (passed := round(time.monotonic() - begin)) != talk.shown.get("passed"):
            talk.show(passed=passed, of=round(SECONDS))

    with only_session(session.device, talk.tell) as lock:
        live = Live(session, talk.tell, lock=lock)
        try:
            talk.tell("starting; what is not compiled yet takes up to a minute")
            live.start(hear)
            begin = time.monotonic()
            cued_for(live, SECONDS, look)
        finally:
            live.end()
    if live.fault:
        raise NotPassed(live.fault)
    if live.controller_timing.cpu.count == 0:
        raise NotPassed("the session ended before the platform was cued, so nothing was measured")
    return live
