"""A car as its user describes it: a checked TOML file, and the numbers in the equations of motion."""

import math
from importlib.resources import files
from typing import Annotated, Final, NamedTuple

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from otolith.core.errors import InputError, one_of
from otolith.core.frames import GRAVITY
from otolith.platforms.bounds import Within
from otolith.platforms.validation_messages import sentence, toml_fields

CARS: Final = ("tesla-model-s",)
AIR_DENSITY: Final = 1.2  # [kg/m³] at 20 °C


def _number(low: float, high: float, unit: str = "", meant: tuple[str, str] = ("", "")) -> BeforeValidator:
    return BeforeValidator(Within(low, high, unit, *meant).number)


Share = Annotated[float, _number(0.01, 0.99)]
Length = Annotated[float, _number(0.05, 4.0, "m", ("", "mm"))]
Inertia = Annotated[float, _number(20.0, 50_000.0, "kg m2")]
Stiffness = Annotated[float, _number(1e3, 1e6, "N/m", ("N/mm", ""))]
Damping = Annotated[float, _number(100.0, 50_000.0, "N s/m")]
BarStiffness = Annotated[float, _number(1.0, 1e6, "N m/rad")]
CorneringStiffness = Annotated[float, _number(3.0, 60.0, "1/rad")]
Lag = Annotated[float, _number(0.005, 1.0, "s", ("", "ms"))]
Offset = Annotated[float, Field(ge=-2.0, le=2.0)]


class _Table(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Body(_Table):
    """Masses and their positions; heights are above the road."""

    mass_kg: Annotated[float, _number(200.0, 20_000.0, "kg", ("t", ""))]
    cg_to_front_axle_m: Length
    cg_to_rear_axle_m: Length
    cg_height_m: Length
    track_m: Length
    yaw_inertia_kgm2: Inertia
    roll_inertia_kgm2: Inertia
    pitch_inertia_kgm2: Inertia
    unsprung_mass_kg: Annotated[float, _number(2.0, 500.0, "kg")]
    roll_centre_m: Annotated[float, _number(0.001, 1.0, "m", ("", "mm"))]
    anti_pitch: Share


class Suspension(_Table):
    """Springs and dampers per wheel, anti-roll bars per axle."""

    front_spring_npm: Stiffness
    rear_spring_npm: Stiffness
    front_damper_nspm: Damping
    rear_damper_nspm: Damping
    front_bar_nmprad: BarStiffness
    rear_bar_nmprad: BarStiffness


class Tyres(_Table):
    """Magic Formula (Pacejka 2012, chapter 4) with load-dependent peak and stiffness."""

    friction: Annotated[float, _number(0.05, 2.0)]
    load_sensitivity: Annotated[float, _number(0.001, 0.5)]
    front_stiffness: CorneringStiffness
    rear_stiffness: CorneringStiffness
    stiffness_load: Annotated[float, _number(1.05, 10.0)]
    shape: Annotated[float, _number(1.0, 2.0)]
    curvature: Annotated[float, Field(ge=-5.0, le=1.0)]
    relaxation_m: Annotated[float, _number(0.05, 2.0, "m")]
    vertical_npm: Stiffness


class Powertrain(_Table):
    """Drive, brakes and resistances."""

    power_w: Annotated[float, _number(1e3, 2e6, "W", ("kW", ""))]
    drive_front: Annotated[float, Field(ge=0.0, le=1.0)]
    brake_front: Share
    drive_lag_s: Lag
    brake_lag_s: Lag
    drag_area_m2: Annotated[float, _number(0.05, 10.0, "m2")]
    rolling_resistance: Annotated[float, _number(0.001, 0.1)]


class Steering(_Table):
    """From the driver's command to the road wheels."""

    lag_s: Lag
    rate_degps: Annotated[float, _number(5.0, 500.0, "deg/s", ("rad/s", ""))]


class Head(_Table):
    """The driver's head from the centre of gravity, in the car's axes."""

    x_m: Offset
    y_m: Offset
    z_m: Offset


class CarNumbers(NamedTuple):
    """SI numbers of the equations of motion, in the letters of `otolith.vehicle.dynamics`."""

    m: float
    m_s: float  # sprung
    m_u: float  # unsprung, one wheel
    I_x: float
    I_y: float
    I_z: float
    l_f: float
    l_r: float
    h: float
    h_r: float  # roll centre
    B: float
    anti: float
    k_f: float
    k_r: float
    c_f: float
    c_r: float
    b_f: float  # anti-roll bars
    b_r: float
    k_t: float  # tyre, vertical
    mu: float
    mu_z: float  # loss of friction per static load
    K_f: float  # coefficients of the cornering stiffness, see `dynamics.tyre`
    K_r: float
    z_stiff: float
    C: float
    E: float
    sigma: float  # relaxation length
    P: float
    drive_front: float
    brake_front: float
    T_drive: float
    T_brake: float
    drag: float  # ½ ρ c_d A
    roll_resistance: float
    T_steer: float
    steer_rate: float
    F_f: float  # static load of one front wheel
    F_r: float


class Car(_Table):
    """A car. `estimates` names the tables and fields whose values are estimated, not measured."""

    name: str = Field(min_length=1, max_length=80)
    description: str = ""
    estimates: tuple[str, ...] = Field(default=(), strict=False)
    body: Body
    suspension: Suspension
    tyres: Tyres
    powertrain: Powertrain
    steering: Steering
    driver_head: Head

    @property
    def wheelbase(self) -> float:
        """Return the distance between the axles [m]."""
        return self.body.cg_to_front_axle_m + self.body.cg_to_rear_axle_m

    @property
    def understeer_gradient(self) -> float:
        """Return the steering angle beyond wheelbase/radius per lateral acceleration, if small [rad s²/m].

        K = (m/L) (l_r/C_f − l_f/C_r) with the axles' cornering stiffnesses C. Since these are proportional to
        the static loads, K = (1/c_f − 1/c_r)/g.
        """
        return (1.0 / self.tyres.front_stiffness - 1.0 / self.tyres.rear_stiffness) / GRAVITY

    def numbers(self) -> CarNumbers:
        """Return all numbers in SI units, for the compiled equations of motion."""
        body, springs, tyres = self.body, self.suspension, self.tyres
        drive, steering = self.powertrain, self.steering
        at_static = math.sin(2.0 * math.atan(1.0 / tyres.stiffness_load))
        weight = body.mass_kg * GRAVITY / self.wheelbase / 2.0
        return CarNumbers(
            m=body.mass_kg,
            m_s=body.mass_kg - 4.0 * body.unsprung_mass_kg,
            m_u=body.unsprung_mass_kg,
            I_x=body.roll_inertia_kgm2,
            I_y=body.pitch_inertia_kgm2,
            I_z=body.yaw_inertia_kgm2,
            l_f=body.cg_to_front_axle_m,
            l_r=body.cg_to_rear_axle_m,
            h=body.cg_height_m,
            h_r=body.roll_centre_m,
            B=body.track_m,
            anti=body.anti_pitch,
            k_f=springs.front_spring_npm,
            k_r=springs.rear_spring_npm,
            c_f=springs.front_damper_nspm,
            c_r=springs.rear_damper_nspm,
            b_f=springs.front_bar_nmprad,
            b_r=springs.rear_bar_nmprad,
            k_t=tyres.vertical_npm,
            mu=tyres.friction,
            mu_z=tyres.load_sensitivity,
            K_f=tyres.front_stiffness / at_static,
            K_r=tyres.rear_stiffness / at_static,
            z_stiff=tyres.stiffness_load,
            C=tyres.shape,
            E=tyres.curvature,
            sigma=tyres.relaxation_m,
            P=drive.power_w,
            drive_front=drive.drive_front,
            brake_front=drive.brake_front,
            T_drive=drive.drive_lag_s,
            T_brake=drive.brake_lag_s,
            drag=0.5 * AIR_DENSITY * drive.drag_area_m2,
            roll_resistance=drive.rolling_resistance,
            T_steer=steering.lag_s,
            steer_rate=math.radians(steering.rate_degps),
            F_f=weight * body.cg_to_rear_axle_m,
            F_r=weight * body.cg_to_front_axle_m,
        )


def parse_car(text: str, source: str) -> Car:
    """Read a car from the text of its TOML file; `source` names the file in errors.

    Raises
    ------
    InputError : the text is not TOML, or a field is unknown, missing or out of bounds.
    """
    fields = toml_fields(text, source)
    try:
        car = Car.model_validate(fields)
    except ValidationError as error:
        raise sentence(error, Car, source) from None
    for name in car.estimates:
        if not _has(fields, name):
            raise InputError(f"estimates in {source}", repr(name), "the name of a table or field of the file")
    return car


def load_car(name: str = "tesla-model-s") -> Car:
    """Return a car that is shipped with the package.

    Raises
    ------
    InputError : there is none of this name.
    """
    if name not in CARS:
        raise InputError("car", repr(name), one_of(CARS, name, otherwise=", or a car file (.toml)"))
    return parse_car((files("otolith.vehicle") / "data" / f"{name}.toml").read_text("utf-8"), f"{name}.toml")


def _has(fields: object, name: str) -> bool:
    for part in name.split("."):
        if not isinstance(fields, dict) or part not in fields:
            return False
        fields = fields[part]
    return True
