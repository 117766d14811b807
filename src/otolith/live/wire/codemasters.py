"""Codemasters' rally games: the fixed packet of 264 bytes, and custom_udp, whose XML file names its
channels.

Source: Codemasters' note on UDP output (DiRT 4) and public readers of both formats. The fixed packet (DiRT
Rally 1 and 2, extradata = 3) is 66 floats; it has lateral and longitudinal force in g, no vertical one and
no rates. An XML file holds one element per channel, `<float channel="speed" scale="1.0"/>`; the game
multiplies by `scale`. Which way the forces count is not documented: `learned` finds it.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final
from xml.etree.ElementTree import Element, ParseError, TreeBuilder, XMLParser

from otolith.core.errors import InputError, one_of
from otolith.live.wire.channels import Channels, Names
from otolith.live.wire.formats import Field, Packet

MOST_CHANNELS: Final = 512


def _each(prefix: str, suffixes: str = "x y z") -> tuple[str, ...]:
    return tuple(f"{prefix}{one}" for one in suffixes.split())


NAMES: Final = Names(
    force_car=("gforce_longitudinal", "gforce_lateral", "gforce_vertical"),
    velocity_world=_each("velocity_"),
    velocity_car=_each("local_velocity_"),
    position=_each("position_"),
    forward=_each("forward_dir_"),
    left=_each("left_dir_"),
    rate=("roll_velocity", "pitch_velocity", "yaw_velocity"),
    time="total_time",
    paused="paused",
)
_LEGACY_NAMES: Final = Names(
    force_car=("gforce_longitudinal", "gforce_lateral", ""),
    velocity_world=NAMES.velocity_world,
    position=NAMES.position,
    forward=NAMES.forward,
    left=NAMES.left,
    time=NAMES.time,
)
# channel -> unit; all others are read and not used
UNITS: Final = {
    **dict.fromkeys(NAMES.force_car, "g"),
    **dict.fromkeys(NAMES.velocity_world, "m/s"),
    **dict.fromkeys(NAMES.velocity_car, "m/s"),
    **dict.fromkeys(NAMES.position, "m"),
    **dict.fromkeys(NAMES.forward, "unit"),
    **dict.fromkeys(NAMES.left, "unit"),
    **dict.fromkeys(NAMES.rate, "rad/s"),
    "total_time": "s",
    "speed": "m/s",
}
_TYPES: Final = {"float": "f32", "int32": "i32", "uint32": "u32", "double": "f64", "uint64": "u64"}


def _single(*names: str) -> Iterator[Field]:
    return (Field(name=name, type="f32", unit=UNITS.get(name, "")) for name in names)


LEGACY: Final = Packet(
    name="Codemasters packet",
    fields=(
        *_single("total_time", "lap_time", "lap_distance", "total_distance"),  # 0
        *_single(*NAMES.position, "speed", *NAMES.velocity_world),  # 16, 28, 32
        *_single(*NAMES.left, *NAMES.forward),  # 44, 56
        Field(name="suspension, wheels, pedals, gear", type="pad", count=68),  # 68
        *_single("gforce_lateral", "gforce_longitudinal"),  # 136, 140
        Field(name="lap, engine, brakes, tyres", type="pad", count=120),  # 144
    ),
)


def legacy() -> Channels:
    """Return the source of the fixed packet of 264 bytes."""
    return Channels("codemasters", LEGACY, _LEGACY_NAMES)


def custom(xml: str, source: str) -> Channels:
    """Return the source of a custom_udp packet.

    Parameters
    ----------
    xml : text of the game's XML file that names the channels.
    source : the file's name, for errors.

    Raises
    ------
    InputError : the text is not such a file, declares a document type or entities, or names no force.
    """
    root = _parsed(xml, source)
    if root.tag != "custom_udp":
        raise InputError(f"first element of {source}", repr(root.tag), "custom_udp")
    if len(root) > MOST_CHANNELS:
        raise InputError(f"channels of {source}", len(root), f"at most {MOST_CHANNELS}")
    magic, fields = b"", []
    for number, one in enumerate(root, start=1):
        if one.tag.lower() == "fourcc":
            code = one.get("value", "").encode("ascii", "replace")
            if number == 1 and len(code) == 4:
                magic = code
            else:
                fields.append(Field(name=f"fourcc {number}", type="pad", count=4))
        else:
            fields.append(_channel(one, f"element {number} of {source}"))
    _check_names(fields, source)
    packet = Packet(name=f"custom_udp packet of {source}", magic=magic, fields=tuple(fields))
    has_vertical = any(one.name == "gforce_vertical" for one in fields)
    names = NAMES if has_vertical else replace(NAMES, force_car=_LEGACY_NAMES.force_car)
    return Channels("codemasters-custom", packet, names)


def _check_names(fields: list[Field], source: str) -> None:
    names = [one.name for one in fields]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(f"channel {twice!r} of {source}", "named twice", "named once")
    missing = [name for name in ("gforce_longitudinal", "gforce_lateral") if name not in names]
    if missing:
        raise InputError(f"channels of {source}", f"without {missing[0]}", "with both forces, which are cued")


def _channel(element: Element, where: str) -> Field:
    kind = _TYPES.get(element.tag.lower())
    if kind is None:
        raise InputError(where, repr(element.tag), one_of([*_TYPES, "fourcc"], element.tag))
    name, text = element.get("channel", ""), element.get("scale", "1.0")
    try:
        scale = float(text)
    except ValueError:
        scale = 0.0
    if not name or not 0.0 < abs(scale) < float("inf"):
        raise InputError(where, f"channel {name!r}, scale {text!r}", "a name, and a scale other than 0")
    return Field(name=name, type=kind, unit=UNITS.get(name, ""), scale=scale)


class _Plain(TreeBuilder):
    """Refuses document types. Entities can only be declared in one, so no text grows by expansion."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:  # noqa: ARG002
        raise InputError("document type", name, "absent: a list of channels declares no entities")


def _parsed(xml: str, source: str) -> Element:
    parser = XMLParser(target=_Plain())  # noqa: S314 - declarations are refused above
    try:
        parser.feed(xml)
        root = parser.close()
    except InputError as error:
        raise InputError(f"{error.field} of {source}", error.value, error.bound) from None
    except (ParseError, ValueError, RecursionError) as error:
        raise InputError(source, f"no XML ({error})", "the game's file of channels") from None
    if not isinstance(root, Element):
        raise InputError(source, "without an element", "the game's file of channels")
    return root
