"""Drives whose truth is known in closed form: any speed, turning, bank, slope and lean.

The sensor sits at a point that moves along its own x axis with speed v; attitude is yaw, pitch, roll
(intrinsic z-y-x, x forward, y left, z up: pitch is nose-down). Then f = R^T (a + g z), and with the rates
ω = (p, q, r) of that attitude a = R (dv/dt, 0, 0) + R (ω × (v, 0, 0)), so
f = (dv/dt, r v, -q v) + R^T (0, 0, g).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from otolith.core.arrays import Vec

G = 9.80665
EARTH = 6_371_008.8


class Ride(NamedTuple):
    """What a sensor on board shows, in x forward, y left, z up, and where the vehicle was."""

    t: Vec
    force: Vec  # (n, 3) [m/s²] with gravity
    rate: Vec  # (n, 3) [rad/s]
    speed: Vec
    yaw: Vec  # [rad] counter-clockwise from x (east)
    place: Vec  # (n, 2) [m] east, north

    def channels(self) -> dict[str, Vec]:
        """By quantity, SI."""
        names = ("ax", "ay", "az", "roll_rate", "pitch_rate", "yaw_rate")
        felt = dict(zip(names, np.column_stack([self.force, self.rate]).T, strict=True))
        lat0, lon0 = np.radians(50.0), np.radians(8.0)
        return felt | {
            "t": self.t,
            "vx": self.speed,
            "x": self.place[:, 0],
            "y": self.place[:, 1],
            "heading": np.mod(0.5 * np.pi - self.yaw, 2.0 * np.pi),
            "lat": lat0 + self.place[:, 1] / EARTH,
            "lon": lon0 + self.place[:, 0] / (EARTH * np.cos(lat0)),
        }


Of = Callable[[Vec], Vec]


def ride(
    speed: Of, turning: Of, *, bank: Of = np.zeros_like, climb: Of = np.zeros_like, length: float = 120.0
) -> Ride:
    """A ride with speed [m/s], turning about the vertical [rad/s], roll [rad] and climb [rad] over time."""
    h = 1e-3
    t = np.arange(0.0, length, h)
    v, w = speed(t), turning(t)
    yaw = np.r_[0.0, np.cumsum(0.5 * (w[1:] + w[:-1]) * h)]
    roll, pitch = bank(t), -climb(t)
    dv, droll, dpitch = (np.gradient(x, h) for x in (v, roll, pitch))
    p = droll - w * np.sin(pitch)
    q = dpitch * np.cos(roll) + w * np.cos(pitch) * np.sin(roll)
    r = -dpitch * np.sin(roll) + w * np.cos(pitch) * np.cos(roll)
    fx = dv - G * np.sin(pitch)
    fy = v * r + G * np.cos(pitch) * np.sin(roll)
    fz = -v * q + G * np.cos(pitch) * np.cos(roll)
    along = v * np.cos(pitch)
    place = np.cumsum(np.stack([along * np.cos(yaw), along * np.sin(yaw)], axis=1) * h, axis=0)
    keep = slice(None, None, 20)
    return Ride(
        t[keep],
        np.stack([fx, fy, fz], axis=1)[keep],
        np.stack([p, q, r], axis=1)[keep],
        v[keep],
        yaw[keep],
        place[keep],
    )


def _road(t: Vec) -> Vec:
    return 0.12 * np.sin(0.2 * t) + 0.08 * np.sin(0.47 * t)


def _pace(t: Vec) -> Vec:
    return 18.0 + 6.0 * np.sin(0.3 * t) + 2.0 * np.sin(0.11 * t)


def _oval(t: Vec, lap: float = 40.0) -> Vec:
    """One in the bends of an oval, zero on its straights, smooth in between: two bends a lap."""
    return np.clip(1.5 * np.sin(4.0 * np.pi * t / lap) + 0.5, 0.0, 1.0) ** 2


def car() -> Ride:
    """A car on a level road."""
    return ride(_pace, _road)


def oval(speed: float, *, banked_deg: float = 31.0, radius: float = 300.0) -> Ride:
    """A car on an oval that turns left on banks, lifting a little for the bends."""

    def pace(t: Vec) -> Vec:
        return speed * (1.0 - 0.05 * _oval(t))

    return ride(
        pace,
        lambda t: pace(t) / radius * _oval(t),
        bank=lambda t: -np.radians(banked_deg) * _oval(t),
    )


def hills(*, drive: float = 0.7, steep: float = 0.06) -> Ride:
    """A lorry on rolling hills that makes up for this share of the slope and loses speed by the rest."""

    def climb(t: Vec) -> Vec:
        return steep * np.sin(0.15 * t)

    def pace(t: Vec) -> Vec:
        return 20.0 + (1.0 - drive) * G * steep / 0.15 * (np.cos(0.15 * t) - 1.0)

    return ride(pace, lambda t: 0.5 * _road(t), climb=climb)


def mountain(*, steep: float = 0.07) -> Ride:
    """A car up a mountain with one slope all the way, round one hairpin after another."""
    return ride(_pace, lambda t: 2.0 * _road(t), climb=lambda t: np.full_like(t, steep))


def motorcycle(*, lean: float = 1.0) -> Ride:
    """A motorcycle that leans by this share of what balances it: less or more shows in its lateral force."""
    return ride(_pace, _road, bank=lambda t: -lean * np.arctan(_pace(t) * _road(t) / G))


def train(*, tilt: float = 0.6) -> Ride:
    """A tilting train that makes up for a share of the lateral acceleration."""
    return motorcycle(lean=tilt)
