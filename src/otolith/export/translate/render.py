"""The text of a unit: types, constants, helpers and functions, with everything put in by name."""

import re
import textwrap
from collections.abc import Iterable, Iterator
from typing import Any, Final

from numpy.typing import NDArray

from otolith.export.translate.function import Function
from otolith.export.translate.scope import c_name
from otolith.export.translate.unit import Data, Unit
from otolith.export.translate.values import C_TYPES, literal

_PLACE: Final = re.compile("\0(?:([dfgcthr])([^\0]*))\0")
WIDTH: Final = 110
_EVEN: Final = 8  # so many equal numbers in a row are set by a loop

_HELPERS: Final = {
    "min": "static double {n}_min(double a, double b) {{ return b < a ? b : a; }}",
    "max": "static double {n}_max(double a, double b) {{ return b > a ? b : a; }}",
    "min_int": "static int {n}_min_int(int a, int b) {{ return b < a ? b : a; }}",
    "max_int": "static int {n}_max_int(int a, int b) {{ return b > a ? b : a; }}",
    "floor_div": "static int {n}_floor_div(int a, int b) {{ return a / b - (a % b != 0 && (a < 0) != (b < 0)); }}",  # noqa: E501
    "floor_mod": "static int {n}_floor_mod(int a, int b) {{ return (a % b + b) % b; }}",
    "round_int": """static int {n}_round_int(double a) {{
    const double below = floor(a), over = a - below;
    return (int)(over > 0.5 || (over == 0.5 && (int)below % 2 != 0) ? below + 1.0 : below);
}}""",
    "abs_int": "static int {n}_abs_int(int a) {{ return a < 0 ? -a : a; }}",
}
_LANES: Final = """
/* Four numbers at once: in registers where the compiler has them, unless {n}_PLAIN is defined. */
#if defined(__GNUC__) && !defined({n}_PLAIN)
typedef double {n}_lanes __attribute__((vector_size(32), aligned(8), may_alias));
#define {n}_LOAD(p) (*(const {n}_lanes *)(p))
#define {n}_STORE(p, v) (*({n}_lanes *)(p) = (v))
#define {n}_UNIT(a, b, c, d) (({n}_lanes){{a, b, c, d}})
#define {n}_LANE(v, i) ((v)[i])
#define {n}_TIMES(s, v) ((s) * (v))
#define {n}_ADD(a, b) ((a) + (b))
#define {n}_ADD_TIMES(a, s, v) ((a) + (s) * (v))
#define {n}_LESS_TIMES(a, s, v) ((a) - (s) * (v))
#else
typedef struct {{ double at[4]; }} {n}_lanes;
#define {n}_LANE(v, i) ((v).at[i])
{plain}
#endif
"""
_FOUR: Final = "for (int i = 0; i < 4; i++)"
_PLAIN: Final = {  # head and statement of what a compiler without registers of four calls
    "LOAD": ("{n}_LOAD(const double *p)", f"{{n}}_lanes v; {_FOUR} v.at[i] = p[i]; return v;"),
    "STORE": ("{n}_STORE(double *p, {n}_lanes v)", f"{_FOUR} p[i] = v.at[i]; return v;"),
    "UNIT": (
        "{n}_UNIT(double a, double b, double c, double d)",
        "{n}_lanes v = {{{{a, b, c, d}}}}; return v;",
    ),
    "TIMES": ("{n}_TIMES(double s, {n}_lanes v)", f"{_FOUR} v.at[i] *= s; return v;"),
    "ADD": ("{n}_ADD({n}_lanes a, {n}_lanes b)", f"{_FOUR} a.at[i] += b.at[i]; return a;"),
    "ADD_TIMES": (
        "{n}_ADD_TIMES({n}_lanes a, double s, {n}_lanes v)",
        f"{_FOUR} a.at[i] += s * v.at[i]; return a;",
    ),
    "LESS_TIMES": (
        "{n}_LESS_TIMES({n}_lanes a, double s, {n}_lanes v)",
        f"{_FOUR} a.at[i] -= s * v.at[i]; return a;",
    ),
}


class Rendered:
    """A unit as text, for one entry.

    Parameters
    ----------
    name : of the program; all names of the file begin with it.
    """

    def __init__(self, unit: Unit, entry: Function, name: str, kept: Iterable[NDArray[Any]]) -> None:
        self.unit, self.name = unit, name
        reached = _reached(entry, unit.functions)
        self.functions = [one for one in unit.functions if one in reached]
        read = set().union(*(one.reads for one in self.functions))
        for array in kept:  # what the program's frame reads and writes
            of = unit._data_of(array)
            unit.wrapped(array)
            of.storage.write()
            read.add(of.storage.serial)
        data = [of for of in unit.data.values() if of.storage.serial in read and len(of.numbers)]
        self.names = _names_of(data, {one.name for one in self.functions} | set(_HELPERS))
        self.members = sorted((of for of in data if of.storage.written), key=lambda of: -len(of.numbers))
        self.constants = [of for of in data if not of.storage.written]
        self._data = {of.storage.serial: of for of in data}
        self._storages = _storages(self.functions)
        self._numbered = {one.serial: one for one in self.functions}
        self._using = self._users()
        self._helpers: set[str] = set()
        self.entry = entry

    def _users(self) -> set[Function]:
        """Return the functions that need the struct, for themselves or for what they call."""
        members = {of.storage.serial for of in self.members}
        using = {one for one in self.functions if one.reads & members}
        for one in self.functions:  # what is called comes first
            if one.calls & {other.serial for other in using}:
                using.add(one)
        return using

    def struct(self) -> str:
        """Return the struct with everything that is written."""
        lines = [
            f"    {C_TYPES[of.storage.kind]} {self.names[of]}[{len(of.numbers)}];" for of in self.members
        ]
        return "\n".join([f"struct {self.name} {{", *lines, "};"])

    @property
    def broken(self) -> str:
        """Return the C text of the number that is 1 where a kernel has given up; empty if none can."""
        of = self.unit._data_of(self.unit.broken)
        return f"me->{self.names[of]}[0]" if of in self.members else ""

    def of(self, array: NDArray[Any]) -> str:
        """Return the C text of the first entry of an array of the data, for the program's frame."""
        view = self.unit.wrapped(array)
        return self._put(view.pointer) + (f" + {view.offset}" if view.offset else "")

    def implementation(self) -> str:
        """Return constants, helpers and functions."""
        functions = "\n\n".join(self._function(one) for one in self.functions)
        results = [self._result(kinds) for kinds in self.unit.results]
        constants = [self._constant(of) for of in self.constants]
        helpers = [_HELPERS[one].format(n=self.name) for one in _HELPERS if one in self._helpers]
        lanes = [self._lanes()] if self._helpers - set(_HELPERS) else []
        parts = [*constants, "\n".join([*results, *helpers, *lanes]), functions]
        return "\n\n".join(part for part in parts if part)

    def _lanes(self) -> str:
        """Return the type of four numbers, and those functions of it that are used."""
        plain = [
            f"static {{n}}_lanes {head} {{{{ {statement} }}}}".format(n=self.name)
            for name, (head, statement) in _PLAIN.items()
            if name in self._helpers
        ]
        return _LANES.format(n=self.name, plain="\n".join(plain))

    def _result(self, kinds: tuple[Any, ...]) -> str:
        members = " ".join(f"{C_TYPES[kind]} at{i};" for i, kind in enumerate(kinds))
        return f"typedef struct {{ {members} }} {self.name}_{self.unit.results[kinds]};"

    def _function(self, of: Function) -> str:
        parameters = [f"{self.name} *me"] if of in self._using else []
        for one in of.parameters:
            if not one.used:
                continue
            name = c_name(one.name)
            if one.storage is None:
                parameters.append(f"{self._type(one.kind)}{name}")
            else:
                constant = "" if one.storage.written else "const "
                parameters.append(f"{constant}{C_TYPES[one.kind]} *{name}")
        if of.returns is None:
            returned = "void "
        elif isinstance(of.returns, str):
            returned = self._type(of.returns)
        else:
            returned = f"{self.name}_{self.unit.results[of.returns]} "
        head = f"static {returned}{self.name}_{of.name}({', '.join(parameters) or 'void'})"
        body = "\n".join(of.body.text()).lstrip()
        comment = textwrap.fill(
            of.comment.replace("*/", "* /"), WIDTH, initial_indent="/* ", subsequent_indent="   "
        )
        written = self._put(f"{head} {body}")
        return f"{comment} */\n{written}" if of.comment else written

    def _type(self, kind: str) -> str:
        if kind == "lanes":
            return f"{self.name}_lanes "
        return f"{C_TYPES[kind]} "

    def _put(self, text: str) -> str:
        """Put names in."""
        return _PLACE.sub(self._named, text)

    def _named(self, match: re.Match[str]) -> str:
        letter, what = match.groups()
        if letter == "h":
            self._helpers.add(what)
            return f"{self.name}_{what}("
        if letter == "t":
            return f"{self.name}_lanes"
        if letter == "r":
            return f"{self.name}_{what}"
        serial = int(what)
        if letter == "d":
            of = self._data[serial]
            return f"me->{self.names[of]}" if of.storage.written else f"{self.name}_{self.names[of]}"
        if letter == "c":
            return "" if self._storages[serial].written else "const "
        called = self._numbered[serial]
        me = ("me, " if letter == "f" else "me") if called in self._using else ""
        return f"{self.name}_{called.name}({me}"

    def _constant(self, of: Data) -> str:
        head = f"static const {C_TYPES[of.storage.kind]} {self.name}_{self.names[of]}[{len(of.numbers)}] = "
        return head + _table(of.numbers)

    def initial(self) -> Iterator[str]:
        """Yield the lines that set what is not zero in the struct, with their tables in between."""
        for of in self.members:
            flat, name = of.numbers, self.names[of]
            for first, last, even in _segments(flat):
                if even:
                    here = literal(flat[first].item())
                    yield f"    for (int i = {first}; i < {last}; i++) me->{name}[i] = {here};"
                elif last - first == 1:
                    yield f"    me->{name}[{first}] = {literal(flat[first].item())};"
                else:
                    count, kind = last - first, C_TYPES[of.storage.kind]
                    yield "    {"
                    yield f"        static const {kind} initial[{count}] = {_table(flat[first:last])}"
                    yield f"        for (int i = 0; i < {count}; i++) me->{name}[{first} + i] = initial[i];"
                    yield "    }"


def _table(numbers: NDArray[Any]) -> str:
    text = ", ".join(literal(one) for one in numbers.tolist())
    lines = textwrap.fill(
        text, WIDTH, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False
    )
    return "{\n" + lines + "};"


def _segments(numbers: NDArray[Any]) -> Iterator[tuple[int, int, bool]]:
    """Yield the stretches (first, last, whether all are equal) of what is not zero."""
    n, i, open_ = len(numbers), 0, -1
    while i < n:
        j = i
        while j < n and (numbers[j] == numbers[i]):
            j += 1
        j = max(j, i + 1)
        even = j - i >= _EVEN or numbers[i] == 0
        if even and open_ >= 0 and not (numbers[i] == 0 and j - i < _EVEN and j < n):
            yield open_, i, False
            open_ = -1
        if even and open_ < 0:
            if numbers[i] != 0:
                yield i, j, True
        elif open_ < 0:
            open_ = i
        i = j
    if open_ >= 0:
        yield open_, n, False


def _reached(entry: Function, functions: list[Function]) -> set[Function]:
    """Return the functions that an entry calls, directly or not, and the entry itself."""
    numbered = {one.serial: one for one in functions}
    found, waiting = {entry}, [entry]
    while waiting:
        for serial in waiting.pop().calls:
            if numbered[serial] not in found:
                found.add(numbered[serial])
                waiting.append(numbered[serial])
    return found


def _names_of(data: list[Data], taken: set[str]) -> dict[Data, str]:
    """Give each array of the data a name of its own, none of those that are taken."""
    names: dict[Data, str] = {}
    for of in data:
        name, n = of.name, 1
        while name in taken:
            n += 1
            name = f"{of.name}_{n}"
        taken.add(name)
        names[of] = name
    return names


def _storages(functions: list[Function]) -> dict[int, Any]:
    found = {}
    for one in functions:
        for variable in one.variables.values():
            if variable.storage is not None:
                found[variable.storage.serial] = variable.storage
    return found
