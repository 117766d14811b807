"""The form of a platform file: the fields that a builder measures, with the bounds of the file's own model.

A form is filled into the commented template, or into the file that is there already, so whatever else the
file says stays. It is judged by what reads platform files everywhere, in the same sentences.
"""

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Final, get_args

from pydantic import BaseModel, BeforeValidator

from otolith.core.errors import InputError, one_of
from otolith.core.frames import AXES
from otolith.platforms import Platform, parse_platform
from otolith.platforms.bounds import Within
from otolith.platforms.template import Kind, Value, filled, template
from otolith.platforms.validation_messages import toml_fields

KINDS: Final[dict[Kind, str]] = {
    "axes": "axes that move one by one: a seat mover, a sled, a surge-pitch rig",
    "legs": "six legs: a hexapod, a Stewart platform",
    "cranks": "six cranks: motors that turn, and rods to the platform",
}
LOW, HIGH = "low", "high"  # the two ends of a pair
# Of fields that hold both ends at once, so that their own bounds are not those of one number
_ENDS: Final = {
    "hexapod.legs.length_m": Within(0.05, 20.0, "m"),
    "hexapod.cranks.angle_deg": Within(3.2, 175.0, "deg"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One field of the form.

    Parameters
    ----------
    path : of the field in the file, such as "surge.position_m".
    end : which end of a pair it is; empty for a field of its own.
    """

    path: str
    group: str
    title: str
    effect: str
    end: str = ""
    among: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Return the name of the field in the form."""
        return "_".join(filter(None, (*self.path.split("."), self.end)))

    def property(self) -> dict[str, Any]:
        """Return the JSON schema of the field."""
        shown: dict[str, Any] = {"title": self.title, "description": self.effect, "x-group": self.group}
        shown |= {"x-live": False, "x-unit": ""}
        if self.among:
            return shown | {"type": "string", "enum": list(self.among)}
        bound = within(self.path)
        if bound is None:
            return shown | {"type": "string"}
        number = {"type": "number", "minimum": bound.low, "maximum": bound.high}
        return shown | {"anyOf": [number, {"type": "null"}], "x-unit": bound.unit}


@cache
def within(path: str) -> Within | None:
    """Return the bounds that the model of platform files has for a field; None for a text."""
    model: Any = Platform
    *tables, name = path.split(".")
    for table in tables:
        kinds = get_args(model.model_fields[table].annotation) or (model.model_fields[table].annotation,)
        model = next(one for one in kinds if isinstance(one, type) and issubclass(one, BaseModel))
    found = model.model_fields[name]
    metadata = [*found.metadata, *(part for one in get_args(found.annotation) for part in get_args(one))]
    for one in metadata:
        if isinstance(one, BeforeValidator):
            judge = getattr(one.func, "__self__", None)
            return judge if isinstance(judge, Within) else _ENDS.get(path)
    return None


def _axis(axis: str, back: str, forth: str) -> Iterator[Entry]:
    """Yield the fields of an axis that moves along a line."""
    yield Entry(
        path=f"{axis}.position_m",
        end=LOW,
        group=axis,
        title=f"Way {back}",
        effect="(how far it goes from where it rests) = (its limit; empty: the machine has no such axis)",
    )
    yield Entry(
        path=f"{axis}.position_m",
        end=HIGH,
        group=axis,
        title=f"Way {forth}",
        effect="(how far it goes the other way) = (its limit)",
    )
    yield Entry(
        path=f"{axis}.velocity_mps",
        group=axis,
        title=f"Speed of {axis}",
        effect="(the fastest it can go, of the actuator's data sheet) = (a longer force can be felt)",
    )
    yield Entry(
        path=f"{axis}.acceleration_mps2",
        group=axis,
        title=f"Acceleration of {axis}",
        effect="(the hardest it can start; unknown: 10 times the speed) = (stronger onsets)",
    )


def _turn(axis: str, low: str, high: str) -> Iterator[Entry]:
    """Yield the fields of an axis that turns."""
    yield Entry(
        path=f"{axis}.angle_deg",
        end=LOW,
        group=axis,
        title=f"Angle, {low}",
        effect="(how far it turns from where it rests) = (its limit; empty: the machine has no such axis)",
    )
    yield Entry(
        path=f"{axis}.angle_deg",
        end=HIGH,
        group=axis,
        title=f"Angle, {high}",
        effect="(how far it turns the other way) = (its limit)",
    )
    yield Entry(
        path=f"{axis}.rate_degps",
        group=axis,
        title=f"Rate of {axis}",
        effect="(the fastest it can turn; empty: unknown) = (tilting keeps below it)",
    )
    yield Entry(
        path=f"{axis}.acceleration_degps2",
        group=axis,
        title=f"Angular acceleration of {axis}",
        effect="(the hardest it can begin to turn; empty: unknown) = (tilting begins more gently)",
    )


_WHO: Final = (
    Entry(path="name", group="name", title="Name of the machine", effect="(a name) = (stands in reports)"),
    Entry(path="description", group="name", title="In a few words", effect="(a text) = (is shown in lists)"),
)
_MOVES: Final = (
    *_axis("surge", "backward", "forward"),
    *_axis("sway", "to the right", "to the left"),
    *_axis("heave", "down", "up"),
    *_turn("roll", "left side down", "right side down"),
    *_turn("pitch", "nose up", "nose down"),
    *_turn("yaw", "to the right", "to the left"),
    *(
        Entry(
            path=f"tilt_coordination.{axis}_degps",
            group="what a driver does not notice",
            title=f"Tilting in {axis}",
            effect="(faster) = (more lasting force is felt; above the threshold the tilting is felt, too)",
        )
        for axis in ("pitch", "roll")
    ),
)


def _leg(key: str, group: str, title: str, effect: str, **more: Any) -> Entry:
    return Entry(path=f"hexapod.{key}", group=group, title=title, effect=effect, **more)


_PLACES: Final = "where the legs are"
_STROKES: Final = "what the legs can do"
_RADIUS: Final = "(of the circle through its six joints; measure it) = (reach and stiffness)"
_ANGLE: Final = "(half the angle between the two joints of a pair, seen from the centre) = (reach in yaw)"
_LOAD: Final = _leg(
    "payload.mass_kg", _STROKES, "Mass on top", "(platform, seat, screens, driver) = (the servos' load)"
)
_CIRCLES: Final = (
    _leg(
        "neutral_height_m",
        _PLACES,
        "Height",
        "(from the base's joints, or shafts, up to the platform's, legs about half out) = (the neutral pose)",
    ),
    _leg("circles.base_radius_m", _PLACES, "Radius of the base", _RADIUS),
    _leg("circles.base_half_angle_deg", _PLACES, "Half angle, base", _ANGLE),
    _leg("circles.platform_radius_m", _PLACES, "Radius of the platform", _RADIUS),
    _leg("circles.platform_half_angle_deg", _PLACES, "Half angle, platform", _ANGLE),
    _leg(
        "circles.forward",
        _PLACES,
        "Forward points",
        "(a pair of the platform's joints, or of the base's) = (which way the machine faces)",
        among=("platform", "base"),
    ),
)
_LEGS: Final = (
    *_CIRCLES,
    _leg(
        "legs.length_m", _STROKES, "Leg drawn in", "(joint to joint) = (the shortest a leg may be)", end=LOW
    ),
    _leg("legs.length_m", _STROKES, "Leg fully out", "(joint to joint) = (the longest it may be)", end=HIGH),
    _leg("legs.speed_mps", _STROKES, "Speed of a leg", "(under load, of the data sheet) = (its limit)"),
    _leg(
        "legs.acceleration_mps2",
        _STROKES,
        "Acceleration of a leg",
        "(unknown: 20 times the speed) = (its limit)",
    ),
    _leg("legs.force_n", _STROKES, "Force of a leg", "(the most that it pushes or pulls) = (its limit)"),
    _leg("legs.mass_kg", _STROKES, "Mass of a leg", "(rod, nut, what turns with them) = (servos' load)"),
    _LOAD,
)
_CRANKS: Final = (
    *_CIRCLES,
    _leg(
        "cranks.radius_m", _PLACES, "Crank", "(from the shaft to the rod's joint) = (reach, and less force)"
    ),
    _leg("cranks.rod_m", _PLACES, "Rod", "(from joint to joint) = (where the angles of the cranks begin)"),
    _leg("cranks.angle_deg", _STROKES, "Angle below 0", "(how far it turns down) = (its limit)", end=LOW),
    _leg("cranks.angle_deg", _STROKES, "Angle above 0", "(how far it turns up) = (its limit)", end=HIGH),
    _leg("cranks.speed_degps", _STROKES, "Speed of a crank", "(under load, behind the gear) = (its limit)"),
    _leg(
        "cranks.acceleration_degps2",
        _STROKES,
        "Acceleration of a crank",
        "(unknown: 10 times the speed) = (its limit)",
    ),
    _leg("cranks.torque_nm", _STROKES, "Torque of a crank", "(at the shaft, behind the gear) = (its limit)"),
    _leg(
        "cranks.inertia_kgm2",
        _STROKES,
        "Inertia of a crank",
        "(of the motor times gear², and crank) = (load)",
    ),
    _LOAD,
)
ENTRIES: Final[dict[Kind, tuple[Entry, ...]]] = {
    "axes": (*_WHO, *_MOVES),
    "legs": (*_WHO, *_MOVES, *_LEGS),
    "cranks": (*_WHO, *_MOVES, *_CRANKS),
}


def form(kind: Kind) -> dict[str, Any]:
    """Return the form of a kind of machine: its fields as JSON schema, and the values of its template."""
    fields = {entry.name: entry.property() for entry in ENTRIES[kind]}
    return {"text": KINDS[kind], "properties": fields, "values": values_of(template(kind), kind)}


def forms() -> dict[str, dict[str, Any]]:
    """Return the forms of all kinds of machines."""
    return {kind: form(kind) for kind in KINDS}


def kind_of(text: str, name: str) -> Kind:
    """Return of which kind the machine of a platform file is; text that is no TOML is an InputError."""
    hexapod = toml_fields(text, name).get("hexapod")
    if hexapod is None:
        return "axes"
    return "cranks" if isinstance(hexapod, dict) and "cranks" in hexapod else "legs"


def values_of(text: str, kind: Kind) -> dict[str, Value]:
    """Return the values of the form that stand in a platform file that is in order."""
    fields = tomllib.loads(text)
    return {entry.name: _found(entry, fields) for entry in ENTRIES[kind]}


def _found(entry: Entry, fields: Mapping[str, Any]) -> Value:
    value: Any = fields
    for part in entry.path.split("."):
        value = value.get(part) if isinstance(value, Mapping) else None
    if value is None or not entry.end:
        return value  # type: ignore[no-any-return]
    low, high = value if isinstance(value, list) else (-value, value)
    if entry.end == HIGH:
        return float(high)
    return float(low) if _is_span(entry) else -float(low)  # ways and angles are told without a sign


def _is_span(entry: Entry) -> bool:
    """Return whether both ends are lengths, and not the two ways from neutral."""
    return entry.path == "hexapod.legs.length_m"


def text_of(values: Mapping[str, Any], kind: str, name: str, before: str | None = None) -> str:
    """Return the text of a platform file, judged as one that is read.

    Parameters
    ----------
    values : of the form; what is left out stays as the file, or the template, has it.
    name : of the file, for errors. before : its text; None where there is none.

    Raises
    ------
    InputError : a field is unknown, or its value is none that a platform file may have.
    """
    known = _kind(kind)
    entries = {entry.name: entry for entry in ENTRIES[known]}
    for one in values:
        if one not in entries:
            raise InputError(one, "unknown", one_of(entries, one))
    base = template(known) if before is None else before
    paths: dict[str, Value] = {}
    for entry in entries.values():
        if entry.name in values and entry.path not in paths:
            paths[entry.path] = _given(entry, values, name)
    for axis in AXES:  # without a way, there is no such axis, whatever else stands in its fields
        way = f"{axis}.position_m" if f"{axis}.position_m" in paths else f"{axis}.angle_deg"
        if way in paths and paths[way] is None:
            paths |= {path: None for path in paths if path.startswith(f"{axis}.")}
    text = filled(base, paths)
    parse_platform(text, name)
    return text


def _kind(name: str) -> Kind:
    for kind in KINDS:
        if kind == name:
            return kind
    raise InputError("kind", repr(name), one_of(KINDS, name))


def _given(entry: Entry, values: Mapping[str, Any], name: str) -> Value:
    """Return the value of a field in the file: one of the form's, or the pair of two."""
    if not entry.end:
        value = values[entry.name]
        return _plain(entry.path, None if entry.among and value == "" else value, name)
    stem = entry.name.removesuffix(f"_{entry.end}")
    ends = [_plain(entry.path, values.get(f"{stem}_{end}"), name) for end in (LOW, HIGH)]
    if ends == [None, None]:
        return None
    for end, title in zip(ends, (LOW, HIGH), strict=True):
        if not isinstance(end, float):
            raise InputError(f"{title} end of {entry.path} in {name}", "missing", "given, as the other one")
    low, high = (float(end) for end in ends if isinstance(end, float))
    return (low, high) if _is_span(entry) else (-low, high)


def _plain(path: str, value: Any, name: str) -> Value:
    """Return a value as TOML can have it: a number, a text, or nothing."""
    if value is None:
        return value
    if isinstance(value, str):
        if any("\ud800" <= one <= "\udfff" for one in value):
            raise InputError(f"{path} in {name}", repr(value)[:60], "a text that UTF-8 can hold")
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{path} in {name}", repr(value)[:60], "a number or a text")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{path} in {name}", f"{str(value)[:40]}…", "a number of at most 1.8e308") from None


def field_of(error: InputError) -> str:
    """Return the field of the form that an error is about; empty if it is none."""
    path = error.field.partition(" in ")[0].removeprefix("low end of ").removeprefix("high end of ")
    entries = (entry for kind in ("legs", "cranks") for entry in ENTRIES[kind])
    return next((entry.name for entry in entries if path in (entry.path, entry.name)), "")
