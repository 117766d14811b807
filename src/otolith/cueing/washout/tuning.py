"""How conventional washouts are tuned to a platform: scaling, filters and weights from a TOML file.

A washout knows no limits, so its parameters must suit the platform; each shipped platform has its own.
Degrees appear only in names with `deg`; the code that reads the values converts them.
"""

from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files
from typing import Annotated, Final, Self, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError, model_validator

from otolith.core.errors import InputError, one_of
from otolith.platforms.bounds import Within, refuse
from otolith.platforms.validation_messages import sentence, toml_fields

T = TypeVar("T", bound="_Table")
_FOLDER: Final = files("otolith.cueing.washout") / "tunings"

Corner = Annotated[float, BeforeValidator(Within(1e-3, 100.0, "rad/s", "", "deg/s").number)]  # [rad/s]
Damping = Annotated[float, BeforeValidator(Within(0.3, 5.0, "").number)]  # [-]
Slope = Annotated[float, BeforeValidator(Within(0.01, 2.0, "").number)]  # [-]
Force = Annotated[float, BeforeValidator(Within(0.1, 50.0, "m/s2", "g").number)]  # [m/s²]
Rate = Annotated[float, BeforeValidator(Within(1.0, 500.0, "deg/s", "rad/s").number)]  # [deg/s]
Weight = Annotated[float, BeforeValidator(Within(1e-9, 1e9, "").number)]  # [1/SI²]
Speed = Annotated[float, BeforeValidator(Within(1e-6, 1e6, "").number)]  # of adaptation


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class _Cubic(_Table):
    slope: Slope  # output per input of small signals

    def _must_grow(self, unit: str) -> None:
        """Refuse a cubic that is not increasing; `unit` is the ending of the field names in the file."""
        largest, limit = getattr(self, f"largest_{unit}"), getattr(self, f"limit_{unit}")
        if 3.0 * limit < self.slope * largest * (1.0 - 1e-9):
            raise refuse(
                f"at least slope × largest_{unit} / 3 = {self.slope * largest / 3:.4g}, or large inputs "
                "come out smaller than middling ones",
                field=f"limit_{unit}",
                value=limit,
            )


class ForceScaling(_Cubic):
    """Third-order scaling of specific force, constant at `limit` from `largest` on."""

    largest_mps2: Force
    limit_mps2: Force

    @model_validator(mode="after")
    def _check(self) -> Self:
        self._must_grow("mps2")
        return self


class RateScaling(_Cubic):
    """Scaling of a reference's angular rate: slope and saturation."""

    largest_degps: Rate
    limit_degps: Rate

    @model_validator(mode="after")
    def _check(self) -> Self:
        self._must_grow("degps")
        return self


class Scaling(_Table):
    """Scaling of the reference, before any filter."""

    force: ForceScaling
    rate: RateScaling


class SecondOrder(_Table):
    """Natural frequency and damping of a low-pass or high-pass."""

    natural_radps: Corner
    damping: Damping = 1.0


class ThirdOrder(SecondOrder):
    """A second-order high-pass times a first-order one, so that travel returns to zero."""

    washout_radps: Corner


class Classical(_Table):
    """Filters of the classical washout (thesis, eqs. 2.2 and 2.4)."""

    surge: ThirdOrder
    sway: ThirdOrder
    heave: ThirdOrder
    tilt: SecondOrder  # low-pass of tilt coordination
    rotation: SecondOrder  # high-pass of roll, pitch and yaw rate


LEAST_FACTOR, LARGEST_FACTOR = 0.5, 2.0  # of corner frequencies


@dataclass(frozen=True, slots=True, kw_only=True)
class Corners:
    """Factors of the classical washout's corner frequencies; with 1 they are those of its tuning.

    Raises
    ------
    InputError : a factor is beyond 0.5 to 2.
    """

    high_pass: float = 1.0  # of translations and rotations: a larger one returns sooner, and passes less on
    low_pass: float = 1.0  # of tilt coordination: a larger one tilts sooner

    def __post_init__(self) -> None:
        for one in fields(self):
            factor = getattr(self, one.name)
            if not LEAST_FACTOR <= factor <= LARGEST_FACTOR:
                raise InputError(one.name, factor, f"between {LEAST_FACTOR:g} and {LARGEST_FACTOR:g}")


class Adaptive(_Table):
    """Filters, weights and bounds of the adaptive washout (eqs. 2.6, 2.7)."""

    surge: SecondOrder
    sway: SecondOrder
    heave: SecondOrder
    tilt: SecondOrder
    rotation: SecondOrder
    force_weight: Weight  # W1
    rate_weight: Weight  # W2
    velocity_weight: Weight  # W3
    position_weight: Weight  # W4
    gain_weight: Weight  # W7, W8: on the gains' distance from 1
    speed: Speed  # K of the translations' gains
    rate_speed: Speed  # K of the rotations' gains
    least_gain: Annotated[float, BeforeValidator(Within(1e-6, 1.0, "").number)]
    largest_gain: Annotated[float, BeforeValidator(Within(1.0, 3.0, "").number)]


class Optimal(_Table):
    """Weights of the optimal washout (eq. 2.5), and the noise that models the drive."""

    sensed_force: Weight  # Q
    sensed_rate: Weight
    integral: Weight  # R_d: of the position's integral, position, velocity, tilt
    position: Weight
    velocity: Weight
    tilt: Weight
    acceleration: Weight  # R
    rate: Weight
    force_noise_radps: Corner  # break frequencies of the filtered white noise
    rate_noise_radps: Corner
    alpha_per_s: Speed  # nonlinear variant: α = this · (s² + v²) [1/s], at most
    largest_alpha_per_s: Speed


class Tuning(_Table):
    """All parameters of the washouts, except the platform's tilt threshold.

    A file may contain the table of only one washout; `of` refuses to return another one.

    Examples
    --------
    >>> load_tuning("davsi").of(Classical).surge.damping
    1.0
    """

    name: str = Field(min_length=1, max_length=80)
    description: str = ""
    scaling: Scaling
    classical: Classical | None = None
    adaptive: Adaptive | None = None
    optimal: Optimal | None = None
    catch_up_radps: Corner = 5.0  # how fast a tilt catches up after a rate limit
    home_radps: Corner = 0.5  # how fast a platform returns that starts outside the neutral pose

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not (self.classical or self.adaptive or self.optimal):
            raise refuse("given, or [adaptive], or [optimal]", field="classical", value="missing")
        return self

    def of(self, washout: type[T]) -> T:
        """Return the table of one of the washouts: `Classical`, `Adaptive` or `Optimal`.

        Raises
        ------
        InputError : the file has no such table.
        """
        name = washout.__name__.lower()
        table = getattr(self, name)
        if not isinstance(table, washout):
            raise InputError(f"[{name}] of tuning {self.name}", "missing", f"given for the {name} washout")
        return table


def tunings() -> tuple[str, ...]:
    """Return the names of the shipped tunings, sorted; each belongs to the platform of the same name."""
    names = (entry.name.removesuffix(".toml") for entry in _FOLDER.iterdir() if entry.name.endswith(".toml"))
    return tuple(sorted(names))


@cache
def load_tuning(name: str) -> Tuning:
    """Return a shipped tuning by name; it is read once.

    Raises
    ------
    InputError : there is none of this name.
    """
    if name not in tunings():
        raise InputError("tuning", repr(name), one_of(tunings(), name, otherwise=", or a file (.toml)"))
    return parse_tuning((_FOLDER / f"{name}.toml").read_text(encoding="utf-8"), f"{name}.toml")


def parse_tuning(text: str, source: str) -> Tuning:
    """Read a tuning from the text of its TOML file; errors are those of `parse_platform`."""
    fields = toml_fields(text, source)
    try:
        return Tuning.model_validate(fields)
    except ValidationError as error:
        raise sentence(error, Tuning, source) from None
