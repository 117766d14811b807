"""The variables of one C function, and the blocks in which its statements stand.

A variable is declared where it is first assigned if all its uses are in that block, else at the start of the
smallest block that holds them all. Where that is, and of which kind a variable is, is known after a first
pass over the function; so a function is translated until both no longer change.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, Final

from otolith.export.translate.values import (
    C_TYPES,
    UNARY,
    Array,
    Kind,
    NotTranslated,
    Number,
    Storage,
    joined,
)

# Words that a variable of C cannot have, and names with a meaning of their own in what is written
_TAKEN: Final = frozenset(
    """auto break case char const continue default do double else enum extern float for goto if inline int
    long register restrict return short signed sizeof static struct switch typedef union unsigned void
    volatile while me abs fabs sqrt sin cos exp min max""".split()  # noqa: SIM905
)
_PUT_IN: Final = re.compile("\0[^\0]*\0")
_WORD: Final = re.compile(r"\b[A-Za-z_]\w*")
PLACE: Final = "\0{}{}\0"  # what is put in when everything is known: letter and number


@dataclass(eq=False)
class Block:
    """A block of C: statements, and blocks below a head such as `if (x)`."""

    path: tuple[int, ...]  # numbers of the blocks around it, and its own
    head: str = ""
    items: list["str | Block"] = field(default_factory=list)

    def text(self, indent: str = "") -> Iterator[str]:
        """Yield its lines."""
        inner = indent + "    "
        yield f"{indent}{self.head} {{" if self.head else f"{indent}{{"
        for item in self.items:
            if isinstance(item, Block):
                yield from item.text(inner)
            else:
                yield inner + item
        yield f"{indent}}}"


@dataclass(eq=False)
class Variable:
    """What is known about a variable after a pass."""

    kinds: set[Kind] = field(default_factory=set)
    size: tuple[int, ...] = ()  # of a local array
    storage: Storage | None = None  # of a local array, or of a pointer
    paths: list[tuple[int, ...]] = field(default_factory=list)  # blocks in which it stands
    assigned: int = 0  # number of assignments
    loaded: int = 0
    pointer: bool = False

    @property
    def home(self) -> tuple[int, ...]:
        """Return the path of the smallest block around all its uses."""
        shared = self.paths[0]
        for path in self.paths:
            n = 0
            while n < min(len(shared), len(path)) and shared[n] == path[n]:
                n += 1
            shared = shared[:n]
        return shared


class Scope:
    """Variables and blocks of one pass.

    Parameters
    ----------
    before : what the pass before found.
    unread : the parameters that it found to be read nowhere; nothing is assigned to them.
    """

    def __init__(self, before: dict[str, Variable], parameters: set[str], unread: set[str]) -> None:
        self.before, self.found = before, dict[str, Variable]()
        self.parameters = parameters
        self.unread = unread
        self.targets: Counter[str] = Counter()  # how often a name stands on the left of an assignment
        self.used: Counter[str] = Counter()  # how often parameters are read
        self.declared: set[tuple[str, tuple[int, ...]]] = set()
        self._blocks = 0
        self.lazy = 0  # depth of operands that are perhaps not computed
        self.root = self.block = Block((0,))
        self._homes: dict[tuple[int, ...], Block] = {}

    def emit(self, line: str) -> None:
        """Append a statement."""
        if self.lazy:
            raise NotTranslated("a statement is needed within an operand that is perhaps not computed")
        self.block.items.append(line)

    @contextmanager
    def inside(self, head: str) -> Iterator[Block]:
        """Open a block below a head."""
        self._blocks += 1
        outer, new = self.block, Block((*self.block.path, self._blocks), head)
        outer.items.append(new)
        self.block = new
        self._homes[new.path] = new
        try:
            yield new
        finally:
            self.block = outer

    def mark(self) -> tuple[Any, ...]:
        """Return where the translation is, for `back_to`."""
        found = {
            name: replace(of, kinds=set(of.kinds), paths=list(of.paths)) for name, of in self.found.items()
        }
        return (
            self.block,
            len(self.block.items),
            self._blocks,
            self.lazy,
            found,
            set(self.declared),
            Counter(self.targets),
        )

    def back_to(self, mark: tuple[Any, ...]) -> None:
        """Forget the statements since a mark."""
        self.block, length, self._blocks, self.lazy, self.found, self.declared, self.targets = mark
        del self.block.items[length:]

    def note(self, name: str) -> Variable:
        """Note that a variable stands in the present block."""
        of = self.found.setdefault(name, Variable())
        of.paths.append(self.block.path)
        return of

    def load(self, name: str) -> None:
        """Note that a variable, or a parameter, is read in the present block."""
        if name not in self.parameters:
            self.note(name)

    def finish(self) -> None:
        """Count in the text how often variables and parameters are read: more than they are assigned."""
        words = Counter(_WORD.findall(_PUT_IN.sub("", "\n".join(self.root.text()))))
        for name, of in self.found.items():
            of.loaded = words[c_name(name)] - self.targets[name]
        for name in self.parameters:
            self.used[name] = words[c_name(name)] - self.targets[name]

    def kind(self, name: str) -> Kind:
        """Return the kind of a variable as far as it is known."""
        kinds = set(self.found[name].kinds) if name in self.found else set()
        if name in self.before:
            kinds |= self.before[name].kinds
        return joined(kinds)

    def assign(self, name: str, value: Number) -> None:
        """Assign a number; the first assignment may be the declaration."""
        of = self.note(name)
        of.kinds.add(value.kind)
        of.assigned += 1
        known = self.before.get(name)
        if known is not None and known.loaded == 0:
            if "\0f" in value.text or "\0g" in value.text:  # a call, which perhaps does something
                self.emit(f"(void){value.within(UNARY)};")
            return
        self.targets[name] += 1
        if self._begins(name):
            qualified = "const " if known is not None and known.assigned == 1 else ""
            self.emit(f"{qualified}{self.type_of(name)} {c_name(name)} = {value.text};")
            return
        self.emit(f"{c_name(name)} = {value.text};")

    def _begins(self, name: str) -> bool:
        """Return whether a variable that was just noted is declared here: first, and in its home."""
        known, of = self.before.get(name), self.found[name]
        if known is None or known.home != self.block.path or len(of.paths) > 1:
            return False
        self.declared.add((name, known.home))
        return True

    def type_of(self, name: str) -> str:
        """Return the C type of a variable."""
        kind = self.kind(name)
        return PLACE.format("t", 0) if kind == "lanes" else C_TYPES[kind]

    def local(self, name: str, shape: tuple[int, ...], kind: Kind, zero: bool) -> Array:
        """Return a local array; it is declared in the block that holds its uses."""
        of, known = self.note(name), self.before.get(name)
        if of.storage is None:
            of.storage = known.storage if known and known.storage else Storage(kind)
        elif of.size != shape:
            raise NotTranslated(f"the array {name} has several shapes")
        of.kinds, of.size, of.assigned = {kind}, shape, of.assigned + 1
        array = array_of(c_name(name), of.storage, shape)
        if known is not None and known.loaded == 0:  # the data rule out what would use it
            return array
        if self._begins(name):
            self.targets[name] += 1
            self.emit(f"{C_TYPES[kind]} {c_name(name)}[{max(1, array.size)}]{' = {0}' if zero else ''};")
        elif zero:
            with self.inside(f"for (int zero = 0; zero < {array.size}; zero++)"):
                self.emit(f"{c_name(name)}[zero] = 0;")
        return array

    def point(self, name: str, text: str, array: Array) -> Array:
        """Return the array behind a pointer variable that is set to C text; `array` gives its layout."""
        of, known = self.note(name), self.before.get(name)
        if of.storage is None:
            of.storage = known.storage if known and known.storage else Storage(array.kind)
        if of.size not in ((), (*array.shape, *array.strides)):
            raise NotTranslated(f"the pointer {name} has several layouts")
        of.size, of.kinds, of.pointer = (*array.shape, *array.strides), {array.kind}, True
        of.assigned += 1
        self.targets[name] += 1
        if self._begins(name):
            self.emit(f"{pointer_type(of.storage)} *{c_name(name)} = {text};")
        else:
            self.emit(f"{c_name(name)} = {text};")
        return Array(c_name(name), of.storage, 0, array.shape, array.strides)

    def declare_others(self) -> None:
        """Declare what was not declared where it was first assigned, at the starts of their blocks."""
        self._homes[self.root.path] = self.root
        for name, of in reversed(self.found.items()):
            known = self.before.get(name)
            if known is None or (name, known.home) in self.declared or name in self.parameters:
                continue
            if known.loaded == 0 and not known.pointer:
                continue
            if of.pointer and of.storage is not None:
                line = f"{pointer_type(of.storage)} *{c_name(name)};"
            elif of.size:
                line = f"{C_TYPES[self.kind(name)]} {c_name(name)}[{max(1, math.prod(of.size))}];"
            else:
                line = f"{self.type_of(name)} {c_name(name)};"
            self._homes[known.home].items.insert(0, line)


def c_name(name: str) -> str:
    """Return the name of a variable in C."""
    return f"{name}_" if name in _TAKEN else name


def pointer_type(storage: Storage) -> str:
    """Return the type of what a pointer points to, which is constant if nothing writes through it."""
    return PLACE.format("c", storage.serial) + C_TYPES[storage.kind]


def array_of(pointer: str, storage: Storage, shape: tuple[int, ...], numbers: Any = None) -> Array:
    """Return a whole array whose rows follow each other."""
    strides, step = [], 1
    for n in reversed(shape):
        strides.append(step)
        step *= n
    return Array(pointer, storage, 0, shape, tuple(reversed(strides)), numbers)
