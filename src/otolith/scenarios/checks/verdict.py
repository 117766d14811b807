"""What the ground, a map and gravity say of a drive's left and right, and what would mend a contradiction."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np

from otolith.core.errors import InputError
from otolith.scenarios.channels import Channel
from otolith.scenarios.checks.kinematics import TURNING, Kinematics
from otolith.scenarios.checks.relations import SLOPES
from otolith.scenarios.checks.remedies import spelled
from otolith.scenarios.columns import STANDARD_GRAVITY

ROLLING: Final = "roll rate and gravity"
BANK: Final = 0.7  # sin(45 deg): no road is banked more
ALIVE: Final = {"ay": 0.2, "pitch_rate": 0.01, "yaw_rate": 0.01}  # [m/s², rad/s] less is as good as zero


class Verdict:
    """What the witnesses say of a drive's lateral force and yaw rate: +1 as read, -1 turned, 0 nothing."""

    def __init__(self, drive: Kinematics, source: str) -> None:
        self.drive, self.source = drive, source
        sure = [w.name for w in drive.witnesses if w.absolute]
        mapped = [w.name for w in drive.witnesses if not w.absolute]
        self.yaw, self._by_yaw = self._side("yaw_rate", sure)
        self.lateral, self._by_lateral = self._side("ay", sure)
        self.yaw_on_map, self._map = self._side("yaw_rate", mapped)
        if not self.yaw_on_map:
            self.yaw_on_map, self._map = self._side("ay", mapped)
        if not self.yaw_on_map and self.drive.attitude_explains("ay"):
            rolling = self.drive.rolling
            self.yaw_on_map = 1 if rolling is not None and rolling.correlation > 0.0 else -1
            self._map = ROLLING
        self.together = self._together()
        if self.yaw and (not self.lateral or drive.attitude_explains("ay")):
            self.lateral = self.yaw * self.together

    @property
    def by(self) -> str:
        """The words for what decided."""
        return self._by_yaw or self._by_lateral or self._map

    @property
    def proof(self) -> str:
        """What proves that left is left, if something does."""
        return self.by if (self._by_yaw or self._by_lateral) and self.yaw >= 0 <= self.lateral else ""

    @property
    def relative(self) -> str:
        """What agrees on a map of unknown handedness."""
        return self._map if self.yaw_on_map > 0 else ""

    def turned(self, up: float) -> bool:
        """Whether lateral force and yaw rate are turned together, for sure."""
        channels = self.drive.channels
        if self.yaw < 0:
            return self.lateral < 0 or (self.lateral == 0 and (up < 0.0 or not alive(channels, ["ay"])))
        if "yaw_rate" not in channels and self.lateral < 0:
            alone = up == 0.0 and not alive(channels, ["pitch_rate"]) and self._beyond_banks()
            return up < 0.0 or alone
        return up < 0.0 and not self.yaw and self.yaw_on_map < 0 and self.together >= 0

    def refuse_contradiction(self, up: float) -> None:
        """Refuse what a witness contradicts and what cannot simply be turned, with what would mend it.

        `up` tells by gravity whether z points up, +1, down, -1, or nothing.
        """
        channels = self.drive.channels
        if self.yaw < 0:
            ways = ["map " + _remap(channels, ["yaw_rate"])]
            if self.lateral == 0 and up <= 0.0:
                ways.append("--axes sae, which turns ay and the pitch rate, too")
            found = f"against {self._by_yaw}{self._how('yaw_rate')}"
            raise InputError(f"yaw rate in {self.source}", found, _same(ways))
        if self.lateral < 0:
            ways = ["map " + _remap(channels, ["ay"])]
            if "yaw_rate" not in channels and up <= 0.0:
                ways.append("--axes sae, which turns pitch and yaw, too")
            if not self._beyond_banks():
                ways.append("--axes iso if it is right: on a steep bank, or in a vehicle that leans, it is")
            raise InputError(f"ay in {self.source}", f"against {self.by}{self._how('ay')}", _same(ways))
        if not self.proof and self.yaw_on_map < 0 and self.together >= 0:
            keys = [key for key in ("y", "heading") if self._map_is(key)]
            ways = ["--axes sae, which turns ay, pitch and yaw rate"]
            if self._map == ROLLING:
                ways.append(
                    f"map {_remap(channels, ['roll_rate'])} if it counts the left side down as positive"
                )
            ways += [
                f"map {_remap(channels, [key])} if it is the map that is drawn with z down" for key in keys
            ]
            raise InputError(f"turning in {self.source}", f"against {self._map}", _same(ways))

    def refuse_statement(self, axes: str) -> None:
        """Refuse a statement of the user's that the ground contradicts."""
        if self.yaw < 0 or (self.lateral < 0 and self._beyond_banks()):
            witness = next(w for w in self.drive.witnesses if w.name == self.by)
            other = " ".join(f"{key}=none" for key in witness.keys)
            raise InputError(
                "--axes",
                f"{axes}, against {self.by} in {self.source}",
                f"{'iso' if axes == 'sae' else 'sae'}, or left out, or that witness mapped away ({other})",
            )

    def _side(self, key: str, names: Sequence[str]) -> tuple[int, str]:
        for name in names:
            one = self.drive.of(key, name)
            if one is not None and one.strong:
                if one.fits(1.0, SLOPES) or (key == "yaw_rate" and one.correlation > 0.0):
                    return 1, name
                if one.fits(-1.0, SLOPES) or (key == "yaw_rate" and one.correlation < 0.0):
                    return -1, name
        return 0, ""

    def _together(self) -> int:
        one = self.drive.of("ay", TURNING)
        if self.drive.attitude_explains("ay"):
            return 1
        if one is None or not one.strong:
            return 0
        return 1 if one.agrees else -1 if one.fits(-1.0, SLOPES) else 0

    def _how(self, key: str) -> str:
        one = self.drive.of(key, self.by)
        return "" if one is None else f" (correlation {one.correlation:.2f}, slope {one.slope:.2f})"

    def _beyond_banks(self) -> bool:
        """Whether no bank explains a lateral force against the turning."""
        one = self.drive.of("ay", self.by) or self.drive.of("ay", TURNING)
        if one is None or not len(one.start):
            return False
        return float(np.quantile(np.abs(one.measured - one.expected), 0.9)) > BANK * STANDARD_GRAVITY

    def _map_is(self, key: str) -> bool:
        return any(w.name == self._map and key in w.keys for w in self.drive.witnesses)


def alive(channels: Mapping[str, Channel], keys: Iterable[str]) -> bool:
    """Whether any of these quantities says anything."""
    return any(key in channels and float(np.std(channels[key].values)) > ALIVE[key] for key in keys)


def _remap(channels: Mapping[str, Channel], keys: Iterable[str]) -> str:
    return " and ".join(f"{key}={spelled(channels[key].column, -1.0)}" for key in keys)


def _same(ways: Sequence[str]) -> str:
    if len(ways) == 1:
        return f"of the same sign ({ways[0]}, which makes this file agree)"
    return f"of the same sign (more than one thing makes this file agree: {'; or '.join(ways)})"
