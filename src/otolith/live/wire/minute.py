"""A recorded minute: what a source sent while its axes were to be learned, brought to one clock."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from otolith.core.arrays import Mat, Vec
from otolith.core.errors import InputError
from otolith.live.messages import Telemetry
from otolith.live.wire.attitude import from_angles
from otolith.recordings.channels import FORCE, RATE, Recording
from otolith.recordings.checks.relations import LEAST

RATE_HZ: Final = 50.0  # [Hz] of the grid on which all quantities are compared
REST: Final = 3.0  # [s] least time at rest


class NotLearned(InputError):
    """A recorded minute does not show the axes of its source; the message names the test that failed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Minute:
    """What a source sent while the experiment was driven, on one clock; vectors as the source states them."""

    source: str
    t: Vec  # (n,) [s]
    force: Mat  # (n, 3)
    rate: Mat  # (n, 3)
    speed: Vec  # (n,) [m/s]
    attitude: Mat | None = None  # (n, 4)
    derived: bool = False  # whether the rates are those of the attitude, because the source sends none


def minute_of(source: str, samples: Sequence[tuple[float, Telemetry]]) -> Minute:
    """Return a minute from samples with their times of arrival [s]; each quantity has its own clock.

    Raises
    ------
    NotLearned : force or speed are not sent, nor rates or an attitude, or they last for less than the
        experiment.
    """
    clocks: dict[str, tuple[Vec, Mat]] = {}
    for name in ("acceleration", "angular_rate", "attitude", "speed"):
        found = [(t, getattr(one, name)) for t, one in samples if getattr(one, name) is not None]
        if found:
            values = np.array([np.atleast_1d(value) for _, value in found])
            clocks[name] = (np.array([t for t, _ in found]), values)
    turns = "angular_rate" if "angular_rate" in clocks else "attitude"
    words = {"acceleration": "a force", turns: "angular rates or an attitude", "speed": "a speed"}
    for name, word in words.items():
        if name not in clocks:
            raise NotLearned(f"what {source} sends", f"without {word}", f"with {', '.join(words.values())}")
    if "attitude" in clocks:
        t, q = clocks["attitude"]
        clocks["attitude"] = (t, _continuous(q))
    begin = max(t[0] for t, _ in clocks.values())
    end = min(t[-1] for t, _ in clocks.values())
    _require_duration(source, end - begin)
    t = np.arange(begin, end, 1.0 / RATE_HZ)
    on = {name: _resampled(t, *clock) for name, clock in clocks.items()}
    return Minute(
        source=source,
        t=t - begin,
        force=on["acceleration"],
        rate=on["angular_rate"] if "angular_rate" in on else _rates(on["attitude"]),
        derived="angular_rate" not in on,
        speed=np.abs(on["speed"][:, 0]),
        attitude=on.get("attitude"),
    )


def minute_of_recording(recording: Recording) -> Minute:
    """Return a minute from a recorded drive as its file states it, before any check of its axes.

    A vertical force, and roll and pitch rate, are zero where the file has none.

    Raises
    ------
    NotLearned : a force, the yaw rate or the speed is missing, or lasts for less than the experiment.
    """
    channels = recording.channels
    for key in ("ax", "ay", "yaw_rate", "vx"):
        if key not in channels:
            raise NotLearned(
                f"columns of {recording.source}", f"without {key}", "with ax, ay, yaw rate and speed"
            )
    known = [channels[key] for key in ("ax", "ay", "yaw_rate", "vx")]
    begin, end = max(float(one.t[0]) for one in known), min(float(one.t[-1]) for one in known)
    _require_duration(recording.source, end - begin)
    t = np.arange(begin, end, 1.0 / RATE_HZ)

    def vector(keys: Sequence[str]) -> Mat:
        zero = np.zeros(len(t))
        return np.stack([channels[key].on(t) if key in channels else zero for key in keys], axis=1)

    yaw = channels.get("yaw")
    return Minute(
        source=recording.source,
        t=t - begin,
        force=vector(FORCE),
        rate=vector(RATE),
        speed=np.abs(channels["vx"].on(t)),
        attitude=None if yaw is None else np.array([from_angles(0.0, 0.0, angle) for angle in yaw.on(t)]),
    )


def _require_duration(source: str, seconds: float) -> None:
    if seconds < REST + LEAST:
        raise NotLearned(f"duration of the minute of {source}", f"{seconds:.1f} s", "about 60 s")


def _resampled(t: Vec, clock: Vec, values: Mat) -> Mat:
    clock, first = np.unique(clock, return_index=True)
    return np.stack([np.interp(t, clock, column) for column in values[first].T], axis=1)


def _continuous(q: Mat) -> Mat:
    """Return quaternions (n, 4) without changes of sign from one to the next, as interpolation needs."""
    flips = np.sum(q[1:] * q[:-1], axis=1) < 0.0
    signs = np.where(np.cumsum(np.r_[False, flips]) % 2 == 1, -1.0, 1.0)
    return q * signs[:, None]


def _rates(q: Mat) -> Mat:
    """Return the angular rates (n, 3) [rad/s] in the car's axes of attitudes (n, 4) on the grid."""
    turned = Rotation.from_quat(np.roll(q, -1, axis=1))
    steps = (turned[:-1].inv() * turned[1:]).as_rotvec() * RATE_HZ
    around = np.concatenate([steps[:1], steps, steps[-1:]])
    rates: Mat = 0.5 * (around[1:] + around[:-1])  # the mean of the steps before and after each instant
    return rates
