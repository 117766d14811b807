"""One translation unit: the functions that an entry reaches, and the data that they read and write."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain, count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from otolith.core import methods
from otolith.export.translate.arithmetic import element, place
from otolith.export.translate.body import Body
from otolith.export.translate.builtins import Mathematics
from otolith.export.translate.function import Function, Parameter
from otolith.export.translate.scope import PLACE
from otolith.export.translate.values import (
    NOWHERE,
    Array,
    Kind,
    NotTranslated,
    Number,
    SizeUnknown,
    Storage,
    Value,
    number,
    parts,
    plain,
)

_KINDS: dict[str, Kind] = {"f": "double", "i": "int", "b": "bool"}
ROUNDS = 8  # largest number of times that a unit is begun anew


@dataclass(eq=False)
class Data:
    """An array of the data, as long as memory goes that views share."""

    root: NDArray[Any]
    storage: Storage
    begin: int  # the entry of `root` that is its first in C
    names: list[tuple[int, str]] = field(default_factory=list)  # sizes of views, and what they are called
    first: int = -1  # the first entry that some view has …
    last: int = -1  # … and the one after the last; −1 where there is no view

    def view(self, first: int, last: int) -> None:
        """Note that a view spans some entries."""
        self.first = first if self.first < 0 else min(self.first, first)
        self.last = max(self.last, last)

    @property
    def numbers(self) -> NDArray[Any]:
        """Return the entries that are in C, as they lie in memory."""
        found: NDArray[Any] = self.root.ravel("K")[self.begin : self.last]
        return found

    @property
    def name(self) -> str:
        """Return what the largest view of it is called."""
        most = max((size for size, _ in self.names), default=0)
        return min((name for size, name in self.names if size == most), key=len, default="data")


class Unit:
    """The functions and data of one program.

    Integers of the data are taken for constants, so that sizes and branches are known, unless some kernel
    writes them; `translated` begins anew where that turned out too late.

    Parameters
    ----------
    variable : data that kernels write, by the address of their memory.
    begins : the first entry of data that any view has, by address; 0 where it is not known.
    """

    def __init__(self, variable: set[int], begins: dict[int, int]) -> None:
        self.mathematics = Mathematics()
        self.broken = np.zeros(1, dtype=np.int64)  # becomes 1 in C where a kernel raises an error in Python
        self.functions: list[Function] = []
        self.data: dict[int, Data] = {}  # by address
        self.results: dict[tuple[Kind, ...], str] = {}  # types of several numbers that functions return
        self._variable, self._begins = variable, begins
        self._tables: dict[tuple[Any, ...], NDArray[Any]] = {}
        self._addresses: dict[int, int] = {}  # of data, by the serial of their storage
        self._made: dict[Any, Function | SizeUnknown] = {}
        self._names: dict[str, Any] = {}  # the kernel that has a name as its own
        self._taken = {"init", "step"}
        self._data_of(self.broken).names.append((1, "broken"))
        self._methods: dict[int, str] = {}  # what a method is called, by the address of its data

    def call(self, values: Any, name: str) -> None:
        """Give names to the arrays in a named tuple; `name` goes before them."""
        for part, value in zip(values._fields, values, strict=True):
            path = f"{name}_{part}" if name else part
            if isinstance(value, np.ndarray):
                self._data_of(value).names.append((value.size, path))
            elif isinstance(value, methods.Method):
                self._methods[value.data] = path
            elif hasattr(value, "_fields"):
                self.call(value, path)

    def data_at(self, data: int) -> Any:
        """Return the named tuple of a method."""
        values = methods.values_at(data)
        if hasattr(values, "_fields"):
            self.call(values, self._methods.get(data, ""))
        return values

    def _data_of(self, array: NDArray[Any]) -> Data:
        root = array
        while isinstance(root.base, np.ndarray):
            root = root.base
        if root.dtype.kind not in _KINDS:
            raise NotTranslated(f"an array of {root.dtype} is not translated")
        address = root.ctypes.data
        if address not in self.data:
            self.data[address] = of = Data(
                root, Storage(_KINDS[root.dtype.kind]), self._begins.get(address, 0)
            )
            self._addresses[of.storage.serial] = address
        return self.data[address]

    def wrapped(self, value: Value) -> Value:
        """Return an array of the data as a view of its storage, any other value as it is."""
        if not isinstance(value, np.ndarray):
            return plain(value)
        of = self._data_of(value)
        size = of.root.itemsize
        offset = (value.ctypes.data - of.root.ctypes.data) // size
        strides = tuple(stride // size for stride in value.strides)
        if not value.size:
            return Array(NOWHERE, of.storage, 0, value.shape, strides, value)
        spans = (sum((n - 1) * step for n, step in zip(value.shape, strides, strict=True)), 0)
        of.view(offset + min(spans), offset + max(spans) + 1)
        pointer = PLACE.format("d", of.storage.serial)
        return Array(pointer, of.storage, offset - of.begin, value.shape, strides, value)

    def table(self, numbers: tuple[Any, ...], name: str) -> Array:
        """Return a tuple of numbers as an array of constants."""
        if numbers not in self._tables:
            self._tables[numbers] = np.array(numbers)
            self._data_of(self._tables[numbers]).names.append((len(numbers), name))
        found: Array = self.wrapped(self._tables[numbers])
        return found

    def entries(self, of: Array) -> tuple[Value, ...]:
        """Return the entries of an array with one axis, each as `read` returns it."""
        return tuple(
            self.read(
                Array(
                    of.pointer,
                    of.storage,
                    place(of, (i,)),
                    (),
                    (),
                    None if of.numbers is None else of.numbers[i : i + 1].reshape(()),
                )
            )
            for i in range(of.shape[0])
        )

    def read(self, view: Array) -> Value:
        """Return a single entry: known, if it is an integer that no kernel is known to write."""
        if view.numbers is None or view.kind == "double":
            return element(view, ())
        if self._addresses[view.storage.serial] in self._variable:
            return element(view, ())
        view.storage.assumed = True
        return plain(view.numbers[()])

    def result(self, kinds: tuple[Kind, ...]) -> str:
        """Return the name of the type of several numbers."""
        return self.results.setdefault(kinds, "_".join(kinds))

    def function(self, function: Any, given: list[Value]) -> tuple[Function, list[Value]]:
        """Return the function that a kernel becomes for some arguments, and the arguments as it takes them.

        Numbers that are known are handed over as others are, unless sizes depend on them.
        """
        general = [_unknown(one) for one in given]
        try:
            return self._function(function, general), general
        except SizeUnknown:
            if general == given:
                raise
        return self._function(function, given), given

    def _function(self, function: Any, given: list[Value]) -> Function:
        key = (function, *map(self._key, given))
        found = self._made.get(key)
        if isinstance(found, SizeUnknown):
            raise found
        if found is None:
            found = Function(self._name(function), _comment(function), _parameters(function, given))
            body = Body(self, function, given, found.parameters)
            try:
                body.translate(found)
            except SizeUnknown as error:
                self._taken.discard(found.name)
                self._made[key] = error
                raise
            self._made[key] = found
            self.functions.append(found)
        return found

    def _name(self, function: Any) -> str:
        """Return a name in C that no other function has."""
        own: str = function.__name__.lstrip("_")
        if self._names.setdefault(own, function) is not function:
            own = f"{function.__module__.rsplit('.', 1)[-1]}_{own}"
        name = next(one for one in _variants(own) if one not in self._taken)
        self._taken.add(name)
        return name

    def _key(self, value: Value) -> Any:
        """Return what tells arguments apart for which a kernel becomes different functions."""
        if isinstance(value, Number):
            return ("number", value.kind, value.natural)
        if isinstance(value, Array):
            return value.key
        if isinstance(value, np.ndarray):
            return (value.ctypes.data, value.shape, value.strides)
        if isinstance(value, tuple):
            return (type(value), *map(self._key, value))
        return (type(value), value)

    @property
    def too_late(self) -> set[int]:
        """Return the data that were taken for constants and are written."""
        return {at for at, of in self.data.items() if of.storage.assumed and of.storage.written}


def translated(function: Any, values: Any) -> tuple[Unit, Function]:
    """Translate a kernel that takes one named tuple; return the unit, and the function that it becomes.

    Raises
    ------
    NotTranslated : a kernel that it reaches contains what cannot be said in C here.
    """
    variable: set[int] = set()
    begins: dict[int, int] = {}
    for _ in range(ROUNDS):
        unit = Unit(variable, begins)
        unit.call(values, "")
        entry, _ = unit.function(function, [values])
        found = {at: of.first for at, of in unit.data.items() if of.first > 0}
        if not unit.too_late and found == begins:
            return unit, entry
        variable, begins = variable | unit.too_late, found
    raise NotTranslated(f"{function.__name__}: what is constant does not settle")


def _parameters(function: Any, given: list[Value]) -> list[Parameter]:
    """Return the parameters of a kernel for its arguments, with names that no variable of it has."""
    names: tuple[str, ...] = function.__code__.co_varnames
    return [
        Parameter(
            part if part == name else next(one for one in _variants(part) if one not in names),
            value.kind,
            Storage(value.kind) if isinstance(value, Array) else None,
        )
        for name, one in zip(names, given, strict=False)
        for part, value in parts(one, name)
    ]


def _variants(name: str) -> Iterator[str]:
    """Yield a name, and others like it."""
    return chain([name], (f"{name}_{n}" for n in count(2)))


def _unknown(value: Value) -> Value:
    """Return a number that is known as one that is handed over."""
    return number(value) if isinstance(value, (bool, int, float)) else value


def _comment(function: Any) -> str:
    """Return the first paragraph of a kernel's docstring, in one line."""
    return " ".join((function.__doc__ or "").strip().split("\n\n")[0].split())
