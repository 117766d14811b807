"""Arithmetic, comparisons and choices, with Python's meaning and as few brackets as C needs."""

import ast
import operator
from collections.abc import Callable
from typing import Any, Final

from otolith.export.translate.values import (
    AND,
    ATOM,
    CHOICE,
    EQUAL,
    NOWHERE,
    OR,
    ORDER,
    PRODUCT,
    SUM,
    UNARY,
    Array,
    Elementwise,
    NotTranslated,
    Number,
    Value,
    joined,
    kind_of,
    number,
    plain,
)

_NOW: Final[dict[type[ast.AST], Callable[..., Any]]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.BitOr: operator.or_,
    ast.BitAnd: operator.and_,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
}
_SYMBOLS: Final[dict[type[ast.AST], tuple[str, int]]] = {
    ast.Add: ("+", SUM),
    ast.Sub: ("-", SUM),
    ast.Mult: ("*", PRODUCT),
    ast.Div: ("/", PRODUCT),
    ast.FloorDiv: ("/", PRODUCT),
    ast.Mod: ("%", PRODUCT),
    ast.Eq: ("==", EQUAL),
    ast.NotEq: ("!=", EQUAL),
    ast.Lt: ("<", ORDER),
    ast.LtE: ("<=", ORDER),
    ast.Gt: (">", ORDER),
    ast.GtE: (">=", ORDER),
}
_FREE: Final = {"Add": 0, "Sub": 0, "Mult": 1}  # operands on the right that change no integer
_POWERS: Final = {
    2: "{x} * {x}",
    3: "{x} * ({x} * {x})",
    4: "({x} * {x}) * ({x} * {x})",
}  # as numba multiplies


def binary(op: ast.operator, a: Value, b: Value) -> Value:
    """Return a op b of numbers or, entry by entry, of arrays."""
    if isinstance(a, (Array, Elementwise)) or isinstance(b, (Array, Elementwise)):
        return _elementwise(op, a, b)
    if not isinstance(a, Number) and not isinstance(b, Number):
        return _folded(op, a, b)
    if isinstance(op, ast.Pow):
        return _power(number(a), b)
    return _in_c(op, number(a), number(b), a, b)


def _folded(op: ast.operator, a: Value, b: Value) -> Value:
    """Return the result of numbers that are known."""
    if isinstance(op, ast.Div) and b == 0:
        return _in_c(op, number(float(a)), number(float(b)), None, None)  # infinite or NaN, as in kernels
    return plain(_NOW[type(op)](a, b))


def _in_c(op: ast.operator, left: Number, right: Number, a: Value, b: Value) -> Number:
    """Return an operation as text; a and b are the operands as they were, known or not."""
    integer = left.kind != "double" and right.kind != "double"
    if integer and not isinstance(op, ast.Div):
        simple = _without(op, left, right, a, b)
        if simple is not None:
            return simple
    if isinstance(op, (ast.FloorDiv, ast.Mod)) and not (integer and left.natural and right.natural):
        if not integer:
            raise NotTranslated("a division without remainder of numbers that are no integers")
        name = "floor_div" if isinstance(op, ast.FloorDiv) else "floor_mod"
        return Number(f"\0h{name}\0{left.text}, {right.text})", "int")
    if isinstance(op, (ast.BitOr, ast.BitAnd)) and integer:
        symbol = "|" if isinstance(op, ast.BitOr) else "&"
        return Number(f"{left.within(ATOM)} {symbol} {right.within(ATOM)}", "int", OR)
    if type(op) not in _SYMBOLS:
        raise NotTranslated(f"the operator {type(op).__name__} is not translated")
    symbol, level = _SYMBOLS[type(op)]
    if integer and isinstance(op, ast.Div):
        left = Number(f"(double){left.within(UNARY)}", "double", UNARY)
        integer = False
    natural = left.natural and right.natural and not isinstance(op, ast.Sub)
    text = f"{left.within(level)} {symbol} {right.within(level - 1)}"
    return Number(text, "int" if integer else "double", level, natural=integer and natural)


def _without(op: ast.operator, left: Number, right: Number, a: Value, b: Value) -> Number | None:
    """Return the other operand where an integer is added to zero or multiplied by one."""
    if not isinstance(b, Number) and b == _FREE.get(type(op).__name__):
        return left
    if not isinstance(a, Number) and not isinstance(op, ast.Sub) and a == _FREE.get(type(op).__name__):
        return right
    gone = any(not isinstance(one, Number) and one == 0 for one in (a, b))
    return number(0) if isinstance(op, ast.Mult) and gone else None


def _power(base: Number, exponent: Value) -> Number:
    """Return a small whole power as a product; other powers are refused."""
    if isinstance(exponent, Number) or exponent not in _POWERS or base.level != ATOM:
        raise NotTranslated(f"({base.text}) to the power {exponent}: only small powers of a variable are")
    return Number(_POWERS[exponent].format(x=base.text), base.kind, PRODUCT, base.natural)


def _elementwise(op: ast.operator, a: Value, b: Value) -> Elementwise:
    """Return an operation entry by entry; one operand may be a number."""
    shapes = {one.shape for one in (a, b) if isinstance(one, (Array, Elementwise))}
    if len(shapes) != 1:
        raise NotTranslated(f"arrays of shapes {sorted(shapes)} are combined")

    def entry(index: tuple[Any, ...]) -> Value:
        return binary(op, entry_of(a, index), entry_of(b, index))

    return Elementwise(shapes.pop(), entry, parts_of(a) + parts_of(b))


def parts_of(value: Value) -> tuple[Array, ...]:
    """Return the arrays from which a value is computed."""
    if isinstance(value, Array):
        return (value,)
    return value.parts if isinstance(value, Elementwise) else ()


def entry_of(value: Value, index: tuple[Any, ...]) -> Value:
    """Return an entry of an array, or a number itself."""
    if isinstance(value, Elementwise):
        return value.entry(index)
    return element(value, index) if isinstance(value, Array) else value


def place(array: Array, index: tuple[Any, ...]) -> int | Number:
    """Return where an entry lies in the storage of an array."""
    at: Value = array.offset
    for i, (one, stride) in enumerate(zip(index, array.strides, strict=True)):
        if isinstance(one, int):
            if not -array.shape[i] <= one < array.shape[i]:
                raise NotTranslated(f"index {one} is outside an array of {array.shape[i]}")
            one %= array.shape[i]  # counted from the end where negative
        at = binary(ast.Add(), at, binary(ast.Mult(), one, stride))
    found: int | Number = at
    return found


def element(array: Array, index: tuple[Any, ...]) -> Number:
    """Return an entry of an array as C text."""
    if array.pointer == NOWHERE:  # an array without entries, in a loop that has no rounds
        return Number("0", array.kind)
    return Number(f"{array.pointer}[{number(place(array, index)).text}]", array.kind)


def unary(op: ast.unaryop, a: Value) -> Value:
    """Return −a, +a or not a."""
    if isinstance(op, ast.Not):
        return negated(a)
    if isinstance(a, (Array, Elementwise)):
        return Elementwise(a.shape, lambda index: unary(op, entry_of(a, index)), parts_of(a))
    if not isinstance(a, Number):
        return -a if isinstance(op, ast.USub) else a
    if isinstance(op, ast.UAdd):
        return a
    inner = a.within(ATOM) if a.text.startswith("-") else a.within(UNARY)
    return Number(f"-{inner}", "int" if a.kind == "bool" else a.kind, UNARY)


def negated(a: Value) -> Value:
    """Return whether a is zero or false."""
    return Number(f"!{a.within(ATOM)}", "bool", UNARY) if isinstance(a, Number) else not a


def compare(op: ast.cmpop, a: Value, b: Value) -> Value:
    """Return one comparison."""
    if isinstance(op, (ast.In, ast.NotIn)):
        found: Value = False
        for one in b:
            found = either(found, compare(ast.Eq(), a, one))
        return found if isinstance(op, ast.In) else negated(found)
    if not isinstance(a, Number) and not isinstance(b, Number):
        return bool(plain(_NOW[type(op)](a, b)))
    left, right = number(a), number(b)
    symbol, level = _SYMBOLS[type(op)]
    return Number(f"{left.within(SUM)} {symbol} {right.within(SUM)}", "bool", level)


def both(a: Value, b: Value) -> Value:
    """Return whether a and b hold; b is computed only if a does."""
    if not isinstance(a, Number):
        return b if a else False
    if not isinstance(b, Number):
        return a if b else False
    return Number(f"{a.within(AND)} && {b.within(EQUAL)}", "bool", AND)


def either(a: Value, b: Value) -> Value:
    """Return whether a or b holds; b is computed only if a does not."""
    if not isinstance(a, Number):
        return True if a else b
    if not isinstance(b, Number):
        return True if b else a
    left = a.text if a.level == OR else a.within(EQUAL)
    return Number(f"{left} || {b.within(EQUAL)}", "bool", OR)


def chosen(test: Value, a: Value, b: Value) -> Value:
    """Return a if the test holds, otherwise b."""
    if not isinstance(test, Number):
        return a if test else b
    if isinstance(a, tuple) and isinstance(b, tuple):
        return tuple(chosen(test, one, other) for one, other in zip(a, b, strict=True))
    kind = joined({kind_of(a), kind_of(b)})
    left, right = number(a), number(b)
    if left.text == right.text:
        return a
    text = f"{test.within(OR)} ? {left.within(OR)} : {right.within(CHOICE)}"
    return Number(text, kind, CHOICE, left.natural and right.natural and kind != "double")
