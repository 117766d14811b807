"""`otolith live check` and `live axis`: what has to be tested before a session may arm."""

import time
from functools import partial
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from otolith.cli.live_run import Choices, Heave, MachineName, Outgoing, Pairs, SessionFile, measure
from otolith.cli.live_virtual import CueingName, Json, Tuning
from otolith.cli.options import Dofs, PlatformName
from otolith.cli.output import print_json, screen
from otolith.cli.stop import unstoppable
from otolith.core.errors import OtolithError

if TYPE_CHECKING:
    from otolith.core.arrays import Vec
    from otolith.live.messages import State
    from otolith.live.session import Session
    from otolith.live.shell.supervise import Live

STRAYS = 0.3  # share of a test's way by which the device may report another pose
PATIENCE = 30.0  # [s] for a state that has to come


def check(
    seconds: Annotated[float, typer.Option(help="How long to be engaged.", min=1.0)] = 60.0,
    cueing: CueingName = "predictive",
    platform: PlatformName = "davsi-4dof",
    dofs: Dofs = "surge-pitch,sway-roll",
    tuning: Tuning = None,
    json: Json = False,
) -> None:
    """Test this host: a session with a base in software. Sessions arm only where it woke in time."""
    from otolith.live.permits import LATEST, SelfTest
    from otolith.live.shell.processes import OUTPUT
    from otolith.live.shell.rights import real_time_is_granted
    from otolith.live.shell.virtual import surroundings

    real_time = real_time_is_granted(OUTPUT)
    with surroundings() as (telemetry, base):
        choices = Choices(cueing=cueing, platform=platform, dofs=dofs, tuning=tuning)
        live = measure(choices.between(telemetry, base).session(), seconds, stderr=json)
    late, cpu = live.output_timing.late, live.controller_timing.cpu
    test = SelfTest.of(late, seconds=seconds, real_time=real_time)
    path = test.keep()
    verdict = "sessions may arm" if test.punctual else "sessions do not arm, unless --allow-jitter is given"
    if json:
        figures = {name: getattr(test, name) for name in ("median", "p99", "p999", "largest")}
        step = {"step_median": 1e-9 * cpu.share(0.5), "step_p99": 1e-9 * cpu.share(0.99)}
        print_json({**figures, **step, "real_time": real_time, "punctual": test.punctual})
    else:
        out = partial(screen(stderr=False).print, highlight=False, soft_wrap=True)
        out(f"{test.host}, {test.system}: real-time scheduling {'granted' if real_time else 'refused'}")
        out(f"wake-ups late: {late}")
        out(f"decisions, on the processor: {cpu}")
        out(f"99.9 % may be late by {1e3 * LATEST:g} ms at most: {verdict}; kept in {path}")
    if not test.punctual:
        raise typer.Exit(1)


def axis(
    axes: Annotated[
        list[str] | None,
        typer.Argument(metavar="[AXIS]...", help="surge … yaw, or leg1 … leg6 (default: all axes)."),
    ] = None,
    outgoing: Outgoing = None,
    session: SessionFile = None,
    platform: MachineName = None,
    dofs: Pairs = None,
    neutral_heave: Heave = None,
) -> None:
    """Move one axis or leg after the other by 10 mm or 1 degree, slowly, and ask what was seen."""
    from otolith.live.axis_test import AxisTest, goal_of, movable
    from otolith.live.permits import keep_axis_test
    from otolith.live.shell.virtual import free_port

    made = Choices(
        incoming=f"generic+udp://127.0.0.1:{free_port()}",  # nothing is listened to
        outgoing=outgoing,
        file=session,
        platform=platform,
        dofs=dofs,
        neutral_heave=neutral_heave,
    ).session()
    every = movable(made.gate())
    names = tuple(axes or every)
    goals = [goal_of(name, made.platform) for name in names]
    AxisTest(goals, made.gate(), made.period).check(names)
    wrong = _tested(made, names, goals)
    console = screen()
    for sentence in wrong:
        console.print(sentence, style="red", highlight=False, soft_wrap=True)
    if wrong:
        raise typer.Exit(1)
    legs = {f"leg{number}" for number in range(1, 7)}
    if set(names) >= set(every) or set(names) >= legs:
        console.print(f"kept in {keep_axis_test(made, list(names))}: sessions with this device may arm")
    else:
        missing = ", ".join(name for name in every if name not in names)
        console.print(f"nothing is kept: {missing} were not tested")


class NotReached(OtolithError):
    """A state that a test needs was not reached."""


def _tested(session: "Session", names: tuple[str, ...], goals: "list[Vec]") -> list[str]:
    """Play the tests and ask after each; return a sentence for each one that failed."""
    from otolith.live.messages import State, Word
    from otolith.live.shell.processes import run_axis_test
    from otolith.live.shell.supervise import Live, only_session

    console = screen(stderr=False)
    tell = partial(console.print, highlight=False, soft_wrap=True)
    wrong = []
    with only_session(session.device, tell) as lock:
        live = Live(session, tell, lock=lock, controller=partial(run_axis_test, names))
        try:
            live.start()
            live.say(Word.ARM)
            _reach(live, State.READY)
            for name, goal in zip(names, goals, strict=True):
                wrong += _one(live, name, goal)
        finally:
            with unstoppable():
                live.end()
    return wrong


def _one(live: "Live", name: str, goal: "Vec") -> list[str]:
    from otolith.live.axis_test import HELD, LASTS, seen
    from otolith.live.messages import State, Word

    live.say(Word.ENGAGE)
    _reach(live, State.ENGAGED)
    _wait(live, HELD)
    measured = None if live.report is None else live.report.measured
    _wait(live, LASTS - HELD)
    live.say(Word.RETURN)
    _reach(live, State.READY)
    wrong = [] if measured is None else _differs(name, goal, measured)
    if not typer.confirm(f"{name}: did the platform move {seen(name)}, and back?", default=False):
        wrong.append(f"{name}: it was not seen to move {seen(name)}")
    return wrong


def _differs(name: str, goal: "Vec", measured: "Vec") -> list[str]:
    """Return a sentence where the device reports another pose than it was sent to."""
    allowed = STRAYS * np.abs(goal).max()
    off = np.abs(measured - goal)
    if float(off.max()) <= allowed:
        return []
    is_at, should = (np.round(pose, 4).tolist() for pose in (measured, goal))
    return [f"{name}: the device reports the pose {is_at}, must be near {should}"]


def _wait(live: "Live", seconds: float) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        live.look()
        time.sleep(0.02)


def _reach(live: "Live", state: "State") -> None:
    begin = time.monotonic()
    while live.look() is not state:
        if time.monotonic() - begin > PATIENCE or not live.alive("output"):
            raise NotReached(
                f"the session did not become {state} within {PATIENCE:.0f} s; it is {live.look()}"
            )
        time.sleep(0.02)
