"""`otolith live run` and `live demo`: a session in real time."""

import contextlib
import multiprocessing
import select
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final
from urllib.parse import urlsplit

import typer

from otolith import files
from otolith.cli.live_virtual import CueingName, Tuning, machine_named
from otolith.cli.options import Dofs, PlatformName
from otolith.cli.output import screen
from otolith.cli.stop import Stopped
from otolith.core.errors import InputError, one_of

if TYPE_CHECKING:
    from otolith.live.devices.driver import Driver
    from otolith.live.shell.processes import Session
    from otolith.live.shell.supervise import Live

DEVICES: Final = ("moog", "generic")
PERIOD: Final = 0.01  # [s] of the algorithms that are run live
LOOK: Final = 0.05  # [s] between looks at the session
_Heave = Annotated[float, typer.Option(help="Moog's own heave [m] at our neutral pose, 0 to -0.4572.")]


@dataclass(frozen=True, kw_only=True)
class Choices:
    """What the user chose; see the options of `run`."""

    incoming: str
    outgoing: str
    cueing: str
    platform: str
    dofs: str
    tuning: str | None
    axes: Path | None = None
    neutral_heave: float = -0.2
    pauses_silently: bool = False

    def session(self) -> "Session":
        """Return the session; every invalid choice is refused before anything is opened."""
        from otolith.live.shell.processes import Session
        from otolith.live.wire.axes import axes_from_toml
        from otolith.live.wire.sources import source_named

        source, listen = _address("--in", self.incoming)
        device, line = _address("--out", self.outgoing)
        axes = None if self.axes is None else files.read_text(self.axes, "axis map")
        park = (0.0, 0.0, self.neutral_heave if device == "moog" else 0.0, 0.0, 0.0, 0.0)
        return Session(
            platform=machine_named(self.platform, self.dofs),
            cueing=self.cueing,
            dofs=self.dofs,
            tuning=self.tuning,
            source=source_named(source, lambda name: files.read_text(Path(name), "file of channels")),
            listen=listen,
            driver=self._driver(device),
            device=line,
            park=park,
            period=PERIOD,
            axes=None if axes is None else axes_from_toml(axes, str(self.axes)),
            pauses_silently=self.pauses_silently,
            token=time.time_ns() & 0x7FFFFFFF,
        )

    def _driver(self, name: str) -> "Driver":
        from otolith.live.devices.generic import Generic
        from otolith.live.devices.moog import Moog

        if name == "moog":
            return Moog(interface="CDS7237", neutral_heave=self.neutral_heave)
        if name == "generic":
            return Generic(on_silence="falls")  # the strictest: it is braked before packets end
        raise InputError("device of --out", repr(name), one_of(DEVICES, name))


def run(
    incoming: Annotated[
        str, typer.Option("--in", metavar="URL", help="Telemetry, SOURCE+udp://HOST:PORT to listen on.")
    ],
    outgoing: Annotated[
        str, typer.Option("--out", metavar="URL", help="Device, moog+udp://HOST:PORT or generic+udp://…")
    ],
    cueing: CueingName = "predictive",
    platform: PlatformName = "davsi-4dof",
    dofs: Dofs = "surge-pitch,sway-roll",
    tuning: Tuning = None,
    axes: Annotated[
        Path | None, typer.Option(help="Axis map of the source, written by `otolith live learn`.")
    ] = None,
    neutral_heave: _Heave = -0.2,
    pauses_silently: Annotated[
        bool, typer.Option("--pauses-silently", help="The source sends nothing in its menus.")
    ] = False,
    seconds: Annotated[
        float | None,
        typer.Option(help="Arm and engage without a word, and park after this time.", min=1.0),
    ] = None,
) -> None:
    """Drive a platform. Words are read line by line: arm, engage, return, stop, park, rearm. Ctrl-C parks."""
    choices = Choices(
        incoming=incoming,
        outgoing=outgoing,
        cueing=cueing,
        platform=platform,
        dofs=dofs,
        tuning=tuning,
        axes=axes,
        neutral_heave=neutral_heave,
        pauses_silently=pauses_silently,
    )
    _drive(choices.session(), seconds)


def demo(
    seconds: Annotated[float, typer.Option(help="How long to be engaged.", min=1.0)] = 20.0,
    cueing: CueingName = "predictive",
    platform: PlatformName = "davsi-4dof",
    dofs: Dofs = "surge-pitch,sway-roll",
    tuning: Tuning = None,
) -> None:
    """Show a session in real time, with a virtual driver and a Moog base in software."""
    from otolith.live.shell.virtual import be_base, be_driver, free_port

    telemetry, base = free_port(), free_port()
    session = Choices(
        incoming=f"generic+udp://127.0.0.1:{telemetry}",
        outgoing=f"moog+udp://127.0.0.1:{base}",
        cueing=cueing,
        platform=platform,
        dofs=dofs,
        tuning=tuning,
    ).session()
    context = multiprocessing.get_context("spawn")
    helpers = [
        context.Process(target=target, args=(port,), daemon=True)
        for target, port in ((be_base, base), (be_driver, telemetry))
    ]
    try:
        for helper in helpers:
            helper.start()
        _drive(session, seconds)
    finally:
        for child in multiprocessing.active_children():
            child.kill()


def _address(option: str, url: str) -> tuple[str, tuple[str, int]]:
    """Return who is at a URL such as moog+udp://127.0.0.1:9910, and where."""
    bound = "a name and an address, e.g. forza+udp://127.0.0.1:5300"
    who, separator, rest = url.partition("+udp://")
    try:
        found = urlsplit(f"//{rest}")
        host, port = found.hostname, found.port
    except ValueError:
        host, port = None, None
    if not (who and separator and host and port):
        raise InputError(option, repr(url), bound)
    return who, (host, port)


def _drive(session: "Session", seconds: float | None) -> None:
    """Run a session until it is interrupted, or for a time."""
    from otolith.live.shell.supervise import Latched, Live, only_session

    console, begin = screen(stderr=False), time.monotonic()

    def tell(sentence: str) -> None:
        with contextlib.suppress(OSError):  # a terminal that was closed must not keep us from parking
            console.print(f"{time.monotonic() - begin:7.2f} s  {sentence}", highlight=False, soft_wrap=True)

    with only_session(session.device, tell) as lock:
        live = Live(session, tell, lock=lock)
        try:
            tell("starting; what is not compiled yet takes up to a minute")
            live.start()
            _converse(live, seconds)
        except Stopped:
            tell("asked to end: return, park, then the end")
            raise
        finally:
            live.end()
    if live.fault:
        raise Latched(live.fault)


def _converse(live: "Live", seconds: float | None) -> None:
    """Pass on words, those of the user or, for a time, our own."""
    from otolith.live.messages import State, Word

    engaged_at: float | None = None
    words = {State.IDLE: Word.ARM, State.READY: Word.ENGAGE}
    while live.alive("output"):
        state = live.look()
        if seconds is not None:
            if engaged_at is None and state in words:
                live.say(words[state])
            if engaged_at is None and state is State.ENGAGED:
                engaged_at = time.monotonic()
            if state is State.FAULT or (engaged_at is not None and time.monotonic() - engaged_at > seconds):
                return
            time.sleep(LOOK)
        elif not _listen(live):
            return


def _listen(live: "Live") -> bool:
    """Wait a moment for a word; return False where standard input has ended."""
    from otolith.live.messages import Word

    if not select.select([sys.stdin], [], [], LOOK)[0]:
        return True
    line = sys.stdin.readline()
    if not line:
        return False
    try:
        live.say(Word(line.strip().lower()))
    except ValueError:
        screen().print(f"{line.strip()!r} is no word: {', '.join(Word)}", highlight=False)
    return True
