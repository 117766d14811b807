"""A session as its file states it: platform, input, device, limits of this session, presets.

The file is TOML; degrees appear only in names with `deg`. Limits may only be narrower than those of the
platform's file, whose plausible bounds they share.
"""

from collections.abc import Collection, Mapping
from typing import Annotated, Any, Final, Literal, Self
from urllib.parse import urlsplit

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    model_validator,
)

from otolith.core.errors import InputError, one_of
from otolith.core.frames import AXES
from otolith.cueing.washout.tuning import LARGEST_FACTOR, LEAST_FACTOR
from otolith.platforms import Platform
from otolith.platforms.axes import Rotation, Translation
from otolith.platforms.bounds import (
    Acceleration,
    Radius,
    Speed,
    Threshold,
    Tilt,
    TiltAcceleration,
    TiltRate,
    Travel,
    Within,
    refuse,
)
from otolith.platforms.validation_messages import sentence, toml_fields

_UNITS: Final = {"m": "m", "mps": "m/s", "mps2": "m/s²", "deg": "deg", "degps": "deg/s", "degps2": "deg/s²"}


def _address(value: object) -> str:
    """Return an address such as 127.0.0.1:5300 as it is."""
    try:
        found = urlsplit(f"//{value}")
        sound = isinstance(value, str) and bool(found.hostname) and bool(found.port)
    except ValueError:
        sound = False
    if not sound:
        raise refuse("a host and a port, such as 127.0.0.1:5300")
    return str(value)


def _share(value: object) -> float:
    """Return a factor above 0 and up to 1."""
    number = Within(0.0, 1.0, "").finite(value)
    if not 0.0 < number <= 1.0:
        raise refuse("greater than 0 and at most 1: a session never cues more than what was driven")
    return number


def _within_one(number: float) -> float:
    """Return a number between 0 and 1."""
    if not 0.0 <= number <= 1.0:
        raise refuse("between 0 and 1")
    return number


def _factor(number: float) -> float:
    """Return a factor of corner frequencies."""
    if not LEAST_FACTOR <= number <= LARGEST_FACTOR:
        raise refuse(f"between {LEAST_FACTOR:g} and {LARGEST_FACTOR:g}")
    return number


Address = Annotated[str, BeforeValidator(_address)]
Share = Annotated[float, BeforeValidator(_share)]
Number = Annotated[float, BeforeValidator(Within(0.0, 0.0, "").finite)]
Liveliness = Annotated[float, BeforeValidator(Within(0.0, 0.0, "").finite), AfterValidator(_within_one)]
Factor = Annotated[float, BeforeValidator(Within(0.0, 0.0, "").finite), AfterValidator(_factor)]
Length = Annotated[float, BeforeValidator(Within(0.0, 0.0, "m").finite)]  # [m] of any sign
OnSilence = Literal["holds", "parks", "falls"]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Input(_Table):
    """Where telemetry comes from."""

    source: str  # a name of `otolith.live.wire.sources`, such as "forza" or "wrc:channels.json"
    listen: Address  # host and port of UDP
    pauses_silently: bool = False  # the source sends nothing in its menus
    forward: Address | None = None  # host and port that get every packet too: another program's

    @model_validator(mode="after")
    def _does_not_hear_itself(self) -> Self:
        if (
            self.forward is not None
            and urlsplit(f"//{self.forward}").port == urlsplit(f"//{self.listen}").port
        ):
            raise refuse("a port other than that of listen", field="forward", value=self.forward)
        return self


class TemplateAxis(_Table):
    """One axis of a template; see `otolith.live.devices.template.Axis`."""

    follows: str  # surge … yaw, or leg1 … or crank1 …
    low: Number  # [m or rad] at code 0; of a crank its angle [rad]
    high: Number  # [m or rad] at the largest code


class TemplateTable(_Table):
    """A device that reads what a template says, and reports nothing."""

    frame: str  # such as "<255><255><Axis1a><Axis2a><10><13>"
    axes: tuple[TemplateAxis, ...] = Field(strict=False)
    bits: int
    form: str = "big"
    start: str = ""
    stop: str = ""
    rate_hz: Number = 100.0
    park_heave_m: Length  # heave [m] of the platform where it rests without power


class DeviceTable(_Table):
    """The device that moves."""

    kind: Literal["moog", "generic", "template"]
    template: TemplateTable | None = None  # of template
    address: Address  # host and port of UDP
    interface: str | None = None  # of moog: the document that the base follows
    neutral_heave_m: Length | None = None  # of moog: its own heave at our neutral pose
    # of moog: how far the base goes, as public figures of a small one or as the platform's file says
    reach: Literal["public", "platform"] | None = None
    on_silence: OnSilence | None = None  # what the device does when packets stop

    @model_validator(mode="after")
    def _is_whole(self) -> Self:
        if (self.kind == "template") is not (self.template is not None):
            raise refuse("a table of kind = 'template', and only of it", field="template", value=self.kind)
        moog = self.kind == "moog"
        for name, bound in (
            ("interface", "CDS7237 or CDS7330: the document that the base follows"),
            ("neutral_heave_m", "given: the base's own heave at our neutral pose"),
        ):
            if moog and getattr(self, name) is None:
                raise refuse(bound, field=name, value="missing")
        for name in ("interface", "neutral_heave_m", "reach"):
            if not moog and getattr(self, name) is not None:
                raise refuse("left out: only moog has one", field=name, value=getattr(self, name))
        return self


class AxisLimit(_Table):
    """Limits of one axis that are narrower than the platform's; what is left out stays as it is."""

    position_m: Travel | None = None  # (low, high) [m]; one number x means ±x
    velocity_mps: Speed | None = None
    acceleration_mps2: Acceleration | None = None
    angle_deg: Tilt | None = None  # (low, high) [deg]
    rate_degps: TiltRate | None = None
    acceleration_degps2: TiltAcceleration | None = None


class Limits(_Table):
    """Limits of this session."""

    surge: AxisLimit = AxisLimit()
    sway: AxisLimit = AxisLimit()
    heave: AxisLimit = AxisLimit()
    roll: AxisLimit = AxisLimit()
    pitch: AxisLimit = AxisLimit()
    yaw: AxisLimit = AxisLimit()
    circle_m: Radius | None = None
    tilt_pitch_degps: Threshold | None = None  # of tilt coordination
    tilt_roll_degps: Threshold | None = None


class Preset(_Table):
    """What a session does differently under a name; what is left out stays as the session states it."""

    cueing: str | None = None
    tuning: str | None = None
    liveliness: Liveliness | None = None
    high_pass: Factor | None = None
    low_pass: Factor | None = None
    scale: Share | None = None
    limits: Limits | None = None


class Changes(_Table):
    """What may change while a session runs, with the bounds that it has in a file."""

    scale: Share | None = None
    liveliness: Liveliness | None = None
    high_pass: Factor | None = None
    low_pass: Factor | None = None


class Settings(_Table):
    """All that a session's file states, apart from the axis map, which has a check of its own."""

    platform: str  # a shipped name or a file
    cueing: str = "predictive"
    dofs: str = "surge-pitch,sway-roll"
    tuning: str | None = None  # of a conventional washout: a name or a file
    laws: str | None = None  # file of explicit laws
    hint: str | None = None  # file of a hint
    liveliness: Liveliness = 0.5  # of predictive
    high_pass: Factor = 1.0  # of classical: factors of the corner frequencies of its tuning
    low_pass: Factor = 1.0
    scale: Share = 1.0  # of what should be felt
    page_only: bool = False  # a program alone commands: without a sign of it for 5 s, cueing ends
    input: Input
    device: DeviceTable
    limits: Limits = Limits()
    presets: Mapping[str, Preset] = Field(default_factory=dict)

    def under(self, preset: str | None) -> "Settings":
        """Return the settings under a preset; None for those without one.

        Raises
        ------
        InputError : there is none of this name.
        """
        if preset is None:
            return self
        if preset not in self.presets:
            raise InputError("preset", repr(preset), one_of(self.presets, preset))
        changed = self.presets[preset]
        return self.model_copy(update={name: getattr(changed, name) for name in changed.model_fields_set})


def settings_from_toml(text: str, source: str) -> Settings:
    """Read a session's file; its section `axes` is read by `otolith.live.wire.axes`.

    Parameters
    ----------
    source : name of the file, for errors.

    Raises
    ------
    InputError : the text is not TOML, or a field is unknown, missing, or out of bounds.
    """
    fields = toml_fields(text, source)
    fields.pop("axes", None)
    return settings_from(fields, source)


def settings_from(fields: Mapping[str, Any], source: str) -> Settings:
    """Check the fields of a session; see `settings_from_toml`."""
    try:
        return Settings.model_validate(fields)
    except ValidationError as error:
        raise sentence(error, Settings, source) from None


def changes_from(values: Mapping[str, Any], offered: Collection[str]) -> dict[str, float]:
    """Return the parameters that are to be changed while a session runs, checked.

    Parameters
    ----------
    offered : names of those that this session has.

    Raises
    ------
    InputError : there are none, or one is out of its bounds, or is not offered.
    """
    if not values:
        raise InputError("the change", "empty", one_of(offered, ""))
    for name in values:
        if name not in offered:
            raise InputError(name[:40], "to be changed while a session runs", one_of(offered, name))
        if values[name] is None:
            raise InputError(name, "empty", "a number while a session runs")
    try:
        return Changes.model_validate(values).model_dump(exclude_unset=True)
    except ValidationError as error:
        raise sentence(error, Changes, "the change") from None


def narrowed(platform: Platform, limits: Limits, source: str) -> Platform:
    """Return a platform with the limits of a session.

    Raises
    ------
    InputError : a limit is wider than the platform's, or one of an axis that the platform lacks.
    """
    changed: dict[str, Any] = {}
    for axis in AXES:
        limit = getattr(limits, axis)
        if limit.model_fields_set:
            changed[axis] = _narrow_axis(platform, axis, limit, source)
    if limits.circle_m is not None:
        _check(limits.circle_m, platform.circle, "circle_m", f"limits.circle_m in {source}")
        changed["workspace"] = platform.workspace.model_copy(update={"circle_m": limits.circle_m})
    tilts: dict[str, float] = {}
    for axis in ("pitch", "roll"):
        tilt = getattr(limits, f"tilt_{axis}_degps")
        if tilt is not None:
            widest = getattr(platform.tilt_coordination, f"{axis}_degps")
            _check(tilt, widest, "_degps", f"limits.tilt_{axis}_degps in {source}")
            tilts[f"{axis}_degps"] = tilt
    changed["tilt_coordination"] = platform.tilt_coordination.model_copy(update=tilts)
    return platform.model_copy(update=changed)


def _narrow_axis(platform: Platform, axis: str, limit: AxisLimit, source: str) -> Translation | Rotation:
    table: Translation | Rotation | None = getattr(platform, axis)
    if table is None:
        raise InputError(f"limits.{axis} in {source}", "given", f"left out: {platform.name} has no {axis}")
    values: dict[str, Any] = {}
    for name in sorted(limit.model_fields_set):
        field = f"limits.{axis}.{name} in {source}"
        if name not in type(table).model_fields:
            raise InputError(field, "given", f"left out: {axis} has {', '.join(type(table).model_fields)}")
        values[name] = getattr(limit, name)
        _check(values[name], getattr(table, name), name, field)
    if isinstance(table, Translation) and table.command_mps2 is not None and "acceleration_mps2" in values:
        values["command_mps2"] = min(table.command_mps2, values["acceleration_mps2"])
    return table.model_copy(update=values)


def _check(value: Any, widest: Any, name: str, field: str) -> None:
    """Refuse a limit, or a pair of ends, that is wider than the platform's; None there is unlimited."""
    unit = _UNITS[name.rpartition("_")[2]]
    if widest is None:
        return
    if isinstance(value, tuple):
        if value[0] < widest[0] or value[1] > widest[1]:
            bound = f"within {widest[0]:g} to {widest[1]:g} {unit}, as the platform's"
            raise InputError(field, f"{value[0]:g} to {value[1]:g} {unit}", bound)
    elif value > widest:
        raise InputError(field, f"{value:g} {unit}", f"at most {widest:g} {unit}, as the platform's")
