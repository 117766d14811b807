"""`otolith live check` and `live axis`: what has to be tested before a session may arm."""

import contextlib
from functools import partial
from typing import Annotated

import typer

from otolith.cli.durations import lasting
from otolith.cli.live_run import Choices, Heave, MachineName, Outgoing, Pairs, SessionFile, measure
from otolith.cli.live_virtual import CueingName, Json, Tuning
from otolith.cli.options import Dofs, PlatformName
from otolith.cli.output import print_json, screen
from otolith.cli.stop import unstoppable


class AtTerminal:
    """A person at a terminal, who watches the tests: see `otolith.live.shell.axis_session.Watcher`."""

    def tell(self, sentence: str) -> None:
        """Print a sentence."""
        screen(stderr=False).print(sentence, highlight=False, soft_wrap=True)

    def look(self) -> None:
        """Have nothing to hear: Ctrl-C is a signal."""

    def ready(self, _: str) -> bool:
        """Let the next test begin at once."""
        return True

    def saw(self, name: str) -> bool:
        """Ask whether the platform moved as it should."""
        from otolith.live.axis_test import seen

        return typer.confirm(f"{name}: did the platform move {seen(name)}, and back?", default=False)


def check(
    seconds: Annotated[float, lasting("How long to be engaged", least=1.0)] = 60.0,
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

    real_time = real_time_is_granted(OUTPUT)
    with Choices(cueing=cueing, platform=platform, dofs=dofs, tuning=tuning).rehearsed() as session:
        live = measure(session, seconds, stderr=json)
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
        typer.Argument(
            metavar="[AXIS]...", help="surge … yaw, leg1 … leg6 or crank1 … crank6 (default: all axes)."
        ),
    ] = None,
    outgoing: Outgoing = None,
    session: SessionFile = None,
    platform: MachineName = None,
    dofs: Pairs = None,
    neutral_heave: Heave = None,
) -> None:
    """Move one axis or leg after the other by 10 mm or 1 degree, slowly, and ask what was seen."""
    from otolith.live.axis_test import movable
    from otolith.live.permits import keep_axis_test
    from otolith.live.shell.axis_session import played, untested
    from otolith.live.shell.virtual import free_port

    made = Choices(
        incoming=f"generic+udp://127.0.0.1:{free_port()}",  # nothing is listened to
        outgoing=outgoing,
        file=session,
        platform=platform,
        dofs=dofs,
        neutral_heave=neutral_heave,
    ).session()
    names = tuple(axes or movable(made.gate()))
    with contextlib.ExitStack() as ending:  # nothing interrupts the way home
        wrong = played(made, names, AtTerminal(), before_the_end=lambda: ending.enter_context(unstoppable()))
    console = screen()
    for sentence in wrong:
        console.print(sentence, style="red", highlight=False, soft_wrap=True)
    if wrong:
        raise typer.Exit(1)
    if left := untested(made, names):
        console.print(f"nothing is kept: {', '.join(left)} were not tested")
    else:
        console.print(f"kept in {keep_axis_test(made, list(names))}: sessions with this device may arm")
