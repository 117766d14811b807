"""A session of real processes, judged by the order of events and never by milliseconds."""

import multiprocessing
import os
import signal
import time
from collections.abc import Iterator

import pytest

from otolith.cli.live_run import Choices
from otolith.live.messages import State, Word
from otolith.live.shell.supervise import Live, Occupied, only_session
from otolith.live.shell.virtual import be_base, be_driver, free_port

PATIENCE = 120.0  # [s] for a start with a cold compiler on a busy machine


def until(live: Live, state: State, patience: float = PATIENCE) -> None:
    begin = time.monotonic()
    while live.look() is not state:
        assert time.monotonic() - begin < patience, f"{state} was not reached; it is {live.look()}"
        time.sleep(0.02)


@pytest.fixture
def session() -> Iterator[tuple[Live, list[str]]]:
    """A session with a virtual driver and a Moog base in software; it is engaged."""
    telemetry, base = free_port(), free_port()
    context = multiprocessing.get_context("spawn")
    helpers = [
        context.Process(target=be_base, args=(base,)),
        context.Process(target=be_driver, args=(telemetry,)),
    ]
    for helper in helpers:
        helper.start()
    told: list[str] = []
    choices = Choices(
        incoming=f"generic+udp://127.0.0.1:{telemetry}",
        outgoing=f"moog+udp://127.0.0.1:{base}",
        cueing="classical",
        platform="davsi-4dof",
        dofs="surge-pitch,sway-roll",
        tuning="davsi",
    )
    with only_session(("127.0.0.1", base)):
        live = Live(choices.session(), told.append)
        try:
            live.start()
            live.say(Word.ARM)
            until(live, State.READY)
            live.say(Word.ENGAGE)
            until(live, State.ENGAGED)
            with pytest.raises(Occupied, match="is driven by process"), only_session(("127.0.0.1", base)):
                pass
            yield live, told
        finally:
            live.end()
            for helper in helpers:
                helper.kill()
                helper.join()


def test_a_controller_that_is_killed_is_missed_at_once_and_the_platform_returns_and_parks(
    session: tuple[Live, list[str]],
) -> None:
    live, told = session
    os.kill(live._children["controller"].pid, signal.SIGKILL)
    until(live, State.READY)
    live.end()
    assert any(line.startswith("returning: no plan from the controller") for line in told)
    assert any(line.startswith("parked") for line in told)
