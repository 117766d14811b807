"""Evidence of left and right from ground, map and gravity, and remedies for what contradicts it."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings.channels import Channel
from otolith.recordings.checks.kinematics import CHANGE, TURNING, Kinematics
from otolith.recordings.checks.relations import SLOPES, Relation
from otolith.recordings.checks.remedies import spelled
from otolith.recordings.columns import STANDARD_GRAVITY

ROLLING: Final = "roll rate and gravity"
PITCHING: Final = "pitch rate and gravity"
FAINT: Final = 0.15  # share of v r below which a lateral force does not show its sign
BANK: Final = 0.7  # sine of 45 deg: no oval is banked more …
CANT: Final = 0.15  # … and no road that turns both ways, nor a railway (AASHTO: 12 %; 180 mm on 1,500 mm)
ONE_WAY: Final = 0.1  # largest share of the turning on an oval that goes the other way
ALIVE: Final = {
    "ax": 0.05,
    "ay": 0.2,
    "az": 0.05,
    "roll_rate": 0.002,
    "pitch_rate": 0.002,
    "yaw_rate": 0.01,
}  # [m/s², rad/s] a smaller standard deviation counts as zero


class Verdict:
    """Judges lateral force and yaw rate by the witnesses: +1 correct as read, -1 turned, 0 undecided.

    A yaw rate shows the turning on any road. A lateral force shows it only if no bank explains the contrary.
    """

    def __init__(self, drive: Kinematics, source: str) -> None:
        self.drive, self.source = drive, source
        sure = [w.name for w in drive.witnesses if w.absolute]
        mapped = [w.name for w in drive.witnesses if not w.absolute]
        self.together = self._together()
        self.yaw, self._by_yaw = self._side("yaw_rate", sure)
        self.lateral, self._by_lateral = self._side("ay", sure)
        if "yaw_rate" in drive.channels:
            self.lateral = self.yaw * self.together
        self.relative, self._map = self._side("yaw_rate", mapped)
        if not self.relative:
            self.relative, self._map = self._side("ay", mapped)
        for key, words in (("ay", ROLLING), ("ax", PITCHING)):
            if not self.relative and drive.attitude_explains(key):
                self.relative, self._map = (1 if drive.attitude_explains(key, 1.0) else -1), words

    @property
    def by(self) -> str:
        """Return the deciding witness in words."""
        return self._by_yaw or self._by_lateral or self._map

    @property
    def proof(self) -> str:
        """Return what proves left and right, if anything does, and what could still mislead it."""
        if self.yaw > 0:
            return self._by_yaw
        if self.yaw or self.lateral <= 0 or not self._by_lateral:
            return ""
        one = self.drive.of("ay", self._by_lateral)
        share = 1.0 if one is None else self._share(one.measured + one.expected)
        if share > BANK:
            return self._by_lateral
        return f"{self._by_lateral}, unless the road is banked by {np.degrees(np.arcsin(share)):.0f} deg"

    @property
    def bank(self) -> float:
        """Return the bank [rad] that explains everything if only lateral force or only yaw rate is turned.

        On an oval that is driven slowly, gravity outweighs v r. There the two have opposite signs, so equal
        signs in a file may mean that one of them is wrong. The result is zero if no bank explains this.
        """
        one = self.drive.of("ay", TURNING)
        if one is None or not one.agrees or self.drive.attitude_shows("ay"):
            return 0.0
        share = self._share(one.measured + one.expected)
        return float(np.arcsin(share)) if share < (BANK if _one_way(one.expected) else CANT) else 0.0

    @property
    def condition(self) -> str:
        """Return the condition on which relative evidence proves left and right; empty if it disagrees."""
        if self.relative <= 0:
            return ""
        if self._map == ROLLING:
            how = "the roll rate counts the right side down as positive, as ISO 8855 and SAE J670 both do"
        elif self._map == PITCHING:
            how = "the pitch rate is in the axes of the lateral force"
        else:
            how = "that map is drawn with z up (x east and y north, say)"
        return f"{self._map}, which proves them only if {how}"

    def turned(self, up: float) -> bool:
        """Return whether lateral force and yaw rate are certainly both turned."""
        channels = self.drive.channels
        if self.yaw < 0 and self.bank and up >= 0.0:
            return False
        if self.yaw < 0:
            others = ["ay"] if up > 0.0 else ["ay", "pitch_rate", "az"]
            return self.lateral < 0 or (self.lateral == 0 and (up < 0.0 or not alive(channels, others)))
        if "yaw_rate" not in channels and self.lateral < 0:
            return up < 0.0 or (up == 0.0 and not {"az", "pitch_rate"} & set(channels))
        return up < 0.0 and not self.yaw and self.relative < 0 and self.together >= 0

    def refuse_contradiction(self, up: float) -> None:
        """Refuse what contradicts a witness and cannot simply be turned, and name the remedies.

        Parameters
        ----------
        up : +1 if gravity shows that z points up, -1 if it points down, 0 if unknown.
        """
        channels = self.drive.channels
        banked = f" if the road is banked by {np.degrees(self.bank):.0f} deg" if self.bank else ""
        single = self.together <= 0 or banked or (self._map == ROLLING and not self._level())
        alone = [f"map {_remap(channels, ['yaw_rate'])}{banked}"] if "yaw_rate" in channels and single else []
        whole = ["--axes sae, which turns ay, pitch and yaw rate"] if up <= 0.0 and self.together >= 0 else []
        whole += [f"map {_remap(channels, ['ay', 'yaw_rate'])}"] if up > 0.0 and banked else []
        if self.yaw < 0:
            found = f"against {self._by_yaw}{self._how('yaw_rate')}"
            raise InputError(f"yaw rate in {self.source}", found, _same(alone + whole))
        if "yaw_rate" not in channels and self.lateral < 0:
            ways = [f"map {_remap(channels, ['ay'])}", *whole]
            raise InputError(f"ay in {self.source}", f"against {self.by}{self._how('ay')}", _same(ways))
        if not self.proof and self.relative < 0:
            raise InputError(
                f"turning in {self.source}", f"against {self._map}", _same(whole + alone + self._other_maps())
            )

    def refuse_gyro(self) -> None:
        """Refuse a roll or pitch rate that contradicts gravity, if the ground proves all other axes."""
        for key, gyro in (("ay", "roll_rate"), ("ax", "pitch_rate")):
            if (
                self.proof
                and self.drive.attitude_explains(key)
                and not self.drive.attitude_explains(key, 1.0)
            ):
                way = f"map {_remap(self.drive.channels, [gyro])}"
                found = f"against gravity's share of {key}"
                raise InputError(f"{gyro} in {self.source}", found, _same([way]))

    def unproven(self, up: float) -> list[str]:
        """Return the quantities whose sign neither ground, turning nor gravity shows."""
        shown = {"ay": "roll_rate", "ax": "pitch_rate"}
        judged = {gyro for key, gyro in shown.items() if self.drive.attitude_explains(key)}
        others = {"roll_rate", "pitch_rate", *(() if up else ("az",))} - judged
        ahead = self.drive.of("ax", CHANGE)
        if (ahead is None or not ahead.informative) and not self.drive.attitude_explains("ax"):
            others.add("ax")
        return [key for key in self.drive.channels if key in others and alive(self.drive.channels, [key])]

    @property
    def faint(self) -> bool:
        """Return whether gravity cancels so much of the lateral force that its sign cannot be judged."""
        one = self.drive.of("ay", TURNING)
        return self.drive.attitude_explains("ay") and one is not None and abs(one.slope) < FAINT

    def _level(self) -> bool:
        one = self.drive.of("ay", TURNING)
        return one is not None and one.agrees

    def _other_maps(self) -> list[str]:
        channels = self.drive.channels
        if self._map == ROLLING:
            return [f"map {_remap(channels, ['roll_rate'])} if it counts the left side down as positive"]
        if self._map == PITCHING:
            return [f"map {_remap(channels, [key])}" for key in ("pitch_rate", "ax")]
        keys = [
            k
            for k in ("y", "heading")
            if any(w.name == self._map and k in w.keys for w in self.drive.witnesses)
        ]
        return [f"map {_remap(channels, [key])} if it is the map that is drawn with z down" for key in keys]

    def refuse_statement(self, axes: str) -> None:
        """Refuse axes stated by the user that the ground contradicts."""
        if self.yaw < 0 or self.lateral < 0:
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
            if one is None or not one.strong:
                continue
            if key == "yaw_rate":
                return (1 if one.correlation > 0.0 else -1), name
            if one.agrees:
                return 1, name
            if one.fits(-1.0, SLOPES) and self._beyond_banks(one):
                return -1, name
        return 0, ""

    def _together(self) -> int:
        """Return +1 if lateral force and yaw rate have the same sign, -1 if surely not, 0 if undecided."""
        one = self.drive.of("ay", TURNING)
        if self.drive.attitude_explains("ay"):
            return 0 if self.faint else 1
        if self.drive.attitude_opposes("ay"):
            return -1
        if one is None or not one.strong:
            return 0
        return 1 if one.agrees else -1 if one.fits(-1.0, SLOPES) and self._beyond_banks(one) else 0

    def _how(self, key: str) -> str:
        one = self.drive.of(key, self.by)
        return "" if one is None else f" (correlation {one.correlation:.2f}, slope {one.slope:.2f})"

    def _beyond_banks(self, one: Relation) -> bool:
        """Return whether no bank explains how a lateral force differs from that on a level road."""
        return self._share(one.measured - one.expected) > BANK

    def _share(self, difference: Vec) -> float:
        """Return the difference that is exceeded in a tenth of the time, in units of 1 g."""
        return float(np.quantile(np.abs(difference), 0.9)) / STANDARD_GRAVITY if len(difference) else 0.0


def alive(channels: Mapping[str, Channel], keys: Iterable[str]) -> bool:
    """Return whether any of these quantities varies enough to carry information."""
    return any(key in channels and float(np.std(channels[key].values)) > ALIVE[key] for key in keys)


def _one_way(turning: Vec) -> bool:
    """Return whether nearly all turning goes one way, as on an oval."""
    left, right = float(turning[turning > 0.0].sum()), float(-turning[turning < 0.0].sum())
    return min(left, right) <= ONE_WAY * (left + right)


def _remap(channels: Mapping[str, Channel], keys: Iterable[str]) -> str:
    return " and ".join(f"{key}={spelled(channels[key].column, -1.0)}" for key in keys)


def _same(ways: Sequence[str]) -> str:
    if len(ways) == 1:
        return f"of the same sign ({ways[0]}, which makes this file agree)"
    return f"of the same sign (more than one thing makes this file agree: {'; or '.join(ways)})"
