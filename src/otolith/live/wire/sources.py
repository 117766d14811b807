"""All telemetry sources by the names that users write, with what each needs to know."""

from collections.abc import Callable
from typing import Final, NamedTuple

from otolith.core.errors import InputError, one_of
from otolith.live.wire.beamng import BeamNG
from otolith.live.wire.codemasters import custom, legacy
from otolith.live.wire.f1 import F1
from otolith.live.wire.forza import Forza
from otolith.live.wire.generic import Generic
from otolith.live.wire.joined import Joined
from otolith.live.wire.lfs import OutSim, OutSim2
from otolith.live.wire.source import Source
from otolith.live.wire.wrc import wrc

Read = Callable[[str], str]  # returns the text of a file that the user names


class Entry(NamedTuple):
    """How a source is named and made."""

    port: int  # UDP port that the game uses by default
    what: str  # for lists
    made: Callable[[str, Read], Source]  # from what follows the colon, and a reader of files
    needs: str = ""  # what must follow the colon
    may: str = ""  # what may follow it


def _plain(make: Callable[[], Source]) -> Callable[[str, Read], Source]:
    return lambda _text, _read: make()


SOURCES: Final = {
    "generic": Entry(9100, "our own packet, also from the bridge on Windows", _plain(Generic)),
    "forza": Entry(5300, "Forza Motorsport 7 and 2023, Horizon 4 to 6: data out", _plain(Forza)),
    "beamng": Entry(
        4444,
        "BeamNG.drive: MotionSim",
        lambda text, _read: BeamNG(text or "new"),
        may="old or new, the signs of the game's motionSim.lua",
    ),
    "codemasters": Entry(20777, "DiRT Rally 1 and 2: UDP with extradata 3", _plain(legacy)),
    "codemasters-custom": Entry(
        20777,
        "DiRT Rally 2 and others: custom_udp",
        lambda text, read: custom(read(text), text),
        needs="the game's XML file of channels",
    ),
    "wrc": Entry(
        20777,
        "EA SPORTS WRC",
        lambda text, read: wrc(read(text), text),
        needs="the game's JSON file of channels, telemetry/udp/NAME.json",
    ),
    "f1": Entry(20777, "F1 23 to 26", _plain(lambda: Joined(F1()))),
    "lfs": Entry(
        4123,
        "Live for Speed: OutSim",
        lambda text, _read: OutSim(text or "world"),
        may="world or car, the axes of its vectors",
    ),
    "lfs2": Entry(
        4123,
        "Live for Speed: OutSimPack2",
        lambda text, _read: OutSim2(_mask(text)),
        needs="OutSim Opts of the game's cfg.txt, such as 1ff",
    ),
}


def _mask(text: str) -> int:
    try:
        return int(text, 16)
    except ValueError:
        raise InputError("OutSim Opts of lfs2", repr(text), "a hexadecimal number, such as 1ff") from None


def source_named(text: str, read: Read) -> Source:
    """Return the source that a user names, such as ``forza``, ``beamng:old`` or ``wrc:otolith.json``.

    Parameters
    ----------
    read : returns the text of a file, for the sources that a file describes.

    Raises
    ------
    InputError : the name is unknown, or what follows the colon is missing, needless or wrong.
    """
    name, _, rest = text.partition(":")
    if name not in SOURCES:
        raise InputError("source", repr(name), one_of(SOURCES, name))
    entry = SOURCES[name]
    if entry.needs and not rest:
        raise InputError(f"source {name}", "alone", f"followed by a colon and {entry.needs}")
    if rest and not (entry.needs or entry.may):
        raise InputError(f"source {name}", f"followed by {rest!r}", "alone")
    return entry.made(rest, read)
