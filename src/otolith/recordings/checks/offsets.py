"""Constants that a tilted sensor, or a long slope or bank, adds to the forces of a recorded drive.

The two causes look the same: a driver on a slope of 4 % feels what a sensor tilted by 2.3 deg shows. So a
constant is noted and kept. It is removed only if the user asks, and only if a mounting can cause it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith.core.errors import InputError
from otolith.recordings.checks.kinematics import Kinematics
from otolith.recordings.checks.relations import Relation
from otolith.recordings.columns import STANDARD_GRAVITY

TREATMENTS: Final = ("keep", "remove")
SHOWN: Final = 0.15  # [m/s²] the effect of 0.9 deg of tilt; smaller constants are not noticed
MOUNTING: Final = 0.85  # [m/s²] the effect of 5 deg: no sensor mounted level shows more
STEADY: Final = 0.3  # largest relative variation of a constant along the drive
LONG: Final = 20  # least number of windows that establish a constant
BLOCK: Final = 10  # number of windows averaged to see whether the constant varies


@dataclass(frozen=True, slots=True)
class Offset:
    """The constant part of a force that speed and turning do not explain."""

    key: str  # "ax" or "ay"
    other: str  # the explanation that leaves it over, in words
    value: float  # [m/s²]
    hindrance: str  # why it cannot be removed even on request; empty if it can

    def __str__(self) -> str:
        share = min(abs(self.value) / STANDARD_GRAVITY, 1.0)
        tilt = float(np.degrees(np.arcsin(share)))
        road = f"a slope of {100.0 * np.tan(np.radians(tilt)):.1f} %" if self.key == "ax" else "a bank"
        cause = f"a sensor tilted by {tilt:.1f} deg, or {road}, adds as much"
        fate = (
            f"it stays, for {self.hindrance}" if self.hindrance else "it stays; --offsets remove takes it off"
        )
        what = f"{self.key}: a constant {self.value:+.2f} m/s² that {self.other} does not explain"
        return f"{what} ({cause}); {fate}"


def parse_offsets(text: str) -> str:
    """Return the word of `--offsets`, or refuse an unknown one."""
    if text not in TREATMENTS:
        raise InputError("--offsets", repr(text), " or ".join(TREATMENTS))
    return text


def find_offsets(drive: Kinematics) -> list[Offset]:
    """Return the constants of a_x and a_y that exceed their uncertainty and a level sensor's error."""
    first: dict[str, Relation] = {}
    for one in drive.relations:
        if one.key in ("ax", "ay"):
            first.setdefault(one.key, one)
    return [offset for one in first.values() if (offset := _offset(one)) is not None]


def refuse_removal(offsets: Sequence[Offset], source: str) -> None:
    """Refuse to remove a constant that no mounting of a sensor causes."""
    for offset in offsets:
        if offset.hindrance:
            found = f"{offset.value:+.2f} m/s², which is to be removed"
            bound = f"what a mounted sensor shows, but {offset.hindrance} (--offsets keep leaves it)"
            raise InputError(f"constant of {offset.key} in {source}", found, bound)


def _offset(one: Relation) -> Offset | None:
    if len(one.start) < LONG:
        return None
    slope = one.slope if one.strong and one.correlation > 0.0 else 1.0
    left = one.measured - slope * one.expected
    value, noise = float(np.mean(left)), float(np.std(left)) / np.sqrt(len(left) / 2.0)
    if abs(value) <= max(SHOWN, 3.0 * noise):
        return None
    return Offset(one.key, one.other, value, _hindrance(one, left, value))


def _hindrance(one: Relation, left: Vec, value: float) -> str:
    if abs(value) > MOUNTING:
        return f"a sensor that is mounted level shows at most {MOUNTING:g} m/s² (5 deg)"
    if not one.agrees and one.informative:
        return f"{one.key} goes too little with {one.other} to say (correlation {one.correlation:.2f})"
    whole = len(left) // BLOCK * BLOCK
    blocks = np.mean(left[:whole].reshape(-1, BLOCK), axis=1)
    if float(np.ptp(blocks)) > max(SHOWN, 2.0 * STEADY * abs(value)):
        return f"it varies along the drive by {np.ptp(blocks):.2f} m/s², as a road does and a sensor does not"
    return ""
