"""The axis map: what turns a source's sample into what should be felt, and its text in a session file.

A map says by numbers what was found by experiment (`learned`): which channel is which axis, with which sign
and unit, whether gravity is in the force, and whether vectors are in world or car axes. Its text carries a
SHA-256, so that a map that was edited by hand is not taken for one that was measured.
"""

import functools
import hashlib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Final

import numpy as np

from otolith.core.arrays import Mat, Vec, frozen_array
from otolith.core.errors import InputError, one_of
from otolith.core.toml import toml_value
from otolith.interfaces import Reference
from otolith.live.messages import Telemetry
from otolith.live.wire.attitude import matrix
from otolith.live.wire.formats import WireError
from otolith.recordings.units import STANDARD_GRAVITY

FORCE_UNITS: Final = {"m/s²": 1.0, "g": STANDARD_GRAVITY}
RATE_UNITS: Final = {"rad/s": 1.0, "deg/s": float(np.pi / 180.0)}
FRAMES: Final = ("car", "world")
SECTION: Final = "axes"
# channel with sign -> row of a signed permutation: "-2" is the second channel with its sign turned
_CHANNELS: Final = ("1", "-1", "2", "-2", "3", "-3")

Rows = tuple[str, str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class AxisMap:
    """How a source's vectors become x forward, y left, z up in SI units.

    A row such as ("2", "-1", "3") says: forward is channel 2, left is channel 1 with its sign turned, up is
    channel 3.
    """

    source: str  # name of the source that it was learned from
    force: Rows
    force_unit: str = "m/s²"
    gravity: bool = False  # whether a level rest shows +1 g along z, which is subtracted
    frame: str = "car"  # in which axes the source states forces
    rate: Rows = ("1", "2", "3")  # roll, pitch, yaw
    rate_unit: str = "rad/s"
    evidence: Mapping[str, float] = field(default_factory=dict)  # test -> its correlation

    def __post_init__(self) -> None:
        for name, value, known in (
            ("force_unit", self.force_unit, FORCE_UNITS),
            ("rate_unit", self.rate_unit, RATE_UNITS),
            ("frame", self.frame, FRAMES),
        ):
            if value not in known:
                raise InputError(f"{name} of the axis map", repr(value), one_of(known, value))
        for name in ("force", "rate"):
            rows = getattr(self, name)
            if sorted(row.lstrip("-") for row in rows) != ["1", "2", "3"] or not set(rows) <= set(_CHANNELS):
                raise InputError(
                    f"{name} of the axis map", list(rows), "each of the channels 1, 2, 3 once, with a sign"
                )

    @property
    def digest(self) -> str:
        """Return the SHA-256 of what the map says, evidence included."""
        said = json.dumps(asdict(self), sort_keys=True, ensure_ascii=True)
        return hashlib.sha256(said.encode()).hexdigest()

    def wanted(self, telemetry: Telemetry) -> Vec:
        """Return what should be felt (6,): specific force without the standing 1 g [m/s²], and rates [rad/s].

        Rates are zero where the source sends none.

        Raises
        ------
        WireError : the sample lacks a force, or an attitude where forces are in world axes.
        """
        if telemetry.acceleration is None:
            raise WireError(f"sample of {self.source}", "without a force", "with one, to be cued")
        stated = telemetry.acceleration
        if self.frame == "world":
            if telemetry.attitude is None:
                raise WireError(
                    f"sample of {self.source}", "without attitude", "with one: its forces are in world axes"
                )
            stated = matrix(telemetry.attitude).T @ stated
        wanted = np.zeros(6)
        wanted[:3] = FORCE_UNITS[self.force_unit] * (rows_matrix(self.force) @ stated)
        wanted[2] -= STANDARD_GRAVITY if self.gravity else 0.0
        if telemetry.angular_rate is not None:
            wanted[3:] = RATE_UNITS[self.rate_unit] * (rows_matrix(self.rate) @ telemetry.angular_rate)
        return wanted

    def reference(self, telemetry: Telemetry) -> Reference:
        """Return `wanted` as the cueing algorithms take it."""
        wanted = self.wanted(telemetry)
        return Reference(specific_force=wanted[:3], angular_rate=wanted[3:])

    def to_record(self) -> dict[str, Any]:
        """Return the map as plain values, with its hash."""
        return {**asdict(self), "sha256": self.digest}

    def to_toml(self) -> str:
        """Return the section of a session file."""
        lines = [f"[{SECTION}]"]
        for name, value in asdict(self).items():
            if name != "evidence":
                lines.append(f"{name} = {toml_value(value)}")
        inside = ", ".join(f"{toml_value(name)} = {value!r}" for name, value in self.evidence.items())
        return "\n".join([*lines, f"evidence = {{ {inside} }}", f'sha256 = "{self.digest}"']) + "\n"


def with_axes(text: str, source: str, axes: AxisMap) -> str:
    """Return the text of a session file with an axis map in place of its own, and all else as it was.

    Raises
    ------
    InputError : the text is not TOML, or its axis map is no section of its own.
    """
    kept, inside = [], False
    for line in text.splitlines():
        if line.lstrip().startswith("["):
            inside = line.split("#")[0].strip() == f"[{SECTION}]"
        if not inside:
            kept.append(line)
    made = "\n".join([*kept, ""] if kept and kept[-1].strip() else kept)
    made = f"{made}\n{axes.to_toml()}" if kept else axes.to_toml()
    before, after = _fields(text, source), _fields(made, source)
    before.pop(SECTION, None)
    after.pop(SECTION, None)
    if before != after:
        raise InputError(f"[{SECTION}] in {source}", "not a section of its own", "one, to be replaced")
    return made


def _fields(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"session {source}", f"not TOML ({error})", "a session file") from None


@functools.cache
def rows_matrix(rows: Rows) -> Mat:
    """Return the signed permutation (3, 3) of three rows, read-only."""
    M = np.zeros((3, 3))
    for row, channel in enumerate(rows):
        M[row, int(channel.lstrip("-")) - 1] = -1.0 if channel.startswith("-") else 1.0
    return frozen_array(M)


def axes_from_toml(text: str, source: str) -> AxisMap:
    """Read the axis map of a session file.

    Raises
    ------
    InputError : the text is not TOML, the section or a field is missing or wrong, or the hash does not fit.
    """
    section = _fields(text, source).get(SECTION)
    if not isinstance(section, dict):
        raise InputError(f"[{SECTION}] of {source}", "missing", "as 'otolith live learn' writes it")
    return axes_from(section, source)


def axes_from(fields: Mapping[str, Any], source: str) -> AxisMap:
    """Return the axis map of its fields, hash included; see `axes_from_toml`."""
    section = dict(fields)
    stated = section.pop("sha256", None)
    found = _axis_map(section, source)
    if stated != found.digest:
        bound = (
            f"{found.digest[:12]}…, the SHA-256 of what it says: learn the axes again instead of editing them"
        )
        raise InputError(f"sha256 of [{SECTION}] in {source}", f"{str(stated)[:12]}…", bound)
    return found


def _axis_map(section: Mapping[str, Any], source: str) -> AxisMap:
    kinds: dict[str, type] = dict.fromkeys(("source", "force_unit", "frame", "rate_unit"), str)
    kinds |= {"force": list, "rate": list, "gravity": bool, "evidence": dict}
    for name, value in section.items():
        if name not in kinds:
            raise InputError(f"field of [{SECTION}] in {source}", repr(name), one_of(kinds, name))
        if not isinstance(value, kinds[name]):
            raise InputError(
                f"{name} of [{SECTION}] in {source}", repr(value), f"of kind {kinds[name].__name__}"
            )
    missing = sorted(kinds.keys() - section.keys())
    if missing:
        raise InputError(
            f"[{SECTION}] of {source}", f"without {missing[0]}", "as 'otolith live learn' writes it"
        )
    rows = {name: tuple(map(str, section[name])) for name in ("force", "rate")}
    return AxisMap(**{**section, **rows})
