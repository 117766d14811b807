"""The form of a run: every setting with its bounds, its unit, and a sentence that says what it does.

The page builds its form from the JSON schema of `Form`. Whatever comes back, before a run or during it, is
checked by the same model, and refused with the sentence that the form shows.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any, Final, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from otolith import registry
from otolith.core.errors import InputError, one_of
from otolith.cueing.washout.tuning import LARGEST_FACTOR, LEAST_FACTOR
from otolith.platforms.bounds import refuse
from otolith.platforms.library import catalog
from otolith.scenarios.scenario import MAX_SCALE

TOML: Final = ".toml"
FILE: Final = r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}"  # name of a file or of a preset
DOFS: Final = (
    "surge-pitch",
    "sway-roll",
    "surge-pitch,sway-roll",
    "surge-pitch,sway-roll,heave",
    "surge-pitch,sway-roll,heave,yaw",
    "heave",
    "yaw",
)
# Those that need no file of the user's beside the form.
CUEING: Final = tuple(name for name, entry in registry.CUEING.own.items() if "hint" not in entry.reads)
PLATFORM_WORDS: Final = f"one of {', '.join(catalog())}, or a file of your own"
INPUT, PLATFORM, ALGORITHM, RUN = "Input", "Platform", "Algorithm", "Run"  # groups


def setting(
    group: str, default: Any, title: str, effect: str, *, unit: str = "", live: bool = False, **bounds: Any
) -> Any:
    """Return a field of the form.

    Parameters
    ----------
    effect : "(setting) = (effect)", shown beside the field.
    live : whether it may be changed while it runs.
    bounds : those of pydantic, or `among`, the values that are allowed; `words`, a bound told in words; `of`,
        choices of other fields: without one of them this one has no meaning.
    """
    extra: dict[str, Any] = {"x-group": group, "x-unit": unit, "x-live": live}
    if (among := bounds.pop("among", None)) is not None:
        extra["enum"] = list(among)
    if (words := bounds.pop("words", None)) is not None:
        extra["x-bound"] = words
    extra["x-of"] = list(bounds.pop("of", ()))
    return Field(default, title=title, description=effect, json_schema_extra=extra, **bounds)


def _extra(field: FieldInfo) -> dict[str, Any]:
    return field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}


class Offered(BaseModel):
    """A form: fields that are made by `setting`, of which some offer a choice."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @model_validator(mode="after")
    def _is_offered(self) -> Self:
        for name, field in type(self).model_fields.items():
            among, value = _extra(field).get("enum"), getattr(self, name)
            if name == "platform" and not is_file(value):
                among = catalog()
            if among is not None and value not in among:
                raise refuse(
                    one_of([word or "empty" for word in among], value), field=name, value=repr(value)
                )
        return self


F = TypeVar("F", bound=Offered)


class Form(Offered):
    """The settings of a run; empty texts, and numbers left out, are what the algorithm would choose."""

    scenario: str = setting(
        INPUT,
        "step-sine-1",
        "Scenario",
        "(a name, or a formula such as sine:amplitude=0.7,frequency=0.2) = (what the driver should feel)",
        max_length=200,
        words="a text of at most 200 characters",
    )
    log: str = setting(
        INPUT,
        "",
        "Recorded drive",
        "(a file in the Commander's folder) = (is cued in place of the scenario)",
        pattern=f"^({FILE})?$",
        words="the name of a file: letters, digits, dots, dashes and underscores, at most 64, or empty",
    )
    scale: float = setting(
        INPUT,
        1.0,
        "Scale",
        "(smaller) = (weaker forces and less travel; the shape stays)",
        live=True,
        ge=0.01,
        le=MAX_SCALE,
    )
    lowpass: float | None = setting(
        INPUT,
        None,
        "Low-pass of a recorded drive",
        "(lower) = (smoother forces; bumps and noise are left out)",
        unit="Hz",
        ge=0.1,
        le=50.0,
    )
    through: str = setting(
        INPUT,
        "",
        "Through an organ",
        "(an otolith) = (only what this organ passes on is cued, as in eq. 6.4)",
        among=("", "telban", "young", "ormsby", "thresholds"),
    )
    platform: str = setting(
        PLATFORM,
        "davsi",
        "Platform",
        "(a shipped platform, or a file of your own) = (its reach, speeds and thresholds are the limits)",
        max_length=70,
        words=PLATFORM_WORDS,
    )
    dofs: str = setting(
        PLATFORM,
        "surge-pitch",
        "Degrees of freedom",
        "(more) = (more of the drive is felt; axes share the reach of the machine)",
        among=DOFS,
    )
    plant: str = setting(
        PLATFORM,
        "",
        "Plant",
        "(ideal to hexapod) = (from a machine that follows exactly to six legs with servos)",
        among=("", *registry.PLANTS.own),
    )
    cueing: str = setting(
        ALGORITHM,
        "predictive",
        "Algorithm A",
        "(an algorithm) = (turns what should be felt into motion of the platform)",
        among=CUEING,
    )
    second: str = setting(
        ALGORITHM,
        "",
        "Algorithm B",
        "(another algorithm) = (runs beside A on the same reference; empty: A alone)",
        among=("", *CUEING),
    )
    liveliness: float = setting(
        ALGORITHM,
        0.5,
        "Liveliness of predictive",
        "(larger) = (more travel is spent on what is felt, and the platform returns later)",
        live=True,
        ge=0.0,
        le=1.0,
    )
    tuning: str = setting(
        ALGORITHM,
        "",
        "Tuning of a washout",
        "(a shipped tuning) = (gains and corner frequencies of classical, optimal, adaptive)",
        among=("", *catalog()),
    )
    high_pass: float = setting(
        ALGORITHM,
        1.0,
        "High-passes of classical",
        "(larger) = (the platform returns sooner, and passes less on)",
        unit="× tuning",
        live=True,
        ge=LEAST_FACTOR,
        le=LARGEST_FACTOR,
    )
    low_pass: float = setting(
        ALGORITHM,
        1.0,
        "Tilt low-pass of classical",
        "(larger) = (it tilts sooner and faster for a lasting force)",
        unit="× tuning",
        live=True,
        ge=LEAST_FACTOR,
        le=LARGEST_FACTOR,
    )
    prediction: str = setting(
        ALGORITHM,
        "",
        "Prediction of an MPC",
        "(what is assumed of the coming forces) = (how early it tilts, and whether it turns back in time)",
        among=("", "hold", "decay", "adaptive", "oracle"),
    )
    horizon: int | None = setting(
        ALGORITHM,
        None,
        "Horizon of the implicit MPC",
        "(longer) = (sees limits sooner; takes longer to decide)",
        unit="steps",
        ge=2,
        le=500,
    )
    blocks: str = setting(
        ALGORITHM,
        "",
        "Blocks of the implicit MPC",
        "(steps of each block, such as 1,1,2,7,12) = (inputs are held; a long horizon costs little)",
        pattern=r"^([0-9]{1,3}(,[0-9]{1,3}){0,49})?$",
        max_length=200,
        words="numbers of steps with commas, as in 1,1,2,7,12, or empty",
    )
    washout: str = setting(
        ALGORITHM,
        "thesis-fit",
        "Washout of the implicit MPC",
        "(stronger weights) = (the platform returns sooner, and tracks less)",
        among=("printed", "thesis-fit", "none", "constant-fit", "constant-printed"),
    )
    weight_position: float | None = setting(
        ALGORITHM,
        None,
        "Weight on position",
        "(larger) = (the platform is drawn home more strongly; replaces the washout above)",
        live=True,
        ge=0.0,
        le=1e3,
    )
    weight_velocity: float | None = setting(
        ALGORITHM,
        None,
        "Weight on velocity",
        "(larger) = (slower motion along the axes; replaces the washout above)",
        live=True,
        ge=0.0,
        le=1e3,
    )
    weight_tilt_rate: float | None = setting(
        ALGORITHM,
        None,
        "Weight on tilt rate",
        "(larger) = (slower tilting; replaces the washout above)",
        live=True,
        ge=0.0,
        le=1e3,
    )
    braking: str = setting(
        ALGORITHM,
        "",
        "Braking rows of an MPC",
        "(stopping, leading, position) = (what keeps the platform able to stop inside its limits)",
        among=("", "stopping", "leading", "position", "printed", "none"),
    )
    guess_entry: str = setting(
        ALGORITHM,
        "reference",
        "Entry of a hybrid's guess",
        "(reference) = (changes what is optimal); (primal, working-set) = (change only the effort)",
        among=("reference", "primal", "working-set"),
    )
    solver: str = setting(
        ALGORITHM,
        "structured",
        "Solver of an MPC",
        "(structured) = (compiled, microseconds); (dense) = (condensed, slower, to compare)",
        among=("structured", "dense"),
    )
    speed: float = setting(
        RUN,
        1.0,
        "Speed",
        "(1) = (real time); (larger) = (faster); (0) = (as fast as it can be computed)",
        unit="× real time",
        live=True,
        ge=0.0,
        le=100.0,
    )


def is_file(platform: str) -> bool:
    """Return whether a platform is named as a file of the Commander's folder, and not as a shipped one."""
    return platform.endswith(TOML) and re.fullmatch(FILE, platform) is not None


LIVE: Final = tuple(name for name, field in Form.model_fields.items() if _extra(field)["x-live"])


def bound_of(name: str, form: type[Offered] = Form) -> str:
    """Return the bound of a setting in words, with its unit: as the form shows it, and errors."""
    field = form.model_fields[name]
    extra, unit = _extra(field), str(_extra(field)["x-unit"])
    words = f" {unit}" if unit else ""
    if "x-bound" in extra:
        return str(extra["x-bound"])
    if "enum" in extra:
        return "one of " + ", ".join(word or "empty" for word in extra["enum"])
    ends = {type(one).__name__: one for one in field.metadata}
    if "Ge" in ends and "Le" in ends:
        empty = "" if field.is_required() or field.default is not None else ", or empty"
        return f"between {ends['Ge'].ge:g} and {ends['Le'].le:g}{words}{empty}"
    return "yes or no"


def schema(platforms: Sequence[str] = (), form: type[Offered] = Form) -> dict[str, Any]:
    """Return the JSON schema for the page; x-bound is the bound in words.

    Parameters
    ----------
    platforms : files of the user's own.
    """
    made = form.model_json_schema()
    made["properties"]["platform"]["enum"] = [*catalog(), *platforms]
    for name, described in made["properties"].items():
        described["x-bound"] = bound_of(name, form)
    return made


def live_schema(names: Collection[str]) -> dict[str, Any]:
    """Return the part of the schema that a live session has; it never cues more than what was driven."""
    made = schema()
    made["properties"] = {name: made["properties"][name] for name in names}
    if "scale" in names:
        made["properties"]["scale"] |= {"maximum": 1.0, "x-bound": "greater than 0 and at most 1"}
    return made


def checked(values: Mapping[str, Any]) -> Form:
    """Return the form of a run; see `checked_as`."""
    return checked_as(Form, values)


def checked_as(form: type[F], values: Mapping[str, Any]) -> F:
    """Return a form of values; what is left out has its default.

    Raises
    ------
    InputError : a setting is unknown or beyond its bound; `field` is its name.
    """
    try:
        return form.model_validate(values)
    except ValidationError as error:
        raise _refused(error.errors()[0], form) from None


def changed(values: Mapping[str, Any]) -> dict[str, float]:
    """Return the parameters that are to be changed while it runs, checked as in the form.

    Raises
    ------
    InputError : there are none, one is beyond its bound, or it cannot be changed while it runs.
    """
    if not values:
        raise InputError("the change", "empty", one_of(LIVE, ""))
    for name in values:
        if name in Form.model_fields and name not in LIVE:
            raise InputError(name, "to be changed while it runs", one_of(LIVE, name))
        if values[name] is None:
            raise InputError(name, "empty", "a number while it runs")
    form = checked(values)
    return {name: float(getattr(form, name)) for name in values}


def _refused(detail: ErrorDetails, form: type[Offered]) -> InputError:
    """Return one of pydantic's errors with the form's own words for the bound."""
    if detail["type"] == "bound":
        return InputError(detail["ctx"]["field"], detail["ctx"]["value"], detail["ctx"]["bound"])
    name = str(detail["loc"][0]) if detail["loc"] else "the form"
    if name not in form.model_fields:
        return InputError(name, "unknown", one_of(form.model_fields, name))
    return InputError(name, repr(detail["input"]), bound_of(name, form))
