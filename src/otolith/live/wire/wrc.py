"""EA SPORTS WRC: its JSON files say which channels stand in a packet, and of which type each channel is.

Source: the files that the game writes to Documents/My Games/WRC/telemetry: `udp/NAME.json` names the channels
of each packet, `readme/channels.json` their types. The latter may be left out: the types of the channels that
the game had in 2024 are known here. Accelerations are in world axes, m/s²; gravity is not documented.
"""

import json
from typing import Any, Final, TypeGuard

from otolith.core.errors import InputError, one_of
from otolith.live.wire.channels import Channels, Names
from otolith.live.wire.codemasters import MOST_CHANNELS
from otolith.live.wire.formats import Field, Packet

_TYPES: Final = {
    "float32": ("f32", 1),
    "float64": ("f64", 1),
    "uint8": ("u8", 1),
    "int8": ("i8", 1),
    "uint16": ("u16", 1),
    "int16": ("i16", 1),
    "uint32": ("u32", 1),
    "int32": ("i32", 1),
    "uint64": ("u64", 1),
    "boolean": ("u8", 1),
    "fourcc": ("u8", 4),
}


def _vector(what: str) -> tuple[str, ...]:
    return tuple(f"vehicle_{what}_{axis}" for axis in "xyz")


NAMES: Final = Names(
    acceleration_world=_vector("acceleration"),
    velocity_world=_vector("velocity"),
    position=_vector("position"),
    forward=_vector("forward_direction"),
    left=_vector("left_direction"),
    up=_vector("up_direction"),
    time="game_total_time",
)
_UNITS: Final = {
    **dict.fromkeys(NAMES.acceleration_world, "m/s²"),
    **dict.fromkeys(NAMES.velocity_world, "m/s"),
    **dict.fromkeys(NAMES.position, "m"),
    **dict.fromkeys((*NAMES.forward, *NAMES.left, *NAMES.up), "unit"),
    "game_total_time": "s",
    "vehicle_speed": "m/s",
}
_WHEELS: Final = ("bl", "br", "fl", "fr")


def _known() -> dict[str, str]:
    """Return the types of the game's channels as of 2024, by name."""
    wheels = ("hub_position", "hub_velocity", "cp_forward_speed", "brake_temperature")
    real = [f"vehicle_{what}_{wheel}" for what in wheels for wheel in _WHEELS]
    real += [f"vehicle_engine_rpm_{what}" for what in ("max", "idle", "current")]
    real += [f"vehicle_{what}" for what in ("throttle", "brake", "clutch", "steering", "handbrake")]
    real += ["vehicle_speed", "vehicle_transmission_speed", "game_total_time", "game_delta_time"]
    real += ["shiftlights_fraction", "shiftlights_rpm_start", "shiftlights_rpm_end", "stage_progress"]
    real += [
        "stage_current_time",
        "stage_previous_split_time",
        "stage_result_time",
        "stage_result_time_penalty",
    ]
    real += [name for name in _UNITS if name.startswith("vehicle_")]
    small = ["gear_index", "gear_index_neutral", "gear_index_reverse", "gear_maximum"]
    small = [f"vehicle_{what}" for what in [*small, *(f"tyre_state_{wheel}" for wheel in _WHEELS)]]
    named = ["vehicle_id", "vehicle_class_id", "vehicle_manufacturer_id", "location_id", "route_id"]
    return {
        **dict.fromkeys(real, "float32"),
        **dict.fromkeys([*small, "stage_result_status", "game_mode"], "uint8"),
        **dict.fromkeys(named, "uint16"),
        **dict.fromkeys(["shiftlights_rpm_valid", "stage_shakedown", "vehicle_cluster_abs"], "boolean"),
        **dict.fromkeys(["packet_uid", "game_frame_count"], "uint64"),
        **dict.fromkeys(["stage_current_distance", "stage_length"], "float64"),
        "packet_4cc": "fourcc",
    }


KNOWN: Final = _known()


def wrc(
    structure: str, source: str, *, channels: str | None = None, packet: str = "session_update"
) -> Channels:
    """Return the source of one of the game's packets.

    Parameters
    ----------
    structure : text of `udp/NAME.json`.
    source : its name, for errors.
    channels : text of `readme/channels.json`; without it the types known here are used.
    packet : which of the packets holds the telemetry.

    Raises
    ------
    InputError : a file is not as the game writes it, a channel is unknown, or motion is missing.
    """
    types = KNOWN if channels is None else _types(_object(channels, "channels.json"))
    listed = _listed(_object(structure, source), source, packet)
    fields = []
    for name in listed:
        if name not in types:
            raise InputError(
                f"channel of {source}", repr(name), one_of(types, name, otherwise=", see channels.json")
            )
        kind, count = _TYPES[types[name]]
        fields.append(Field(name=name, type=kind, count=count, unit=_UNITS.get(name, "")))
    needed = (*NAMES.acceleration_world, *NAMES.forward, *NAMES.left)
    missing = [name for name in needed if name not in listed]
    if missing:
        raise InputError(
            f"packet {packet} of {source}", f"without {missing[0]}", "with acceleration and directions"
        )
    return Channels("wrc", Packet(name=f"WRC packet {packet} of {source}", fields=tuple(fields)), NAMES)


def _object(text: str, source: str) -> dict[str, Any]:
    try:
        value = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(source, f"no JSON ({error})", "as the game writes it") from None
    if not isinstance(value, dict):
        raise InputError(source, type(value).__name__, "a JSON object, as the game writes it")
    return value


def _listed(structure: dict[str, Any], source: str, packet: str) -> list[str]:
    """Return the channels of a packet: those of the header, which stand in every packet, and its own."""
    packets = structure.get("packets")
    found = (
        [one for one in packets if isinstance(one, dict) and one.get("id") == packet]
        if _is_list(packets)
        else []
    )
    header = structure.get("header", {})
    parts = [header.get("channels", []) if isinstance(header, dict) else None]
    parts += [one.get("channels") for one in found[:1]]
    names = [name for part in parts if _is_list(part) for name in part]
    if not found or not all(map(_is_list, parts)) or not all(isinstance(name, str) for name in names):
        raise InputError(
            f"packet {packet!r} of {source}", "absent or not a list of names", "a list of channels"
        )
    if len(names) > MOST_CHANNELS or len(set(names)) < len(names):
        raise InputError(f"channels of {source}", len(names), f"at most {MOST_CHANNELS}, each named once")
    return names


def _types(readme: dict[str, Any]) -> dict[str, str]:
    listed = readme.get("channels")
    if not _is_list(listed) or not all(isinstance(one, dict) for one in listed):
        raise InputError(
            "channels of channels.json", "absent or not a list", "a list of objects with id and type"
        )
    types = {str(one.get("id")): str(one.get("type")) for one in listed}
    for name, kind in types.items():
        if kind not in _TYPES:
            raise InputError(f"type of {name} in channels.json", repr(kind), one_of(_TYPES, kind))
    return types


def _is_list(value: object) -> TypeGuard[list[Any]]:
    return isinstance(value, list)
