"""The relations of one drive: which of its channels can be compared, and with what result."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.recordings.channels import Channel
from otolith.recordings.checks.relations import (
    LEAST,
    QUIET,
    Relation,
    relation,
    window_changes,
    window_means,
    windows,
)
from otolith.recordings.checks.witnesses import Witness, witnesses
from otolith.recordings.columns import STANDARD_GRAVITY

COMPARED: Final = ("ax", "ay", "yaw_rate", "vx")
CHANGE: Final = "the change of speed"
TURNING: Final = "speed × yaw rate"
SHARES: Final = (0.85, 1.2)  # slopes of gravity's share, which suspension and a delayed speed do not affect
LAG: Final = 2  # windows, one per second, between two angles
GUESSED_SPEED: Final = 15.0  # [m/s] only scales a yaw rate to the size of a force
SLOW: Final = 2.0  # [m/s] below which a course proves nothing
MOVING: Final = 1e-3  # [rad/s] least standard deviation of a gyro; a channel with less is unused


class Kinematics:
    """Compares the channels of a drive with each other.

    Parameters
    ----------
    channels : the channels of a recording, by quantity.
    """

    def __init__(self, channels: Mapping[str, Channel]) -> None:
        self.channels = channels
        self.witnesses: Sequence[Witness] = tuple(witnesses(channels))
        placed = next((w.speed for w in self.witnesses if w.speed is not None), None)
        self.speed = channels.get("vx", placed)
        self._speed_power = {"vx": -1} if "vx" in channels else {}
        self._placed = placed
        spans = [channels[key] for key in ("ax", "ay", "yaw_rate", "az") if key in channels]
        begin = min((c.t[0] for c in spans), default=0.0)
        self.start = windows(float(begin), float(max((c.t[-1] for c in spans), default=0.0)))
        self.relations: Sequence[Relation] = tuple(r for r in self._relations() if len(r.start))
        self.rolling = self._gravity_share("ay", "roll_rate", 1.0)
        self.pitching = self._gravity_share("ax", "pitch_rate", -1.0)
        self._opposed = {
            "ay": self._gravity_share("ay", "roll_rate", 1.0, turned=True),
            "ax": self._gravity_share("ax", "pitch_rate", -1.0, turned=True),
        }

    def of(self, key: str, by: str) -> Relation | None:
        """Return the relation of a quantity with `CHANGE`, `TURNING` or the witness of this name."""
        return next((r for r in self.relations if r.key == key and r.by == by), None)

    def share_of_gravity(self, key: str) -> Relation | None:
        """Relate the part of a force that no level road explains to the gyro's pitch or roll angle."""
        return {"ax": self.pitching, "ay": self.rolling}.get(key)

    def attitude_explains(self, key: str, sign: float = 0.0) -> bool:
        """Return whether gravity, in the gyro's roll or pitch, explains a force that a level road does not.

        Parameters
        ----------
        sign : +1 for x forward, y left, z up; -1 for SAE J670, where lateral force and pitch are turned and
            roll is not; 0 for either.
        """
        share = self.share_of_gravity(key)
        return share is not None and share.strong and _is_gravity(share, sign)

    def attitude_opposes(self, key: str) -> bool:
        """Return whether gravity explains a force only if its sign, or that of its comparison, is turned."""
        opposed = self._opposed[key]
        turned = opposed is not None and opposed.strong and _is_gravity(opposed)
        return turned and not self.attitude_explains(key)

    def attitude_shows(self, key: str) -> bool:
        """Return whether a gyro moves that would show a slope or bank that could explain a turned force."""
        needed = self._opposed[key]
        if needed is None or float(np.std(needed.measured)) < 2.0 * QUIET[key]:
            return False
        gyro = self.channels[{"ax": "pitch_rate", "ay": "roll_rate"}[key]]
        return float(np.std(gyro.values)) > MOVING

    def side_of_gravity(self, key: str) -> float:
        """Return the sign of the correlation of a force that `attitude_opposes` with the gyro's angle."""
        opposed = self._opposed[key]
        return 0.0 if opposed is None else float(np.sign(opposed.correlation))

    def crossed(self) -> tuple[Relation, Relation] | None:
        """Return the relations of a_x and a_y as if exchanged; None unless all four channels exist."""
        if self.speed is None or not {"ax", "ay", "yaw_rate"} <= set(self.channels):
            return None
        ax, ay = (window_means(self.channels[key], self.start) for key in ("ax", "ay"))
        ahead = relation("ax", CHANGE, self.start, ay, window_changes(self.speed, self.start), {})
        return ahead, relation("ay", TURNING, self.start, ax, self._centripetal(), {})

    def forward_in_az(self) -> Relation | None:
        """Relate a_z to the change of speed, if a_x exists and does not follow it."""
        straight = self.of("ax", CHANGE)
        if self.speed is None or "az" not in self.channels or straight is None:
            return None
        az = window_means(self.channels["az"], self.start)
        found = relation("ax", CHANGE, self.start, az, window_changes(self.speed, self.start), {})
        return found if straight.informative and abs(straight.correlation) < 0.5 else None

    def signs(self) -> Relation:
        """Relate the lateral force to the yaw rate; without a speed only the sign is meaningful."""
        ay, turning = (window_means(self.channels[key], self.start) for key in ("ay", "yaw_rate"))
        return relation("ay", "yaw rate", self.start, ay, GUESSED_SPEED * turning, {})

    def _relations(self) -> Sequence[Relation]:
        found, start, speed = [], self.start, self.speed
        means = {key: window_means(c, start) for key, c in self.channels.items() if key in COMPARED}
        if speed is not None and "ax" in means:
            powers = {"ax": 1, **self._speed_power}
            found.append(relation("ax", CHANGE, start, means["ax"], window_changes(speed, start), powers))
        if speed is not None and {"ay", "yaw_rate"} <= set(means):
            powers = {"ay": 1, "yaw_rate": -1, **self._speed_power}
            found.append(relation("ay", TURNING, start, means["ay"], self._centripetal(), powers))
        for witness in self.witnesses:
            found += self._seen_by(witness, means)
        if "vx" in means and self._placed is not None:
            placed = window_means(self._placed, start)
            found.append(relation("vx", "the way between positions", start, means["vx"], placed, {"vx": 1}))
        return found

    def _seen_by(self, witness: Witness, means: Mapping[str, Vec]) -> Sequence[Relation]:
        turning, found = window_changes(witness.course, self.start), []
        speed = None if self.speed is None else window_means(self.speed, self.start)
        if speed is not None:
            turning = np.where(np.abs(speed) > SLOW, turning, np.nan)
        if "yaw_rate" in means:
            seen = relation(
                "yaw_rate",
                f"the turning of {witness.name}",
                self.start,
                means["yaw_rate"],
                turning,
                {"yaw_rate": 1},
            )
            found.append(replace(seen, by=witness.name))
        if "ay" in means and speed is not None:
            powers = {"ay": 1, **self._speed_power}
            seen = relation(
                "ay",
                f"speed × the turning of {witness.name}",
                self.start,
                means["ay"],
                speed * turning,
                powers,
            )
            found.append(replace(seen, by=witness.name))
        return found

    def _gravity_share(self, key: str, gyro: str, sign: float, *, turned: bool = False) -> Relation | None:
        """Relate changes of a force that a level road does not explain to gravity times the angle turned.

        On a bank or slope, and in a vehicle that leans or whose body rolls, f_y = v r + g sin(roll) and f_x =
        dv/dt - g sin(pitch). Changes over two seconds cancel the gyro's bias and the unknown initial angle.

        Parameters
        ----------
        turned : whether the contribution of a level road is taken with the opposite sign, as if it or the
            force were turned.
        """
        level = self.of(key, CHANGE if key == "ax" else TURNING)
        if level is None or gyro not in self.channels or len(level.start) < LEAST + LAG:
            return None
        angle = window_means(_integral(self.channels[gyro]), level.start)
        left = level.measured - (-level.expected if turned else level.expected)
        apart = np.isclose(level.start[LAG:] - level.start[:-LAG], LAG)
        words = f"gravity in the {gyro.removesuffix('_rate')} that the gyro gives"
        turning = sign * STANDARD_GRAVITY * (angle[LAG:] - angle[:-LAG])
        return relation(
            key, words, level.start[LAG:][apart], (left[LAG:] - left[:-LAG])[apart], turning[apart], {}
        )

    def _centripetal(self) -> Vec:
        """Return the means of v r over the windows."""
        assert self.speed is not None  # noqa: S101 - asked before
        turning = self.channels["yaw_rate"]
        product = replace(turning, values=turning.values * self.speed.on(turning.t))
        speed = window_means(self.speed, self.start)  # shows where the speed is known
        return np.where(np.isfinite(speed), window_means(product, self.start), np.nan)


def _is_gravity(share: Relation, sign: float = 0.0) -> bool:
    """Return whether a share has the size of gravity with this sign, or with either sign if it is 0."""
    return any(share.fits(one, SHARES) for one in ((1.0, -1.0) if sign == 0.0 else (sign,)))


def _integral(channel: Channel) -> Channel:
    """Return the angle that a rate has turned by since its first sample."""
    area = np.cumsum(0.5 * (channel.values[1:] + channel.values[:-1]) * np.diff(channel.t))
    return replace(channel, values=np.r_[0.0, area])
