"""Rides written as logs, and read back through the door that users come by."""

from collections.abc import Iterable, Mapping

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings import Log, parse_log
from otolith.recordings.settings import PLAIN, LogSettings
from tests.recordings.vehicles import G, Ride

ALL = ("ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate", "vx")
SAE = ("ay", "az", "pitch_rate", "yaw_rate")
FELT = ("ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")
NAMES = {
    "t": "time_s",
    "ax": "ax_mps2",
    "ay": "ay_mps2",
    "az": "az_mps2",
    "roll_rate": "roll_rate_radps",
    "pitch_rate": "pitch_rate_radps",
    "yaw_rate": "yaw_rate_radps",
    "vx": "speed_mps",
    "lat": "latitude (deg)",
    "lon": "longitude (deg)",
    "heading": "heading (deg)",
    "x": "x_m",
    "y": "y_m",
}


def text(data: Mapping[str, Vec], names: Mapping[str, str] = NAMES) -> str:
    """Quantities in SI as CSV under names that tell what they are; angles in degrees."""
    shown = {k: np.degrees(v) if k in ("lat", "lon", "heading") else v for k, v in data.items()}
    rows = (",".join(f"{value:.10g}" for value in row) for row in zip(*shown.values(), strict=True))
    return "\n".join([",".join(names[key] for key in shown), *rows]) + "\n"


def written(one: Ride, keys: Iterable[str] = ALL, turned: Iterable[str] = ()) -> dict[str, Vec]:
    """Time and these quantities of a ride, some with their signs turned."""
    data, turned = one.channels(), set(turned)
    return {"t": data["t"], **{key: -data[key] if key in turned else data[key] for key in keys}}


def read(data: Mapping[str, Vec], settings: LogSettings = PLAIN, **columns: str) -> Log:
    return parse_log(text(data), "ride.csv", columns=columns, settings=settings)


def attempt(data: Mapping[str, Vec], settings: LogSettings = PLAIN, **columns: str) -> tuple[Log | None, str]:
    """The log, or the sentence that refuses it."""
    try:
        return read(data, settings, **columns), ""
    except InputError as error:
        return None, str(error)


def truth(one: Ride, keys: Iterable[str]) -> dict[str, Vec]:
    """What a reader should make of these quantities: x forward, y left, z up, without the standing 1 g."""
    data = one.channels()
    return {key: data[key] - G if key == "az" else data[key] for key in keys if key in FELT}


def differs(log: Log, expected: Mapping[str, Vec]) -> dict[str, float]:
    """RMS error of each quantity as a share of its RMS (or of 0.1, if it is less)."""
    errors = {}
    for key, values in expected.items():
        got = log.channels[key].values
        size = max(float(np.sqrt(np.mean(values**2))), 0.1)
        errors[key] = float(np.sqrt(np.mean((got - values) ** 2))) / size
    return errors
