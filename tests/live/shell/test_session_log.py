"""A session of real processes that is logged: replayed bit for bit, and undisturbed by a killed recorder."""

import os
import signal
import time
from pathlib import Path

import pytest

from otolith.cli.live_log import opened
from otolith.live.log import PIECES, Kind
from otolith.live.messages import State, Word
from otolith.live.replay import Replay
from otolith.live.session import session_from_record
from otolith.live.shell.supervise import Live, only_session
from tests.live.shell.rig import Rig, until


def reported(live: Live) -> int:
    """Return the time [ns] of the latest tick of the output."""
    return 0 if live.report is None else live.report.time_ns


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_a_logged_session_replays_and_outlives_its_recorder(tmp_path: Path, how: signal.Signals) -> None:
    """Row 15: the recorder is killed or hangs while the platform is cued; what it wrote before is whole."""
    told: list[str] = []
    with Rig() as rig, only_session(rig.session().device) as lock:
        live = Live(rig.session(), told.append, lock=lock, log=tmp_path)
        try:
            live.start()
            live.say(Word.ARM)
            until(lambda: live.look() is State.READY, "ready")
            live.say(Word.ENGAGE)
            rig.moves()
            time.sleep(3.0)
            os.kill(live._children["recorder"].pid, how)
            until(lambda: bool(live.look()) and any("its recorder" in line for line in told), "the lamp")
            before = time.monotonic_ns()
            until(lambda: live.look() is not None and reported(live) > before + 10**9, "set-points go on")
            assert live.fault == ""
        finally:
            live.end()
    assert any(line.startswith(("parked", "fault")) for line in told)  # the base may have missed packets
    (path,) = tmp_path.iterdir()
    with opened(path) as log:
        session = session_from_record(log.head["session"], path.name)
        assert session.settings.cueing == "classical"
        assert log.head["versions"]["machine"] == "x86_64"
        replay = Replay(session.controller(), session.output(), path.name)
        kinds: set[int] = set()
        for piece in log.pieces(PIECES):
            replay.take(piece)
            kinds |= {one.kind for one in piece}
    assert kinds >= set(Kind) - {Kind.LOST, Kind.REACTION, Kind.CHANGE}
    plans, set_points = replay.seen
    assert (plans.first, plans.different, plans.lost) == ("", 0, 0)
    assert (set_points.first, set_points.different, set_points.lost) == ("", 0, 0)
    assert set_points.compared > 3000
    assert plans.compared > 300
