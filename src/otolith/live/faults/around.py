"""Faults of what stands around a session: rows 15, 16, 18 to 21: its log, page, clocks, files.

Files are made in a temporary folder of this machine: reading them is not of the virtual world.
"""

import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final
from unittest import mock

from otolith import files
from otolith.core.errors import OtolithError
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_problem
from otolith.live.faults.case import Aftermath, Case
from otolith.live.faults.processes import stopped
from otolith.live.messages import State
from otolith.live.session import session_of
from otolith.live.settings import narrowed, settings_from_toml
from otolith.live.virtual_log import VirtualLog
from otolith.live.world import World
from otolith.mpqp import enumerate_regions
from otolith.platforms import load

SMALL: Final = 1 << 16  # [bytes] of rings that are soon full
HOUR: Final = 3600.0  # [s]
SESSION: Final = """
platform = "davsi-4dof"
cueing = "classical"
tuning = "davsi"
[input]
source = "generic"
listen = "127.0.0.1:9100"
[device]
kind = "generic"
address = "127.0.0.1:9910"
"""

DESK: Final = """
[device.template]
frame = "<255><Axis1a>"
axes = [{ follows = "surge", low = -0.1, high = 0.1 }]
bits = 16
park_heave_m = -0.1
"""


class _Twin:
    """A case in which the loop must go on as without the fault, bit for bit, and a lamp says what is wrong.

    Parameters
    ----------
    fault : begins in the world, which is logged.
    words : that the lamp shows 2.5 s after the fault; none: it is dark.
    """

    def __init__(self, fault: Callable[[World], None], *words: str) -> None:
        self._fault, self._words = fault, words
        self._lamp = ""
        self._twin: World | None = None

    def begin(self, world: World) -> None:
        """Keep a world without the fault, and begin it."""
        self._twin = world.again()
        world.record(VirtualLog(capacity=SMALL))
        self._fault(world)
        world.at(world.seconds + 2.5, lambda: self._look(world))

    def _look(self, world: World) -> None:
        self._lamp = "" if world.log is None else world.log.lamp(world.now_ns)

    def holds(self, after: Aftermath) -> bool:
        """Return whether the trace is that of the world without the fault, and the lamp is lit."""
        world, twin = after.world, self._twin
        lit = all(word in self._lamp for word in self._words) if self._words else not self._lamp
        if twin is None or not lit:
            return False
        twin = twin.again().run(world.seconds)  # the algorithm begins where it began
        motions = [[row.motion.tobytes() for row in one.trace] for one in (world, twin)]
        return motions[0] == motions[1] and after.unchanged


def _full(world: World) -> None:
    if world.log is not None:
        world.log.disk.free = 1000


def _late(world: World) -> None:
    world.stop("recorder", 10.0)


class _Page:
    """A page that alone commands, or one of two who do, and that dies."""

    def __init__(self, *, alone: bool) -> None:
        self._alone = alone

    def begin(self, world: World) -> None:
        """Let it live for 1.5 s, and die."""
        world.page_only = self._alone
        world.command_by_page()
        world.at(world.seconds + 1.5, lambda: world.stop("page"))

    def holds(self, after: Aftermath) -> bool:
        """Return whether cueing ended 5 s after its last sign, which was given at 1 s, or did not end."""
        if not self._alone:
            return after.unchanged
        return 5.9 <= after.after(State.RETURNING) <= 6.3 and "no sign of the page" in after.reason(
            State.RETURNING
        )


def _clock_jumps(world: World) -> None:
    """Let the system's time go on by an hour, and back by one: nothing may ask for it."""
    for at, jump in ((0.2, HOUR), (0.6, -HOUR)):
        shifted = mock.patch.multiple(
            time, time=lambda jump=jump: HOUR + jump, time_ns=lambda jump=jump: round(1e9 * (HOUR + jump))
        )
        world.at(world.seconds + at, shifted.start)
        world.at(world.seconds + at + 0.3, shifted.stop)


class _Refused:
    """A case in which something about files is answered by a sentence, and the session goes on."""

    def __init__(self, attempt: Callable[[Path], str], *words: str) -> None:
        self._attempt, self._words, self._said = attempt, words, ""

    def begin(self, _: World) -> None:
        """Try it in a folder of its own."""
        with tempfile.TemporaryDirectory() as folder:
            self._said = self._attempt(Path(folder))

    def holds(self, after: Aftermath) -> bool:
        """Return whether all words were said, and the session stayed as it was."""
        return after.unchanged and all(word in self._said for word in self._words)


def _said(action: Callable[[], object]) -> str:
    try:
        action()
    except OtolithError as error:
        return str(error)
    return ""


def _settings(_: Path, *, lines: str = "", instead: tuple[str, str] = ("", "")) -> str:
    """Read a session file with further lines, or with others in place of some."""
    text = (SESSION.replace(*instead) if instead[0] else SESSION) + lines

    def read() -> None:
        settings = settings_from_toml(text, "session.toml")
        narrowed(load("davsi-4dof"), settings.limits, "session.toml")
        session_of(settings, None, source="session.toml", named={})

    return _said(read)


def _changed(folder: Path) -> str:
    """Change the platform's file and the session's while a session runs, and ask as arming does."""
    mine, stated = folder / "mine.toml", folder / "session.toml"
    text = (Path(files.__file__).parent / "platforms" / "catalog" / "davsi-4dof.toml").read_text("utf-8")
    mine.write_text(text, "utf-8")
    stated.write_text(SESSION.replace('"davsi-4dof"', f'"{mine}"'), "utf-8")
    settings = settings_from_toml(stated.read_text("utf-8"), stated.name)
    session = session_of(settings, None, source=stated.name, named={"session": stated})
    before = session.changed()
    mine.write_text(text.replace("0.267", "0.3"), "utf-8")
    stated.unlink()
    return f"{len(before)} before; {'; '.join(session.changed())}"


def _laws(folder: Path, *, damage: Callable[[bytearray], None] | None, platform: str = "davsi-4dof") -> str:
    """Start with laws that are of another platform, or damaged."""
    path = folder / "laws.h5"
    limits, braking = load(platform).limits(SURGE_PITCH), load(platform).braking
    law = enumerate_regions(explicit_problem(SURGE_PITCH, limits, braking, ExplicitSettings(horizon=2)))
    files.write_laws([law], path)
    if damage is not None:
        data = bytearray(path.read_bytes())
        damage(data)
        path.write_bytes(data)
    text = SESSION.replace('"classical"', f'"explicit"\nlaws = "{path}"\ndofs = "surge-pitch"').replace(
        'tuning = "davsi"', ""
    )
    settings = settings_from_toml(text, "session.toml")
    return _said(lambda: session_of(settings, None, source="session.toml", named={}))


def _one_bit(data: bytearray) -> None:
    data[-100] ^= 1


def _other_file(data: bytearray) -> None:
    data[:20] = b"Otolith of last year"


_LOGGED: Final = tuple(
    (row, fault, _Twin(begin, *words))
    for row, fault, begin, words in (
        ("15a", "the disk is full", _full, ("No space left on device", "ticks are missing")),
        ("15b", "the recorder dies", stopped("recorder"), ("its recorder has said nothing", "are missing")),
        ("15c", "the recorder is 10 s late", _late, ("its recorder has said nothing", "are missing")),
        ("18d", "the system's time jumps by an hour, and back", _clock_jumps, ()),
    )
)
_PAGES: Final = {"16a": _Page(alone=True), "16b": _Page(alone=False)}
_FILES: Final = tuple(
    (row, fault, _Refused(attempt, *words))
    for row, fault, attempt, words in (
        (
            "19a",
            "radians in place of degrees",
            partial(_settings, lines="[limits.pitch]\nangle_deg = 0.1"),
            ("limits.pitch.angle_deg in session.toml is 0.1", "between 1 and 89 deg", "in rad?"),
        ),
        (
            "19b",
            "a lower end above the upper one",
            partial(_settings, lines="[limits.surge]\nposition_m = [0.1, -0.1]"),
            ("limits.surge.position_m in session.toml", "low < 0 < high, in m"),
        ),
        (
            "19c",
            "tilting at more than 10 deg/s",
            partial(_settings, lines="[limits]\ntilt_pitch_degps = 12"),
            ("limits.tilt_pitch_degps in session.toml is 12", "between 0.5 and 10 deg/s"),
        ),
        (
            "19d",
            "a limit wider than the platform's",
            partial(_settings, lines="[limits.surge]\nvelocity_mps = 0.5"),
            ("limits.surge.velocity_mps in session.toml is 0.5 m/s", "at most 0.267 m/s, as the platform's"),
        ),
        (
            "19f",
            "a platform wider than the device's range",
            partial(_settings, lines=DESK, instead=('kind = "generic"', 'kind = "template"')),
            ("range of <Axis1a> of template, which follows surge, is -0.1 to 0.1 m", "at least -0.1"),
        ),
        (
            "19e",
            "the profile thesis",
            partial(_settings, instead=("davsi-4dof", "thesis")),
            ("platform is thesis", "limits that no machine has"),
        ),
        (
            "20",
            "the files of platform and session change while it runs",
            _changed,
            (
                "0 before",
                "SHA-256 of platform",
                "session.toml is no longer there",
            ),
        ),
        (
            "21a",
            "one bit of an explicit table is wrong",
            partial(_laws, damage=_one_bit),
            ("does not match its SHA-256",),
        ),
        (
            "21b",
            "an explicit table of another version",
            partial(_laws, damage=_other_file),
            ("an earlier version wrote it",),
        ),
        (
            "21c",
            "an explicit table of another platform",
            partial(_laws, damage=None, platform="davsi"),
            ("the stored law's model is", "of platform davsi-4dof as chosen"),
        ),
    )
)

AROUND_CASES: Final = (
    *(
        Case(
            row=row,
            fault=fault,
            expected="the loop goes on bit for bit as without it; a lamp, and a count of what is missing"
            if row.startswith("15")
            else "the loop goes on bit for bit as without it",
            begin=case.begin,
            holds=case.holds,
            seconds=3.0,
        )
        for row, fault, case in _LOGGED
    ),
    Case(
        row="16a",
        fault="the page that alone commands a session dies",
        expected="R3 5 s after its last sign",
        begin=_PAGES["16a"].begin,
        holds=_PAGES["16a"].holds,
        seconds=8.0,
    ),
    Case(
        row="16b",
        fault="a page dies while somebody else commands, too",
        expected="unchanged",
        begin=_PAGES["16b"].begin,
        holds=_PAGES["16b"].holds,
        seconds=8.0,
    ),
    Case(
        row="18c",
        fault="the machine is suspended for 1.1 s",
        expected="as a restart: R4, and not engaged again by itself",
        begin=stopped("output", "controller", "supervisor", "device", seconds=1.1),
        holds=lambda after: "no tick for" in after.reason(State.FAULT) and after.world.state is State.FAULT,
        seconds=3.0,
        device_fails=True,
    ),
    *(
        Case(
            row=row,
            fault=fault,
            expected="refused by field, value, bound and unit"
            if row.startswith("19")
            else "refused before anything is opened"
            if row.startswith("21")
            else "the session goes on with what it read; whoever arms is told",
            begin=case.begin,
            holds=case.holds,
            seconds=0.5,
        )
        for row, fault, case in _FILES
    ),
)
