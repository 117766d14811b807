"""Functions that kernels call and that are no kernels: those of Python, `math`, NumPy and of lanes."""

import builtins
import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from otolith.core import lanes
from otolith.export.translate.arithmetic import entry_of, parts_of, place
from otolith.export.translate.values import (
    ATOM,
    UNARY,
    Array,
    Elementwise,
    Number,
    Value,
    joined,
    kind_of,
    number,
)

# What C's mathematics offers under another name than here is on the right
_OF_NUMBERS: Final[dict[Any, str]] = {
    math.sqrt: "sqrt",
    math.sin: "sin",
    math.cos: "cos",
    math.exp: "exp",
    math.expm1: "expm1",
    math.asin: "asin",
    math.acos: "acos",
    math.atan2: "atan2",
    math.hypot: "hypot",
    math.copysign: "copysign",
    math.fabs: "fabs",
    np.sqrt: "sqrt",
    np.sin: "sin",
    np.cos: "cos",
    np.exp: "exp",
    np.expm1: "expm1",
    np.hypot: "hypot",
    np.floor: "floor",
    np.ceil: "ceil",
    np.abs: "fabs",
    np.arctan2: "atan2",
    np.tanh: "tanh",
}
_SIMPLE: Final = frozenset({"fabs", "floor", "ceil", "copysign"})  # that need no library of mathematics


class Mathematics:
    """Which functions of C's library have been asked for."""

    def __init__(self) -> None:
        self.used: set[str] = set()

    @property
    def library(self) -> list[str]:
        """Return those that come from the library of mathematics, and not from one instruction."""
        return sorted(self.used - _SIMPLE)

    def call(self, function: Any, arguments: list[Value]) -> Value:
        """Return a call of a function of numbers, or entry by entry of an array."""
        if len(arguments) == 1 and isinstance(arguments[0], (Array, Elementwise)):
            (of,) = arguments
            return Elementwise(of.shape, lambda at: self.call(function, [entry_of(of, at)]), parts_of(of))
        if not any(isinstance(one, Number) for one in arguments):
            return float(function(*arguments))
        name = _OF_NUMBERS[function]
        self.used.add(name)
        return Number(f"{name}({', '.join(number(one).text for one in arguments)})", "double")


def is_of_numbers(function: Any) -> bool:
    """Return whether a function is one of C's mathematics."""
    try:
        return function in _OF_NUMBERS
    except TypeError:  # cannot be hashed
        return False


def extreme(function: Any, arguments: list[Value]) -> Value:
    """Return min or max of numbers as Python orders them: the first of equals, and of a NaN the other."""
    if not any(isinstance(one, Number) for one in arguments):
        return function(*arguments)
    kind = joined({kind_of(one) for one in arguments})
    name = function.__name__ if kind == "double" else f"{function.__name__}_int"
    found, *others = arguments
    natural = all(number(one).natural for one in arguments)
    for one in others:
        text = f"\0h{name}\0{number(found).text}, {number(one).text})"
        found = Number(text, kind, ATOM, natural and kind != "double")
    return found


def size_of(values: Value) -> int:
    """Return len(values)."""
    if isinstance(values, (Array, Elementwise)):
        return values.shape[0]
    return len(values)


def magnitude(a: Value) -> Value:
    """Return abs(a) of a number."""
    if not isinstance(a, Number):
        return abs(a)
    if a.kind == "double":
        return Number(f"fabs({a.text})", "double")
    return Number(f"\0habs_int\0{a.text})", "int", natural=True)


def as_integer(a: Value) -> Value:
    """Return int(a)."""
    if not isinstance(a, Number):
        return int(a)
    if a.kind != "double":
        return Number(a.text, "int", a.level, a.natural)
    return Number(f"(int){a.within(UNARY)}", "int", UNARY)


def rounded(a: Value) -> Value:
    """Return round(a): the nearest integer, of two that are as near the even one."""
    if not isinstance(a, Number):
        return round(a)
    return Number(f"\0hround_int\0{a.text})", "int") if a.kind == "double" else as_integer(a)


def as_float(a: Value) -> Value:
    """Return float(a)."""
    if not isinstance(a, Number):
        return float(a)
    return a if a.kind == "double" else Number(f"(double){a.within(UNARY)}", "double", UNARY)


def as_truth(a: Value) -> Value:
    """Return bool(a)."""
    if not isinstance(a, Number):
        return bool(a)
    return a if a.kind == "bool" else Number(f"{a.within(UNARY)} != 0", "bool", 5)


OF_PYTHON: Final[dict[Any, Callable[..., Value]]] = {
    builtins.len: size_of,
    builtins.abs: magnitude,
    builtins.int: as_integer,
    builtins.round: rounded,
    builtins.float: as_float,
    builtins.bool: as_truth,
}


def _four(W: Array, i: Value) -> str:
    """Return the C text of the address of W[i]."""
    return f"{W.pointer} + {number(place(W, (i,))).within(2)}"


def _load(W: Array, i: Value) -> Number:
    return Number(f"\0hLOAD\0{_four(W, i)})", "lanes")


def _store(W: Array, i: Value, v: Number) -> Number:
    W.storage.write()
    return Number(f"\0hSTORE\0{_four(W, i)}, {v.text})", "bool")


def _unit(lane: int) -> Number:
    return Number("\0hUNIT\0" + ", ".join(str(float(n == lane)) for n in range(lanes.WIDTH)) + ")", "lanes")


def _lane(v: Number, lane: int) -> Number:
    return Number(f"\0hLANE\0{v.text}, {lane})", "double")


def _of_lanes(name: str) -> Callable[..., Number]:
    return lambda *of: Number(f"\0h{name}\0{', '.join(number(one).text for one in of)})", "lanes")


OF_LANES: Final[dict[Any, Callable[..., Number]]] = {
    lanes.load4: _load,
    lanes.store4: _store,
    lanes.unit4: _unit,
    lanes.lane4: _lane,
    lanes.times4: _of_lanes("TIMES"),
    lanes.add4: _of_lanes("ADD"),
    lanes.add_times4: _of_lanes("ADD_TIMES"),
    lanes.less_times4: _of_lanes("LESS_TIMES"),
}
