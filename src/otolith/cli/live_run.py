"""`otolith live run` and `live demo`: a session in real time."""

import contextlib
import select
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final
from urllib.parse import urlsplit

import typer

from otolith import files
from otolith.cli.commander import pages_of
from otolith.cli.durations import lasting
from otolith.cli.live_virtual import CueingName, Tuning
from otolith.cli.options import CUEING_HELP, Dofs, PlatformName
from otolith.cli.output import screen
from otolith.cli.stop import Stopped, unstoppable
from otolith.core.errors import InputError, one_of

if TYPE_CHECKING:
    from otolith.live.messages import Word
    from otolith.live.session import Session
    from otolith.live.shell.supervise import Live

DEVICES: Final = ("moog", "generic")
MACHINE: Final = "davsi-4dof"  # the platform of a session that names none
LOOK: Final = 0.02  # [s] between looks at the session, and at the words of pages
Incoming = Annotated[
    str | None, typer.Option("--in", metavar="URL", help="Telemetry, SOURCE+udp://HOST:PORT to listen on.")
]
Outgoing = Annotated[
    str | None, typer.Option("--out", metavar="URL", help="Device, moog+udp://HOST:PORT or generic+udp://…")
]
SessionFile = Annotated[
    Path | None, typer.Option(help="Session file (.toml); other options go before what it says.")
]
MachineName = Annotated[
    str | None, typer.Option(help="A shipped platform's name or a platform file (default: davsi-4dof).")
]
Pairs = Annotated[
    str | None, typer.Option(help="Axis pairs to cue, with commas (default: surge-pitch,sway-roll).")
]
Forward = Annotated[
    str | None,
    typer.Option(metavar="HOST:PORT", help="Who gets every packet too: another program on the same port."),
]
Heave = Annotated[
    float | None,
    typer.Option(help="Moog's own heave [m] at our neutral pose, 0 to -0.4572 (default: -0.2)."),
]


CommanderPort = Annotated[
    int | None,
    typer.Option(
        metavar="PORT", help="Show the session on a page, too: its address is printed; 0: any port."
    ),
]
LogFolder = Annotated[
    Path | None,
    typer.Option(
        metavar="FOLDER", help="Log the session to a new file there, for 'live replay' and 'live export'."
    ),
]


@dataclass(frozen=True, kw_only=True)
class Choices:
    """What the user chose; see the options of `run`. What is None is left to the session's file."""

    incoming: str | None = None
    outgoing: str | None = None
    cueing: str | None = None
    platform: str | None = None
    dofs: str | None = None
    tuning: str | None = None
    axes: Path | None = None
    neutral_heave: float | None = None
    pauses_silently: bool = False
    forward: str | None = None
    file: Path | None = None
    preset: str | None = None
    page_only: bool = False
    device: Mapping[str, Any] | None = None  # the fields of one in software, in place of any other

    def session(self) -> "Session":
        """Return the session; every invalid choice is refused before anything is opened."""
        from otolith.live.session import session_of
        from otolith.live.settings import settings_from
        from otolith.live.wire.axes import SECTION, axes_from, axes_from_toml
        from otolith.platforms.validation_messages import toml_fields

        source = "the command line" if self.file is None else self.file.name
        fields: dict[str, Any] = {"platform": MACHINE}
        if self.file is not None:
            fields = toml_fields(files.read_text(self.file, "session"), source)
        stated = fields.pop(SECTION, None)
        axes = None if stated is None else axes_from(stated, source)
        if self.axes is not None:
            axes = axes_from_toml(files.read_text(self.axes, "axis map"), str(self.axes))
        settings = settings_from(self._over(fields), source).under(self.preset)
        named = {"session": self.file, "axes": self.axes}
        return session_of(
            settings,
            axes,
            source=source,
            named={what: path for what, path in named.items() if path is not None},
            token=time.time_ns() & 0x7FFFFFFF,
        )

    def between(self, telemetry: int, base: int) -> "Choices":
        """Return the choices with the virtual driver and base of `otolith.live.shell.virtual`."""
        from otolith.live.shell.virtual import base_at

        return replace(self, incoming=f"generic+udp://127.0.0.1:{telemetry}", device=base_at(base))

    @contextlib.contextmanager
    def rehearsed(self) -> Iterator["Session"]:
        """Start a virtual driver and a base that goes as far as the platform; yield a session with both."""
        from otolith.live.shell.virtual import surroundings

        with surroundings(files.read_platform(self.platform or MACHINE)) as (telemetry, base):
            yield self.between(telemetry, base).session()

    def _over(self, fields: Mapping[str, Any]) -> dict[str, Any]:
        """Return the fields of a session's file with those that the command line states in their place."""
        given = {name: getattr(self, name) for name in ("cueing", "platform", "dofs", "tuning")}
        changed = {**fields, **{name: value for name, value in given.items() if value is not None}}
        if self.incoming is not None:
            source, listen = _address("--in", self.incoming)
            changed["input"] = {**changed.get("input", {}), "source": source, "listen": listen}
        if self.page_only:
            changed["page_only"] = True
        if self.device is not None:
            changed["device"] = dict(self.device)
        if self.pauses_silently and "input" in changed:
            changed["input"] = {**changed["input"], "pauses_silently": True}
        if self.forward is not None and "input" in changed:
            changed["input"] = {**changed["input"], "forward": self.forward}
        if self.outgoing is not None:
            kind, address = _address("--out", self.outgoing)
            if kind not in DEVICES:
                raise InputError("device of --out", repr(kind), one_of(DEVICES, kind))
            known: dict[str, Any] = changed.get("device", {})
            if known.get("kind") != kind:  # what the file says is of another device
                known = {"interface": "CDS7237", "neutral_heave_m": -0.2} if kind == "moog" else {}
            changed["device"] = {**known, "kind": kind, "address": address}
        if self.neutral_heave is not None and "device" in changed:
            changed["device"] = {**changed["device"], "neutral_heave_m": self.neutral_heave}
        for option, table in (("--in", "input"), ("--out", "device")):
            if table not in changed:
                raise InputError(option, "missing", f"given, or [{table}] in the file of --session")
        return changed


def run(
    incoming: Incoming = None,
    outgoing: Outgoing = None,
    session: SessionFile = None,
    preset: Annotated[str | None, typer.Option(help="A preset of the session file.")] = None,
    cueing: Annotated[str | None, typer.Option(help=f"{CUEING_HELP} (default: predictive)")] = None,
    platform: MachineName = None,
    dofs: Pairs = None,
    tuning: Tuning = None,
    axes: Annotated[
        Path | None, typer.Option(help="Axis map of the source, written by `otolith live learn`.")
    ] = None,
    neutral_heave: Heave = None,
    pauses_silently: Annotated[
        bool, typer.Option("--pauses-silently", help="The source sends nothing in its menus.")
    ] = False,
    log: LogFolder = None,
    page_only: Annotated[
        bool, typer.Option("--page-only", help="A program alone speaks; 5 s without a line end cueing.")
    ] = False,
    forward: Forward = None,
    seconds: Annotated[
        float | None,
        lasting("Arm and engage without a word, and park after this time", least=1.0),
    ] = None,
    commander: CommanderPort = None,
    allow_jitter: Annotated[
        bool, typer.Option("--allow-jitter", help="Arm without, or in spite of, 'otolith live check'.")
    ] = False,
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
        forward=forward,
        file=session,
        preset=preset,
        page_only=page_only,
    )
    drive(permitted(choices.session(), allow_jitter=allow_jitter), seconds, log, page=commander)


def permitted(session: "Session", *, allow_jitter: bool) -> "Session":
    """Return a session that says why it must not be armed: what was not tested, or tested too late."""
    from otolith.live.permits import why_late, why_untested
    from otolith.live.shell.processes import OUTPUT
    from otolith.live.shell.rights import real_time_is_granted

    forbids = why_untested(session)
    if not forbids and not allow_jitter:
        forbids = why_late(real_time=real_time_is_granted(OUTPUT))
    return replace(session, forbids=forbids)


def demo(
    seconds: Annotated[float, lasting("How long to be engaged", least=1.0)] = 20.0,
    cueing: CueingName = "predictive",
    platform: PlatformName = "davsi-4dof",
    dofs: Dofs = "surge-pitch,sway-roll",
    tuning: Tuning = None,
    log: LogFolder = None,
    commander: CommanderPort = None,
) -> None:
    """Show a session in real time, with a virtual driver and a Moog base in software."""
    with Choices(cueing=cueing, platform=platform, dofs=dofs, tuning=tuning).rehearsed() as session:
        drive(session, seconds, log, page=commander)


def _address(option: str, url: str) -> tuple[str, str]:
    """Return who is at a URL such as moog+udp://127.0.0.1:9910, and the address."""
    bound = "a name and an address, e.g. forza+udp://127.0.0.1:5300"
    who, separator, rest = url.partition("+udp://")
    try:
        found = urlsplit(f"//{rest}")
        host, port = found.hostname, found.port
    except ValueError:
        host, port = None, None
    if not (who and separator and host and port):
        raise InputError(option, repr(url), bound)
    return who, rest


def drive(
    session: "Session",
    seconds: float | None,
    log: Path | None = None,
    *,
    stderr: bool = False,
    page: int | None = None,
) -> "Live":
    """Run a session until it is interrupted, or for a time; return it as it ended.

    Parameters
    ----------
    page : port on which the Commander shows it; None for no page.

    Raises
    ------
    Latched : the supervisor had to end it.
    NotEngaged : it was to be cued for a time, and may not arm or could not be engaged.
    """
    from otolith.live.shell.supervise import Latched, Live, only_session
    from otolith.live.shell.timed import PATIENCE, NotEngaged

    console, begin = screen(stderr=stderr), time.monotonic()

    if seconds is not None and session.forbids:
        raise NotEngaged(f"this session cannot be armed, so not be cued for {seconds:g} s: {session.forbids}")
    also: list[Callable[[str], None]] = []

    def tell(sentence: str) -> None:
        with contextlib.suppress(OSError):  # a terminal that was closed must not keep us from parking
            console.print(f"{time.monotonic() - begin:7.2f} s  {sentence}", highlight=False, soft_wrap=True)
        for listener in also:
            listener(sentence)

    with only_session(session.device, tell) as lock, contextlib.ExitStack() as stack:
        live = Live(session, tell, lock=lock, log=log)
        try:
            tell("starting; what is not compiled yet takes up to a minute")
            if not session.driver.reports:
                tell("open loop: the device reports nothing, so nothing that it does is known or supervised")
            if session.forbids:
                tell(f"this session cannot be armed: {session.forbids}")
            if seconds is not None:
                tell(f"it arms by itself, parks after {seconds:g} s, and ends if it waits for {PATIENCE:g} s")
            pages = None if page is None else stack.enter_context(pages_of(live, session, page, tell))
            also.extend(() if pages is None else (pages.tell,))

            def of_pages() -> tuple["Word", ...]:
                return () if pages is None else pages.words(tell)

            meanwhile = Meanwhile(of_pages, tell)
            live.start(meanwhile.look)
            if meanwhile.stopped and seconds is not None:
                tell("stopped by hand before it armed")
            else:
                _converse(live, seconds, of_pages)
        except Stopped:
            tell("asked to end: return, park, then the end")
            raise
        finally:
            with unstoppable():  # a second Ctrl-C must not leave processes behind
                live.end()
    if live.fault:
        raise Latched(live.fault)
    return live


class Meanwhile:
    """Answers words of pages while a session starts: nothing moves yet, so none of them is carried out.

    An *arm* that had waited for a compiler would act when nobody expects it any more.
    """

    def __init__(self, of_pages: Callable[[], tuple["Word", ...]], tell: Callable[[str], None]) -> None:
        self._of_pages, self._tell, self.stopped = of_pages, tell, False

    def look(self) -> None:
        """Answer the words that have been said since the last call."""
        for word in self._of_pages():
            self._tell(f"{word}: the session is still starting, and nothing moves")
            self.stopped = self.stopped or word == "stop"


def _converse(live: "Live", seconds: float | None, of_pages: Callable[[], tuple["Word", ...]]) -> None:
    """Pass on words, those of the user and of pages or, for a time, our own."""
    from otolith.live.shell.timed import cued_for

    def pages() -> None:
        if said := of_pages():
            live.say(*said)

    if seconds is not None:
        cued_for(live, seconds, pages)
        return
    while live.alive("output"):
        live.look()
        pages()
        if not _listen(live):
            return


def _listen(live: "Live") -> bool:
    """Wait a moment for a word; return False where standard input has ended."""
    from otolith.live.messages import Word

    if not select.select([sys.stdin], [], [], LOOK)[0]:
        return True
    line = sys.stdin.readline()
    if not line:
        return False
    live.sign()
    if not line.strip():
        return True
    try:
        live.say(Word(line.strip().lower()))
    except ValueError:
        screen().print(f"{line.strip()!r} is no word: {', '.join(Word)}", highlight=False)
    return True


def measure(session: "Session", seconds: float, *, stderr: bool) -> "Live":
    """Run a session for a time in order to read its timing; return it as it ended.

    Raises
    ------
    Latched : as by `drive`; or it ended before a decision was timed, so there is nothing to read.
    """
    from otolith.live.shell.supervise import Latched

    live = drive(session, seconds, stderr=stderr)
    if live.controller_timing.cpu.count == 0:
        raise Latched(
            "the session ended before the platform was cued, so nothing was measured; see above why"
        )
    return live
