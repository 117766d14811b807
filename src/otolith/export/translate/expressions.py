"""Expressions of a kernel, from the syntax tree of its source to values."""

import ast
import builtins
import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

from otolith.core import methods
from otolith.export.translate import arithmetic
from otolith.export.translate.builtins import OF_LANES, OF_PYTHON, extreme, is_of_numbers
from otolith.export.translate.function import Function
from otolith.export.translate.scope import Scope, array_of, c_name
from otolith.export.translate.values import (
    NOWHERE,
    Array,
    Choice,
    Elementwise,
    Nothing,
    NotTranslated,
    Number,
    Several,
    SizeUnknown,
    Value,
    kind_of,
    known,
    number,
    parts,
    plain,
)

_MISSING: Final = object()
MAKERS: Final = (np.zeros, np.empty, np.zeros_like)


class Expressions:
    """Translates expressions in the environment of one function.

    Parameters
    ----------
    unit : `otolith.export.translate.unit.Unit`, which holds the data and translates what is called.
    outer : what the function's names mean outside it.
    """

    def __init__(self, unit: Any, scope: Scope, outer: dict[str, Any]) -> None:
        self.unit, self.scope, self.outer = unit, scope, outer
        self.here: dict[str, Value] = {}  # what names stand for; variables are not among them
        self.temporaries = 0

    def value(self, node: ast.expr) -> Value:
        """Return the value of an expression."""
        of = getattr(self, f"_{type(node).__name__.lower()}", None)
        if of is None:
            raise NotTranslated(f"{type(node).__name__} is not translated")
        return of(node)

    def _constant(self, node: ast.Constant) -> Value:
        return node.value

    def _tuple(self, node: ast.Tuple) -> Value:
        found: list[Value] = []
        for one in node.elts:
            if isinstance(one, ast.Starred):
                found.extend(self.value(one.value))
            else:
                found.append(self.value(one))
        return tuple(found)

    def _name(self, node: ast.Name) -> Value:
        name = node.id
        if name in self.here:
            value = self.here[name]
            if isinstance(value, (Array, Number)) and (
                name in self.scope.parameters or name in self.scope.found
            ):
                self.scope.load(name)
            return value
        if name in self.scope.found or name in self.scope.before:
            self.scope.load(name)
            return Number(c_name(name), self.scope.kind(name))
        found = self.outer.get(name, getattr(builtins, name, _MISSING))
        if found is _MISSING:
            raise NotTranslated(f"{name} has no value")
        return plain(found)

    def _attribute(self, node: ast.Attribute) -> Value:
        of = self.value(node.value)
        if isinstance(of, (Array, Elementwise)):
            if node.attr == "shape":
                return of.shape
            if node.attr == "T" and isinstance(of, Array):
                return Array(of.pointer, of.storage, of.offset, of.shape[::-1], of.strides[::-1])
            if node.attr == "copy":
                return lambda: Elementwise(
                    of.shape, lambda at: arithmetic.entry_of(of, at), arithmetic.parts_of(of)
                )
            if node.attr == "size":
                return math.prod(of.shape)
            if node.attr == "reshape" and isinstance(of, Array):
                return lambda *shape: _reshaped(of, shape)
            raise NotTranslated(f"the attribute {node.attr} of an array is not translated")
        return self.unit.wrapped(getattr(of, node.attr))

    def _binop(self, node: ast.BinOp) -> Value:
        left, right = self.value(node.left), self.value(node.right)
        if isinstance(node.op, ast.Pow) and isinstance(left, Number):
            left = self.kept(left)
        return arithmetic.binary(node.op, left, right)

    def kept(self, value: Number) -> Number:
        """Return a number that is computed now, and before what follows."""
        name = self.temporary()
        self.scope.assign(name, value)
        self.scope.load(name)
        return Number(c_name(name), self.scope.kind(name))

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        return arithmetic.unary(node.op, self.value(node.operand))

    def _boolop(self, node: ast.BoolOp) -> Value:
        join = arithmetic.both if isinstance(node.op, ast.And) else arithmetic.either
        first, *others = node.values
        found = self.value(first)
        for one in others:
            if not isinstance(found, Number) and bool(found) is isinstance(node.op, ast.Or):
                return found
            found = join(found, self.perhaps(one) if isinstance(found, Number) else self.value(one))
        return found

    def perhaps(self, node: ast.expr) -> Value:
        """Return the value of an expression that is perhaps not computed."""
        self.scope.lazy += 1
        try:
            return self.value(node)
        finally:
            self.scope.lazy -= 1

    def _compare(self, node: ast.Compare) -> Value:
        left, found = self.value(node.left), True
        for op, right_node in zip(node.ops, node.comparators, strict=True):
            right = self.value(right_node)
            found = arithmetic.both(found, arithmetic.compare(op, left, right))
            left = right
        return found

    def _ifexp(self, node: ast.IfExp) -> Value:
        test = self.value(node.test)
        if not isinstance(test, Number):
            return self.value(node.body if test else node.orelse)
        a, b = self.perhaps(node.body), self.perhaps(node.orelse)
        if isinstance(a, Array) and isinstance(b, Array):
            return self._either_array(test, a, b)
        return arithmetic.chosen(test, a, b)

    def _either_array(self, test: Number, a: Array, b: Array) -> Value:
        """Return a pointer to one of two arrays, which must look alike."""
        if a.key != b.key:
            raise NotTranslated("one of two arrays is chosen that look different")
        return Choice(f"{test.within(7)} ? {self.address(a)} : {self.address(b)}", a, b)

    def _subscript(self, node: ast.Subscript) -> Value:
        of = self.value(node.value)
        if isinstance(of, tuple):
            i = self.value(node.slice)
            if isinstance(i, Number) and known(of):
                table = self.unit.table(of, node.value.id if isinstance(node.value, ast.Name) else "table")
                return arithmetic.element(table, (i,))
            if isinstance(i, Number):
                raise SizeUnknown("the place in a tuple is not known")
            return self.unit.wrapped(of[i])
        if isinstance(of, Several):
            i = self.value(node.slice)
            if not isinstance(i, int):
                raise SizeUnknown("the place among the numbers that a call returns is not known")
            return Number(f"{of.text}.at{i}", of.kinds[i])
        if not isinstance(of, Array):
            raise NotTranslated("what is indexed is no array")
        view = self.view(of, node.slice)
        return self.unit.read(view) if view.shape == () else view

    def view(self, of: Array, index: ast.expr) -> Array:
        """Return the part of an array at an index; a single entry has no shape."""
        places = list(index.elts) if isinstance(index, ast.Tuple) else [index]
        at, shape, strides, numbers = of.offset, [], [], of.numbers
        taken: list[Any] = []
        for axis, place in enumerate(places):
            n, stride = of.shape[axis], of.strides[axis]
            if isinstance(place, ast.Slice):
                first, last = self._bounds(place, n)
                at = arithmetic.binary(ast.Add(), at, arithmetic.binary(ast.Mult(), first, stride))
                size = arithmetic.binary(ast.Sub(), last, first)
                if isinstance(size, Number):
                    raise SizeUnknown("the size of a slice is not known")
                shape.append(max(0, size))
                strides.append(stride)
                taken.append(slice(first, last) if known((first, last)) else None)
                continue
            i = self.value(place)
            if isinstance(i, int):
                if not -n <= i < n:
                    raise NotTranslated(f"index {i} is outside an array of {n}")
                i = i % n
            elif not isinstance(i, Number) or i.kind == "double":
                raise NotTranslated("an index is no integer")
            at = arithmetic.binary(ast.Add(), at, arithmetic.binary(ast.Mult(), i, stride))
            taken.append(i if isinstance(i, int) else None)
        left = len(places)
        if numbers is not None:
            numbers = None if None in taken else np.asarray(numbers[tuple(taken)])
        return Array(
            of.pointer, of.storage, at, (*shape, *of.shape[left:]), (*strides, *of.strides[left:]), numbers
        )

    def _bounds(self, of: ast.Slice, n: int) -> tuple[Value, Value]:
        """Return the first place of a slice, and the one after its last."""
        if of.step is not None:
            raise NotTranslated("a slice with a step is not translated")
        first = 0 if of.lower is None else self.value(of.lower)
        last = n if of.upper is None else self.value(of.upper)
        first, last = (
            min(n, one + n if one < 0 else one) if isinstance(one, int) else one for one in (first, last)
        )
        return first, last

    def address(self, of: Array) -> str:
        """Return the C text of a pointer to the first entry of an array."""
        if of.size == 0:
            return NOWHERE
        at = number(of.offset)
        return of.pointer if at.text == "0" else f"{of.pointer} + {at.within(3)}"

    def _call(self, node: ast.Call) -> Value:
        if node.keywords:
            raise NotTranslated("arguments with names are not translated")
        function = self.value(node.func)
        given = self._tuple(ast.Tuple(elts=node.args, ctx=ast.Load()))
        return self.called(function, list(given))

    def called(self, function: Any, given: list[Value]) -> Value:
        """Return the value of a call."""
        if function in (min, max):
            return extreme(function, given)
        for table in (OF_PYTHON, OF_LANES):
            if _hashable(function) and function in table:
                return table[function](*given)
        if is_of_numbers(function):
            return self.unit.mathematics.call(function, given)
        if function in (np.max, np.min):
            return self._largest(function, given[0])
        if function in MAKERS:
            return self.made(function, given[0], self.temporary())
        if getattr(function, "_defn", None) is not None:
            return self._by_address(function, given)
        if hasattr(function, "py_func"):
            return self.of_kernel(function.py_func, given)
        if isinstance(function, Callable) and getattr(function, "__name__", "") == "<lambda>":  # type: ignore[arg-type]
            return function(*given)
        if isinstance(function, type) and issubclass(function, tuple):
            return function(*map(self._settled, given))
        raise NotTranslated(f"a call of {getattr(function, '__name__', function)} is not translated")

    def _largest(self, function: Any, of: Value) -> Value:
        """Return the largest or smallest entry of an array."""
        name = self.temporary()
        zero = (0,) * len(of.shape)
        self.scope.assign(name, number(arithmetic.entry_of(of, zero)))
        with self.over(of.shape) as index:
            found = Number(c_name(name), kind_of(arithmetic.entry_of(of, zero)))
            value = extreme({np.max: max, np.min: min}[function], [found, arithmetic.entry_of(of, index)])
            self.scope.assign(name, value)
        self.scope.load(name)
        return Number(c_name(name), self.scope.kind(name))

    def made(self, maker: Any, size: Value, name: str) -> Array:
        """Return a new local array."""
        shape = size.shape if maker is np.zeros_like else size
        shape = shape if isinstance(shape, tuple) else (shape,)
        if not known(shape):
            raise SizeUnknown(f"the size of {name} is not known")
        return self.scope.local(name, shape, "double", zero=maker is not np.empty)

    def temporary(self) -> str:
        """Return the name of a variable that the kernel does not have."""
        self.temporaries += 1
        return f"t{self.temporaries}"

    def over(self, shape: tuple[int, ...]) -> Any:
        """Open loops over all indices of an array; yields the index."""
        return _Loops(self.scope, shape)

    def _by_address(self, function: Any, given: list[Value]) -> Value:
        """Return a call of a kernel by its address, which must be known."""
        if function._name == "call_method":
            method, arguments = given
            if not known(method):
                raise SizeUnknown("the method that is called is not known")
            code, data = method
            return self.of_kernel(methods.kernel_at(code).py_func, [self.unit.data_at(data), *arguments])
        if function._name == "call_address":
            address, arguments = given
            if not known(address):
                raise SizeUnknown("the kernel that is called is not known")
            return self.of_kernel(methods.kernel_at(address).py_func, list(arguments))
        raise NotTranslated(f"the intrinsic {function._name} is not translated")

    def of_kernel(self, function: Any, given: list[Value]) -> Value:
        """Return a call of a kernel that is translated as a function."""
        given = [self._settled(one) for one in given]
        called: Function
        called, given = self.unit.function(function, given)
        if called.constant is not None:
            return called.constant[0]
        texts = []
        handed = [part for one in given for _, part in parts(one)]
        for parameter, one in zip(called.parameters, handed, strict=True):
            if not parameter.used:
                continue
            if isinstance(one, Array) and parameter.storage is not None:
                parameter.storage.point_into(one.storage)
                texts.append(self.address(one))
            else:
                texts.append(number(one).text)
        text = f"\0{'f' if texts else 'g'}{called.serial}\0{', '.join(texts)})"
        if called.returns is None:
            return Nothing(text)
        if isinstance(called.returns, tuple):
            return Several(text, called.returns)
        return Number(text, called.returns)

    def _settled(self, value: Value) -> Value:
        """Return an array that is computed as one in memory, so that it can be handed on."""
        if isinstance(value, Elementwise):
            return self.stored(self.temporary(), value)
        if isinstance(value, Choice):
            return self.scope.point(self.temporary(), value.text, value.a)
        if isinstance(value, Several):
            return self.unpacked(value)
        return value

    def as_now(self, value: Value) -> Value:
        """Return a tuple whose parts no later assignment changes; any other value as it is."""
        if not isinstance(value, tuple):
            return value
        found: list[Value] = [
            self.kept(one) if isinstance(one, Number) else self.as_now(self._settled(one)) for one in value
        ]
        return type(value)(*found) if hasattr(value, "_fields") else tuple(found)

    def unpacked(self, value: Several) -> tuple[Number, ...]:
        """Return the numbers that a call returns."""
        name = self.temporary()
        self.scope.emit(f"const \0r{self.unit.result(value.kinds)}\0 {name} = {value.text};")
        return tuple(Number(f"{name}.at{i}", kind) for i, kind in enumerate(value.kinds))

    def stored(self, name: str, value: Value) -> Array:
        """Store an array under the name of a local one."""
        empty = 0 in value.shape
        kind = "double" if empty else kind_of(arithmetic.entry_of(value, (0,) * len(value.shape)))
        array = self.scope.local(name, value.shape, kind, zero=False)
        self.store(array, value)
        return array

    def store(self, array: Array, value: Value) -> None:
        """Store a number in all entries of an array, or another array entry by entry."""
        array.storage.write()
        for part in arithmetic.parts_of(value):
            if part.storage is array.storage and part != array:
                raise NotTranslated("an array is stored over another part of itself")
        if array.shape == () and not arithmetic.parts_of(value):
            self.scope.emit(f"{arithmetic.element(array, ()).text} = {number(value).text};")
            return
        of = getattr(value, "shape", array.shape)
        if of != array.shape:
            raise NotTranslated(f"an array of shape {of} is stored as one of {array.shape}")
        if array.size == 0:
            return
        with self.over(array.shape) as index:
            entry = number(arithmetic.entry_of(value, index))
            self.scope.emit(f"{arithmetic.element(array, index).text} = {entry.text};")


class _Loops:
    """Nested loops over all indices of an array."""

    def __init__(self, scope: Scope, shape: tuple[int, ...]) -> None:
        self.scope, self.shape = scope, shape
        self.open: list[Any] = []

    def __enter__(self) -> tuple[Any, ...]:
        index: list[Any] = []
        for axis, n in enumerate(self.shape):
            if n == 1:
                index.append(0)
                continue
            name = f"e{axis}"
            block = self.scope.inside(f"for (int {name} = 0; {name} < {n}; {name}++)")
            block.__enter__()
            self.open.append(block)
            index.append(Number(name, "int", natural=True))
        return tuple(index)

    def __exit__(self, *error: Any) -> None:
        for block in reversed(self.open):
            block.__exit__(*error)


def _reshaped(of: Array, shape: tuple[Value, ...]) -> Array:
    """Return an array whose rows follow each other with another shape, in which one size may be -1."""
    if not known(shape):
        raise SizeUnknown("the shape is not known")
    if of.strides != array_of("", of.storage, of.shape).strides:
        raise NotTranslated("an array whose rows do not follow each other gets another shape")
    given = math.prod(n for n in shape if n >= 0)
    found = array_of(of.pointer, of.storage, tuple(n if n >= 0 else of.size // given for n in shape))
    if found.size != of.size:
        raise NotTranslated(f"an array of shape {of.shape} gets the shape {shape}")
    numbers = None if of.numbers is None else of.numbers.reshape(found.shape)
    return replace(found, offset=of.offset, numbers=numbers)


def _hashable(function: Any) -> bool:
    return type(function).__hash__ is not None
