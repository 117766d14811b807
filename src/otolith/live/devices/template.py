"""Devices that read what a user's template says: SimTools, FlyPT Mover, SimHub, Thanos, motion4sim and
their like.

A template is a text such as `<255><255><Axis1a><Axis2a><10><13>`. `<AxisNa>` stands for the code of axis N,
`<n>` for the byte n, and anything else for itself. Each axis is a degree of freedom or a leg whose range is
scaled to the whole numbers of n bits, sent as bytes or as text.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, Literal

from otolith.core.arrays import Vec
from otolith.core.errors import InputError, one_of
from otolith.core.frames import AXES
from otolith.live.devices.driver import Request
from otolith.live.devices.reach import ROUNDING, Sent, check_span
from otolith.live.messages import Feedback, SetPoint
from otolith.live.wire.formats import WireError

FORMS: Final = ("big", "little", "decimal", "hex")
MOST_BITS: Final = 32
_TOKEN: Final = re.compile(r"<Axis(\d+)a>|<(\d{1,3})>|(.)", re.DOTALL)
_ACTUATOR: Final = re.compile(r"(leg|crank)\d+")
_REMEDY: Final = "narrow the limits of the session, or state the device's whole range"


@dataclass(frozen=True, slots=True, kw_only=True)
class Axis:
    """What one axis of a device follows, and the range that its codes span."""

    # surge, sway, heave, roll, pitch or yaw, relative to neutral; leg1 … as length, or crank1 … as angle
    follows: str
    low: float  # [m or rad] at code 0
    high: float  # [m or rad] at the largest code; may be below `low` where the axis is mirrored

    def __post_init__(self) -> None:
        if self.follows not in AXES and not _ACTUATOR.fullmatch(self.follows):
            raise InputError(
                "axis of the template", repr(self.follows), one_of([*AXES, "leg1", "crank1"], self.follows)
            )
        if not abs(self.low) < float("inf") or not abs(self.high) < float("inf") or self.low == self.high:
            raise InputError(
                f"range of {self.follows}", f"{self.low:g} to {self.high:g}", "two different numbers"
            )

    @property
    def unit(self) -> str:
        """Return the unit of the range: rad for an angle, m for all else."""
        return "rad" if self.follows in AXES[3:] or self.follows.startswith("crank") else "m"

    def code(self, value: float, bits: int) -> int:
        """Return the code of a value.

        Raises
        ------
        InputError : the value is outside the range. It is never clamped: what clamps hides where it stands.
        """
        share = (value - self.low) / (self.high - self.low)
        if not -ROUNDING <= share <= 1.0 + ROUNDING:
            low, high = sorted((self.low, self.high))
            bound = f"within {low:g} to {high:g} {self.unit}"
            raise InputError(f"{self.follows} for the template", f"{value:.6g} {self.unit}", bound)
        most = (1 << bits) - 1
        return min(most, max(0, round(share * most)))

    def value(self, code: int, bits: int) -> float:
        """Return the value [m or rad] of a code: the inverse of `code`."""
        return self.low + (self.high - self.low) * code / ((1 << bits) - 1)


@dataclass(frozen=True, kw_only=True)
class Template:
    """A device that a template describes.

    Parameters
    ----------
    name : of the device, for messages.
    frame : the template of one set-point.
    axes : what `<Axis1a>`, `<Axis2a>` … follow, in this order.
    bits : of each code, 1 to 32.
    form : how a code is written: "big" or "little" endian bytes, "decimal" text, or "hex" of fixed width.
    start, stop : templates without axes that are sent at *start* and *engage*, and at *park* and *disable*.
    on_silence : what the device does when packets stop; whoever describes the device has to say.
    legs : returns the leg lengths [m], or the crank angles [rad], of a pose (6,); for axes that follow one.
    cranks : whether they are crank angles.
    """

    name: str
    frame: str
    axes: tuple[Axis, ...]
    bits: int
    on_silence: Literal["holds", "parks", "falls"]
    form: str = "big"
    start: str = ""
    stop: str = ""
    rate_hz: float = 100.0
    reports: bool = False  # a template describes no replies
    legs: Callable[[Vec], Vec] | None = None
    cranks: bool = False
    parts: tuple[bytes | int, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if self.form not in FORMS:
            raise InputError(f"form of {self.name}", repr(self.form), one_of(FORMS, self.form))
        if not 1 <= self.bits <= MOST_BITS:
            raise InputError(f"bits of {self.name}", self.bits, f"1 to {MOST_BITS}")
        parts = parsed(self.frame, f"frame of {self.name}")
        named = [part for part in parts if isinstance(part, int)]
        if sorted(named) != list(range(1, len(self.axes) + 1)):
            found = ", ".join(f"<Axis{number}a>" for number in named) or "without axes"
            bound = f"each of <Axis1a> to <Axis{len(self.axes)}a> once"
            raise InputError(f"frame of {self.name}", found, bound)
        for text, what in ((self.start, "start"), (self.stop, "stop")):
            if any(isinstance(part, int) for part in parsed(text, f"{what} of {self.name}")):
                raise InputError(f"{what} of {self.name}", repr(text), "without axes")
        needs_legs = [axis.follows for axis in self.axes if axis.follows not in AXES]
        if needs_legs and self.legs is None:
            kind = "cranks" if needs_legs[0].startswith("crank") else "legs"
            raise InputError(f"axis of {self.name}", needs_legs[0], f"on a platform with {kind}")
        kind = "crank" if self.cranks else "leg"
        for name in needs_legs:
            if not name.startswith(kind):
                raise InputError(f"axis of {self.name}", name, f"one of {kind}1 to {kind}6")
        object.__setattr__(self, "parts", parts)

    def check_reach(self, sent: Sent) -> None:
        """Refuse a device of which an axis spans less than is sent; see `driver.Driver`."""
        for number, axis in enumerate(self.axes, start=1):
            needs = sent.stroke
            if axis.follows in AXES:
                place = AXES.index(axis.follows)
                needs = float(sent.low[place]), float(sent.high[place])
            what = f"range of <Axis{number}a> of {self.name}, which follows {axis.follows},"
            check_span(what, (axis.low, axis.high), needs, axis.unit, _REMEDY)

    def encode(self, set_point: SetPoint, request: Request) -> bytes:
        """Return the packet for a set-point; see `driver.Driver`."""
        match request:
            case Request.MOVE:
                return self.packed(self.codes(set_point.pose))
            case Request.START | Request.ENGAGE:
                return _literal(self.start)
            case Request.PARK | Request.DISABLE:
                return _literal(self.stop)
            case Request.HOLD | Request.RESET:
                return (
                    b""  # such a device follows every frame and knows no faults: silence is all that holds it
                )

    def decode(self, packet: bytes) -> Feedback:
        """Refuse: these devices report nothing, so nothing they send is expected."""
        raise WireError(
            f"reply of {self.name}", f"{len(packet)} bytes", "absent: a template describes no replies"
        )

    def codes(self, pose: Vec) -> tuple[int, ...]:
        """Return the codes of all axes at a pose (6,)."""
        lengths = self.legs(pose) if self.legs is not None else ()
        values = dict(zip(AXES, pose, strict=True))
        kind = "crank" if self.cranks else "leg"
        values |= {f"{kind}{number}": length for number, length in enumerate(lengths, start=1)}
        for axis in self.axes:
            if axis.follows not in values:
                raise InputError(
                    f"axis of {self.name}", axis.follows, f"one of {kind}1 to {kind}{len(lengths)}"
                )
        return tuple(axis.code(float(values[axis.follows]), self.bits) for axis in self.axes)

    def packed(self, codes: tuple[int, ...]) -> bytes:
        """Return the frame with these codes, in the order of the axes."""
        return b"".join(
            part if isinstance(part, bytes) else self._code(codes[part - 1]) for part in self.parts
        )

    def _code(self, code: int) -> bytes:
        match self.form:
            case "decimal":
                return b"%d" % code
            case "hex":
                return b"%0*X" % (-(-self.bits // 4), code)
            case _:
                return code.to_bytes(-(-self.bits // 8), "big" if self.form == "big" else "little")

    def read(self, packet: bytes) -> tuple[int, ...]:
        """Return the codes in a frame of this template: the inverse of `packed`, for tests and emulators.

        Raises
        ------
        WireError : the bytes do not fit the template.
        """
        match = re.fullmatch(self._pattern(), packet, re.DOTALL)
        if match is None:
            raise WireError(
                f"packet of {self.name}", f"{len(packet)} bytes {packet[:8].hex(' ')}", "as its template"
            )
        order = [part for part in self.parts if isinstance(part, int)]
        found = {number: self._number(text) for number, text in zip(order, match.groups(), strict=True)}
        return tuple(found[number] for number in sorted(found))

    def _pattern(self) -> bytes:
        one = {"decimal": b"([0-9]+)", "hex": b"([0-9A-F]{%d})" % -(-self.bits // 4)}
        code = one.get(self.form, b"(.{%d})" % -(-self.bits // 8))
        return b"".join(re.escape(part) if isinstance(part, bytes) else code for part in self.parts)

    def _number(self, text: bytes) -> int:
        if self.form in ("decimal", "hex"):
            return int(text, 10 if self.form == "decimal" else 16)
        return int.from_bytes(text, "big" if self.form == "big" else "little")


def parsed(text: str, where: str) -> tuple[bytes | int, ...]:
    """Return the parts of a template: bytes that are sent as they are, and numbers of axes.

    Raises
    ------
    InputError : a byte is above 255, or a character is not in ASCII.
    """
    parts: list[bytes | int] = []
    for token in _TOKEN.finditer(text):
        axis, byte, plain = token.groups()
        if axis:
            parts.append(int(axis))
            continue
        if byte and int(byte) > 255:
            raise InputError(where, token[0], "a byte, <0> to <255>")
        if plain and not plain.isascii():
            raise InputError(where, repr(plain), "written in ASCII")
        parts.append(bytes([int(byte)]) if byte else plain.encode("ascii"))
    return tuple(parts)


def _literal(text: str) -> bytes:
    return b"".join(part for part in parsed(text, "template") if isinstance(part, bytes))


LEGS: Final = tuple(f"leg{number}" for number in range(1, 7))


def thanos(stroke: tuple[float, float], legs: Callable[[Vec], Vec]) -> Template:
    """Return the driver of a Thanos AMC-AASD15A: 20 bytes, six legs of 16 bits.

    Parameters
    ----------
    stroke : [m] shortest and longest leg.
    legs : returns the leg lengths of a pose.

    The bytes of a code are taken to be big endian; no public document states it. The device parks when
    packets stop.
    """
    return Template(
        name="thanos",
        frame="<255><255>" + "".join(f"<Axis{n}a>" for n in range(1, 7)) + "<0><0><0><0><10><13>",
        axes=tuple(Axis(follows=leg, low=stroke[0], high=stroke[1]) for leg in LEGS),
        bits=16,
        on_silence="parks",
        legs=legs,
    )


def motion4sim(axes: tuple[Axis, ...]) -> Template:
    """Return the driver of a motion4sim controller: 28 bytes, always eight axes of 24 bits.

    An axis that is not built is mapped like one that is. What the device does when packets stop is not
    public: it is taken to hold.
    """
    if len(axes) != 8:
        raise InputError("axes of motion4sim", len(axes), "8, as its packet always holds all")
    frame = "<255><255>" + "".join(f"<Axis{n}a>" for n in range(1, 9)) + "<10><13>"
    return Template(name="motion4sim", frame=frame, axes=axes, bits=24, on_silence="holds")
