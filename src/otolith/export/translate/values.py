"""What an expression of a kernel can be while it is translated.

A value that is known now is itself: a number, a tuple, a named tuple of arrays, a function. All others are
pieces of C text: a `Number`, an `Array`, or an `Elementwise` that is computed entry by entry.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from decimal import Decimal
from itertools import count
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from otolith.core.errors import OtolithError

Kind = Literal["double", "int", "bool", "lanes"]
C_TYPES: Final = {"double": "double", "int": "int", "bool": "int"}

NOWHERE: Final = "0"  # the pointer of an array without entries

# How tightly operators of C bind, from what needs no brackets to what always does
ATOM, UNARY, PRODUCT, SUM, ORDER, EQUAL, AND, OR, CHOICE = range(9)


class NotTranslated(OtolithError):
    """A kernel contains what cannot be said in C here; the message names the function and the line."""


class SizeUnknown(NotTranslated):
    """The size of an array, or the method that is called, depends on a number that is not known."""


@dataclass(frozen=True, slots=True)
class Number:
    """A number that is known only when the C code runs."""

    text: str
    kind: Kind
    level: int = ATOM  # how tightly its outermost operator binds
    natural: bool = False  # an integer that cannot be negative

    def within(self, level: int) -> str:
        """Return the text as an operand of an operator that binds as tightly as `level`."""
        return self.text if self.level <= level else f"({self.text})"


_serial = count()


@dataclass(eq=False)
class Storage:
    """Memory that arrays lie in: an array of the data, a parameter, a local array or a pointer to others."""

    kind: Kind
    written: bool = False  # whether some kernel writes it
    assumed: bool = False  # whether a number of it was taken for a constant
    sources: list["Storage"] = field(default_factory=list)  # what a parameter or a pointer points into
    serial: int = field(default_factory=lambda: next(_serial))

    def write(self) -> None:
        """Note that it is written, and so is all that it points into."""
        if not self.written:
            self.written = True
            for source in self.sources:
                source.write()

    def point_into(self, source: "Storage") -> None:
        """Note that it points into another storage."""
        if source is not self and source not in self.sources:
            self.sources.append(source)
            if self.written:
                source.write()


@dataclass(frozen=True, slots=True)
class Array:
    """A view of storage; sizes are known, where it begins perhaps not."""

    pointer: str  # C text of the first entry of the storage
    storage: Storage
    offset: int | Number
    shape: tuple[int, ...]
    strides: tuple[int, ...]  # in entries
    numbers: NDArray[Any] | None = None  # the entries now, where it is known which they are

    @property
    def kind(self) -> Kind:
        """Return the kind of its entries."""
        return self.storage.kind

    @property
    def key(self) -> Any:
        """Return what tells its layout apart, wherever it lies."""
        return ("array", self.kind, self.shape, self.strides)

    @property
    def size(self) -> int:
        """Return the number of entries."""
        return math.prod(self.shape)

    @property
    def stable(self) -> bool:
        """Return whether it stays the same view while variables change."""
        return isinstance(self.offset, int)


@dataclass(frozen=True, slots=True)
class Elementwise:
    """An array that is computed entry by entry when it is stored."""

    shape: tuple[int, ...]
    entry: Callable[[tuple[Any, ...]], Any]  # the entry at an index, as a number
    parts: tuple[Array, ...]  # the arrays from which it is computed


@dataclass(frozen=True, slots=True)
class Choice:
    """One of two arrays that look alike, as C text of a pointer."""

    text: str
    a: Array
    b: Array


@dataclass(frozen=True, slots=True)
class Nothing:
    """A call that returns nothing."""

    text: str


@dataclass(frozen=True, slots=True)
class Several:
    """A call that returns several numbers."""

    text: str
    kinds: tuple[Kind, ...]


Value = Any  # Number, Array, Elementwise, or what is known now


def known(value: Value) -> bool:
    """Return whether a value is known now, in all its parts."""
    if isinstance(value, (Number, Array, Elementwise)):
        return False
    return all(map(known, value)) if isinstance(value, tuple) else True


def parts(value: Value, name: str = "") -> Iterator[tuple[str, Number | Array]]:
    """Yield what is not known in an argument: itself or, of a tuple, its parts; each with a name."""
    if isinstance(value, (Number, Array)):
        yield name, value
    elif isinstance(value, tuple):
        for part, one in zip(getattr(value, "_fields", range(len(value))), value, strict=True):
            yield from parts(one, f"{name}_{part}")


def plain(value: Value) -> Value:
    """Return a number of NumPy's as one of Python's."""
    return value.item() if isinstance(value, np.generic) else value


def kind_of(value: Value) -> Kind:
    """Return the kind of a number.

    Raises
    ------
    NotTranslated : it is not a number.
    """
    if isinstance(value, Number):
        return value.kind
    for kind, python in (("bool", bool), ("int", int), ("double", float)):
        if isinstance(value, python):
            return kind  # type: ignore[return-value]
    raise NotTranslated(f"{type(value).__name__} {value!r} is used as a number")


def literal(value: float) -> str:
    """Return the C text of a number that is known."""
    if isinstance(value, (bool, int)):
        return str(int(value))
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0.0 else "-INFINITY"
    short = format(Decimal(repr(value)).normalize(), "E").lower().replace("e+", "e")
    return min(repr(value), short if "e" in short else f"{short}.0", key=len)


def number(value: Value) -> Number:
    """Return any number as C text."""
    if isinstance(value, Number):
        return value
    kind = kind_of(value)
    level = UNARY if value < 0 else ATOM
    return Number(literal(value), kind, level, natural=kind != "double" and value >= 0)


def joined(kinds: set[Kind]) -> Kind:
    """Return the kind of a variable that receives numbers of several kinds."""
    if "lanes" in kinds and len(kinds) > 1:
        raise NotTranslated("a variable is a register and a number")
    for kind in ("lanes", "double", "int"):
        if kind in kinds:
            return kind
    return "bool"
