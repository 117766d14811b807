"""Processes of a session that die or hang, judged by the order of events and never by milliseconds."""

import os
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from otolith.core.errors import MissingExtra
from otolith.live.controller import Controller
from otolith.live.devices.emulator import ENGAGED, FAULT_2, WATCHDOG
from otolith.live.messages import State, Word
from otolith.live.session import Session
from otolith.live.shell.supervise import Live, Occupied, only_session
from tests.live.shell.rig import Rig, until

Running = tuple[Live, Rig, list[str]]


def reach(live: Live, state: State) -> None:
    until(lambda: live.look() is state, f"{state}")


def kill(live: Live, name: str, number: signal.Signals) -> None:
    os.kill(live._children[name].pid, number)


def is_gone(live: Live, name: str) -> None:
    until(lambda: not live.alive(name), f"the {name} has ended", 20.0)


def is_cued(live: Live, rig: Rig) -> bool:
    """Whether the base moves; engage, and again where a busy machine has ended it meanwhile."""
    state = live.look()
    if state is State.READY:
        live.say(Word.REARM, Word.ENGAGE)
    return state is State.ENGAGED and bool(rig.farthest[0] > 5e-3)


def test_without_ruckig_a_session_is_refused_before_anything_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It used to compile, listen and stay idle for ever."""
    monkeypatch.setitem(sys.modules, "ruckig", None)  # as if it were not installed
    with pytest.raises(MissingExtra, match=r"needs ruckig.*pip install 'otolith\[live\]'"):
        Live(Rig().session(), print, lock=-1, log=tmp_path / "logs")
    assert not (tmp_path / "logs").exists()


@pytest.fixture
def running() -> Iterator[Running]:
    """A session that is engaged and moves its base."""
    told: list[str] = []
    with Rig() as rig, only_session(("127.0.0.1", rig.device)) as lock:
        live = Live(rig.session(), told.append, lock=lock)
        try:
            live.start()
            live.say(Word.ARM)
            reach(live, State.READY)
            until(lambda: is_cued(live, rig), "the base is cued")
            yield live, rig, told
        finally:
            live.end()


class Asked(Exception):
    """Somebody wants the session to end."""


class Compiling(Session):
    """A session whose algorithm is compiled for ever, which a file says; its name is one of `texts`."""

    def controller(self) -> Controller:
        Path(self.texts["begun"]).touch()
        while True:
            sum(range(1000))


def test_a_stop_while_processes_start_does_not_wait_for_the_compiler(tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    with Rig() as rig, only_session(("127.0.0.1", rig.device)) as lock:
        made = replace(rig.session(), texts={"begun": str(begun)})
        session = Compiling(**{one.name: getattr(made, one.name) for one in fields(made)})
        live = Live(session, lambda _: None, lock=lock)

        def stopped() -> None:
            if begun.exists():
                raise Asked

        try:
            with pytest.raises(Asked):
                live.start(stopped)
            controller = live._children["controller"]
        finally:
            live.end()
        assert controller.exitcode == -signal.SIGTERM  # it had not to be killed
        assert ENGAGED not in rig.states


def test_a_controller_that_hangs_and_then_dies_is_missed_and_the_platform_returns_and_parks(
    running: Running,
) -> None:
    live, rig, told = running
    with pytest.raises(Occupied, match=f"is driven by process {os.getpid()} already"):
        only_session(("127.0.0.1", rig.device)).__enter__()
    kill(live, "controller", signal.SIGSTOP)
    reach(live, State.READY)
    assert any(line.startswith("returning: no sign of the controller") for line in told)
    kill(live, "controller", signal.SIGCONT)
    time.sleep(0.5)
    assert live.look() is State.READY  # it lives, and only a word engages again
    live.say(Word.REARM, Word.ENGAGE)
    reach(live, State.ENGAGED)
    kill(live, "controller", signal.SIGKILL)
    reach(live, State.READY)
    assert sum(line.startswith("returning: no sign of the controller") for line in told) == 2
    is_gone(live, "controller")  # the system may take its time to take back what it had
    live.look()
    assert any(line.startswith("the controller has died") for line in told)
    live.end()
    assert "parked: parked" in told
    rig.is_at_home()
    assert rig.base.faults == 0


@pytest.mark.parametrize(
    "signals",
    [
        [("output", signal.SIGSTOP)],
        [("output", signal.SIGKILL), ("controller", signal.SIGKILL)],
        [("controller", signal.SIGKILL), ("output", signal.SIGKILL)],
    ],
    ids=["hangs", "dies first", "dies last"],
)
def test_an_output_that_dies_or_hangs_is_a_fault_that_nothing_undoes(
    running: Running, signals: list[tuple[str, signal.Signals]]
) -> None:
    live, rig, told = running
    for name, number in signals:
        kill(live, name, number)
    reach(live, State.FAULT)
    for name in ("output", "controller"):
        is_gone(live, name)  # also what was only stopped: it must not go on
    packets = rig.packets
    until(lambda: FAULT_2 in rig.states, "the base's own watchdog acts", 20.0)
    assert rig.base.faults == WATCHDOG
    until(lambda: bool(np.abs(rig.base.position).max() < 1e-3), "the base sinks home", 30.0)
    live.say(Word.REARM, Word.ARM)
    time.sleep(0.3)
    assert live.look() is State.FAULT
    assert rig.packets == packets
    live.end()
    assert any(line.startswith("fault: the output") for line in told)
    assert not Path(f"/dev/shm/{live._names['plans']}").exists()
