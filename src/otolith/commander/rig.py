"""A rig as its builder describes it in the page: device, telemetry, algorithm; and the session made of it.

The form is kept as `rig.json` in the Commander's folder. From it comes `rig.toml`, a session file for
`otolith live run --session`, which is judged by the same code.
"""

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from otolith.commander.schema import FILE, PLATFORM_WORDS, Offered, checked_as, is_file, setting
from otolith.commander.session import CHANNELS, MAPS, PLATFORMS
from otolith.core.disk import read_text, write_text
from otolith.core.errors import InputError, OtolithError
from otolith.core.frames import AXES
from otolith.core.toml import toml_value
from otolith.live.axis_test import movable
from otolith.live.permits import why_late, why_untested
from otolith.live.session import Session, session_of
from otolith.live.settings import settings_from
from otolith.live.shell.processes import OUTPUT
from otolith.live.shell.rights import real_time_is_granted
from otolith.live.wire.axes import AxisMap, axes_from_toml, with_axes
from otolith.live.wire.sources import SOURCES
from otolith.registry import CUEING as ALGORITHMS
from otolith.registry import LIVE

KEPT, FILE_OF_SESSION = "rig.json", "rig.toml"
WHERE: Final = "the rig"  # for errors
OURS: Final = "generic"  # a source that is in our axes already
DESCRIBED: Final = tuple(name for name, one in SOURCES.items() if "file" in one.needs)  # by the game's file
CUEING: Final = tuple(name for name in LIVE if "hint" not in ALGORITHMS.own[name].reads)
# Of these, a word says which of their packets is meant.
VARIED: Final = tuple(
    name for name, one in SOURCES.items() if (one.may or one.needs) and name not in DESCRIBED
)
DEVICE, TELEMETRY, RIDE, MACHINE = "Device", "Telemetry", "First ride", "Platform"  # groups
_ADDRESS: Final = r"^[A-Za-z0-9_.:\[\]-]{1,100}$"
_HOST: Final = "a host and a port, such as 127.0.0.1:5300"
_RENAMED: Final = {"kind": "device", "axis": "axes", "range": "axes", "OutSim": "variant"}


class Rig(Offered):
    """What a session needs to know beside its limits, with the words of the page."""

    platform: str = setting(
        MACHINE,
        "davsi-4dof",
        "Platform",
        "(your platform file) = (its reach, speeds and legs are the limits of every set-point)",
        max_length=70,
        words=PLATFORM_WORDS,
    )
    dofs: str = setting(
        MACHINE,
        "surge-pitch,sway-roll",
        "What is cued",
        "(more) = (more of the drive is felt; the platform needs these axes)",
        among=("surge-pitch", "sway-roll", "surge-pitch,sway-roll", "surge-pitch,sway-roll,heave,yaw"),
    )
    device: str = setting(
        DEVICE,
        "moog",
        "Device",
        "(moog) = (a Moog base); (template) = (SimTools, Thanos and their like: bytes as you state them)",
        among=("moog", "template", "generic"),
    )
    address: str = setting(
        DEVICE,
        "127.0.0.1:9910",
        "Address",
        "(host:port of UDP) = (where set-points are sent)",
        pattern=_ADDRESS,
        words="a host and a port, such as 192.168.0.10:9910",
    )
    interface: str = setting(
        DEVICE,
        "CDS7237",
        "Interface",
        "(the document that the base follows) = (the layout of its packets)",
        among=("CDS7237", "CDS7330"),
        of=("moog",),
    )
    neutral_heave_m: float = setting(
        DEVICE,
        -0.2,
        "Base's own heave at neutral",
        "(measure it) = (where the base stands when ours is 0)",
        unit="m",
        ge=-0.4572,
        le=0.0,
        of=("moog",),
    )
    reach: str = setting(
        DEVICE,
        "public",
        "Reach of the base",
        "(public) = (figures of a small one); (platform) = (as the platform's file says, where you know)",
        among=("public", "platform"),
        of=("moog",),
    )
    frame: str = setting(
        DEVICE,
        "<255><255><Axis1a><Axis2a><10><13>",
        "Bytes of a set-point",
        "(<255> a byte, <Axis1a> the code of axis 1, all else itself) = (what is sent)",
        max_length=200,
        words="a text of at most 200 characters",
        of=("template",),
    )
    axes: str = setting(
        DEVICE,
        "surge -0.12 0.15; pitch -12 12",
        "Axes of the device",
        "(what each follows, its value at code 0 and at the largest; m or deg; or leg1 …) = (the codes)",
        max_length=300,
        words="such as surge -0.12 0.15; pitch -12 12",
        of=("template",),
    )
    bits: int = setting(
        DEVICE,
        16,
        "Bits of a code",
        "(more) = (finer steps; the device says how many it reads)",
        ge=1,
        le=32,
        of=("template",),
    )
    form: str = setting(
        DEVICE,
        "big",
        "Form of a code",
        "(big, little) = (bytes, the high one first or last); (decimal, hex) = (text)",
        among=("big", "little", "decimal", "hex"),
        of=("template",),
    )
    park_heave_m: float = setting(
        DEVICE,
        0.0,
        "Heave without power",
        "(measure it) = (where the platform rests when nothing holds it, from neutral)",
        unit="m",
        ge=-2.0,
        le=2.0,
        of=("template",),
    )
    on_silence: str = setting(
        DEVICE,
        "",
        "When packets stop, the device",
        "(falls) = (it is braked before they stop); empty: what is known of the device, or falls",
        among=("", "holds", "parks", "falls"),
    )
    source: str = setting(
        TELEMETRY,
        OURS,
        "Game",
        "(who sends) = (how its packets are read)",
        among=tuple(SOURCES),
    )
    variant: str = setting(
        TELEMETRY,
        "",
        "Variant",
        "(beamng: old or new; lfs: world or car; lfs2: OutSim Opts such as 1ff) = (its packets)",
        pattern=r"^[a-z0-9]{0,8}$",
        words="at most 8 letters and digits, or empty",
        of=VARIED,
    )
    channels: str = setting(
        TELEMETRY,
        "",
        "The game's file of channels",
        "(wrc: telemetry/udp/NAME.json; codemasters-custom: its .xml) = (what stands in a packet)",
        pattern=f"^({FILE})?$",
        words="the name of a file that was opened here, or empty",
        of=DESCRIBED,
    )
    listen: str = setting(
        TELEMETRY,
        "127.0.0.1:9100",
        "Listen on",
        "(host:port of UDP; 0.0.0.0 for other machines) = (where the game sends to)",
        pattern=_ADDRESS,
        words=_HOST,
    )
    pauses_silently: bool = setting(
        TELEMETRY, False, "Silent in its menus", "(yes) = (silence is a pause, not a fault)"
    )
    map: str = setting(
        TELEMETRY,
        "",
        "Axis map",
        "(learned below) = (which channel is forward, left and up); empty: it is in our axes already",
        pattern=f"^({FILE})?$",
        words="a name of letters, digits, dots, dashes and underscores, or empty",
    )
    cueing: str = setting(
        RIDE, "predictive", "Algorithm", "(an algorithm) = (turns forces into motion)", among=CUEING
    )
    tuning: str = setting(
        RIDE,
        "",
        "Tuning of a washout",
        "(a shipped tuning) = (gains and corner frequencies of classical, optimal, adaptive)",
        among=("", "davsi", "thesis"),
    )
    liveliness: float = setting(
        RIDE, 0.5, "Liveliness of predictive", "(larger) = (more travel is spent)", ge=0.0, le=1.0
    )
    scale: float = setting(
        RIDE, 0.3, "Scale", "(small for the first ride) = (weaker forces, less travel)", ge=0.01, le=1.0
    )

    @property
    def sender(self) -> str:
        """Return the source as the command line names it, and a file of the game's by its plain name.

        Raises
        ------
        InputError : the game's packets are described by a file of its own, and none is named.
        """
        if self.source in DESCRIBED and not self.channels:
            raise InputError("channels", "empty", SOURCES[self.source].needs)
        rest = self.channels if self.source in DESCRIBED else self.variant if self.source in VARIED else ""
        return f"{self.source}:{rest}" if rest else self.source


def fields_of(rig: Rig, folder: Path) -> dict[str, Any]:
    """Return the fields of the session file of a rig."""
    moog = {name: getattr(rig, name) for name in ("interface", "neutral_heave_m", "reach")}
    device: dict[str, Any] = {"kind": rig.device, "address": rig.address}
    device |= moog if rig.device == "moog" else {}
    device |= {"on_silence": rig.on_silence} if rig.on_silence else {}
    if rig.device == "template":
        given = {name: getattr(rig, name) for name in ("frame", "bits", "form", "park_heave_m")}
        device["template"] = {**given, "axes": _axes(rig.axes)}
    stated: dict[str, Any] = {name: getattr(rig, name) for name in ("cueing", "dofs", "liveliness", "scale")}
    platform = str(folder / PLATFORMS / rig.platform) if is_file(rig.platform) else rig.platform
    sender = rig.sender
    if rig.source in DESCRIBED:
        sender = f"{rig.source}:{folder / CHANNELS / rig.channels}"
    return {
        "platform": platform,
        **stated,
        **({"tuning": rig.tuning} if rig.tuning else {}),
        "input": {"source": sender, "listen": rig.listen, "pauses_silently": rig.pauses_silently},
        "device": device,
    }


def _axes(text: str) -> list[dict[str, Any]]:
    """Return the axes of a template; degrees become radians."""
    found = []
    for one in filter(str.strip, text.split(";")):
        words = one.split()
        try:
            follows, low, high = words[0], float(words[1]), float(words[2])
        except (IndexError, ValueError):
            raise InputError("axes", repr(one.strip()), "such as surge -0.12 0.15") from None
        size = math.pi / 180.0 if follows in AXES[3:] else 1.0
        found.append({"follows": follows, "low": size * low, "high": size * high})
    return found


def session_of_rig(rig: Rig, folder: Path) -> Session:
    """Return the session of a rig; whatever is wrong is refused as by `otolith live run --session`.

    Raises
    ------
    InputError, CorruptFile : a value, the platform's file or the axis map is refused.
    """
    return session_of(
        settings_from(fields_of(rig, folder), WHERE), map_of(rig, folder), source=WHERE, named={}
    )


def map_of(rig: Rig, folder: Path) -> AxisMap | None:
    """Return the axis map that a rig names; None if it names none."""
    if not rig.map:
        return None
    return axes_from_toml(read_text(folder / MAPS / rig.map, "axis map"), rig.map)


def channels_of(folder: Path, name: str) -> str:
    """Return the text of a file of a game's by its plain name; any other is refused.

    Raises
    ------
    InputError : it is no plain name, or there is no such file.
    """
    if re.fullmatch(FILE, name) is None:
        raise InputError("channels", repr(name), "the name of a file that was opened here")
    return read_text(folder / CHANNELS / name, "file of channels")


def read_rig(folder: Path) -> Rig:
    """Return the rig that is kept in a folder; the default where there is none."""
    place = folder / KEPT
    return checked_as(Rig, json.loads(read_text(place, "rig"))) if place.is_file() else Rig()


def keep_rig(rig: Rig, folder: Path) -> Path:
    """Write a rig, and the session file of it; return where the session file is."""
    axes, place = map_of(rig, folder), folder / FILE_OF_SESSION
    text = "# Written by the Commander: a change here is lost when the rig is saved there.\n"
    text += to_toml(fields_of(rig, folder))
    write_text(place, text if axes is None else with_axes(text, place.name, axes))
    write_text(folder / KEPT, json.dumps(rig.model_dump(), indent=2) + "\n")
    return place


def to_toml(fields: Mapping[str, Any], path: str = "") -> str:
    """Return fields as TOML: values first, then tables."""
    values = [f"{name} = {_value(one)}\n" for name, one in fields.items() if not isinstance(one, Mapping)]
    tables = [
        f"\n[{path}{name}]\n{to_toml(one, f'{path}{name}.')}"
        for name, one in fields.items()
        if isinstance(one, Mapping)
    ]
    return "".join([*values, *tables])


def _value(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{name} = {_value(one)}' for name, one in value.items())} }}"
    return toml_value(value)


def field_of(error: InputError) -> str:
    """Return the field of the form that an error is about; empty if it is none."""
    name = error.field.partition(" ")[0].split(".")[-1]
    name = "map" if error.field.startswith("axis map") else _RENAMED.get(name, name)
    return name if name in Rig.model_fields else ""


def lacking(folder: Path) -> list[dict[str, Any]]:
    """Return what must be in order before a rig is ridden, each with a sentence and the step it leads to."""
    if not (folder / KEPT).is_file():
        return [_check("rig", "device", "nothing is kept yet: say which platform and device it is")]
    rig = read_rig(folder)
    try:
        session = session_of_rig(rig, folder)
    except OtolithError as error:
        return [_check("rig", "device", str(error))]
    checks = [_check("rig", "device", "", f"{rig.platform} on {rig.device} at {rig.address}")]
    evidence = None if session.axes is None else dict(session.axes.evidence)
    told = "in our axes already" if evidence is None else f"{rig.map}, learned with {evidence}"
    unknown = rig.source != OURS and evidence is None
    why = f"the axes of {rig.source} are not known: learn them, or choose a map" if unknown else ""
    return [
        *checks,
        _check("telemetry", "telemetry", why, told),
        _check("this computer", "check", why_late(real_time=real_time_is_granted(OUTPUT)), "wakes in time"),
        _check("axes", "axis", why_untested(session), "all were seen to move as they should"),
    ]


def _check(name: str, leads: str, why: str, passed: str = "") -> dict[str, Any]:
    return {"name": name, "leads": leads, "ok": not why, "sentence": why or passed}


def axes_to_test(session: Session) -> list[str]:
    """Return the axes that a session's platform moves, in the order of their test."""
    return movable(session.gate())
