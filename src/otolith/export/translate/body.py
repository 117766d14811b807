"""The statements of one kernel, from its source text to blocks of C."""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from otolith.export.translate import arithmetic
from otolith.export.translate.assignments import Assignments
from otolith.export.translate.expressions import Expressions
from otolith.export.translate.function import Function, Parameter
from otolith.export.translate.scope import Scope, c_name
from otolith.export.translate.syntax import assignments, breaks, source_of, stores
from otolith.export.translate.values import (
    Array,
    Nothing,
    NotTranslated,
    Number,
    Several,
    SizeUnknown,
    Value,
    joined,
    kind_of,
    known,
    number,
)

UNROLLED: Final = 64  # largest number of rounds of a loop that is written out
PASSES: Final = 6
_READ: Final = re.compile("\0d(\\d+)\0")  # data that a text names
_CALLED: Final = re.compile("\0[fg](\\d+)\0")  # and functions


class Body:
    """Translates the statements of one kernel, for given arguments.

    Parameters
    ----------
    given : arguments that are known are values of Python; of others, their kind counts.
    """

    def __init__(self, unit: Any, function: Any, given: list[Value], parameters: list[Parameter]) -> None:
        self.unit, self.function = unit, function
        self.tree, self.file, self.line = source_of(function)
        self.sites = assignments(self.tree)
        cells = function.__closure__ or ()
        closure = zip(function.__code__.co_freevars, (cell.cell_contents for cell in cells), strict=True)
        self.outer = {**function.__globals__, **dict(closure)}
        self.given, self.parameters = given, parameters
        self.returned: set[Any] = set()
        self.results: list[Value] = []

    def translate(self, into: Function) -> None:
        """Translate until what is known about the variables no longer changes."""
        before: dict[str, Any] = {}
        unread: set[str] = set()
        for _ in range(PASSES):
            scope = self._once(before, unread)
            now_unread = {one.name for one in self.parameters if not scope.used[one.name]}
            if _same(before, scope.found) and unread == now_unread:
                break
            before, unread = scope.found, now_unread
        else:
            raise NotTranslated(f"{self.function.__name__}: the kinds of its variables do not settle")
        scope.declare_others()
        for parameter in self.parameters:
            parameter.used = parameter.name not in unread
        into.body, into.variables = scope.root, scope.found
        text = "\n".join(scope.root.text())
        into.reads = {int(serial) for serial in _READ.findall(text)}
        into.calls = {int(serial) for serial in _CALLED.findall(text)}
        into.returns = self._result()
        if len(scope.root.items) == 1 and len(self.results) == 1 and known(self.results[0]):
            into.constant = (self.results[0],)

    def _once(self, before: dict[str, Any], unread: set[str]) -> Scope:
        self.returned, self.results = set(), []
        self.scope = Scope(before, {parameter.name for parameter in self.parameters}, unread)
        self.of = Expressions(self.unit, self.scope, self.outer)
        self.assigning = Assignments(self.unit, self.scope, self.of, self.sites)
        left = iter(self.parameters)
        for argument, value in zip(self.tree.args.args, self.given, strict=True):
            self.of.here |= self._received(argument.arg, value, left)
        self._block(self.tree.body)
        self.scope.finish()
        return self.scope

    def _received(self, name: str, value: Value, left: Iterator[Parameter]) -> dict[str, Value]:
        """Return what the name of a parameter stands for; nothing if it is a variable."""
        if isinstance(value, Number) and self.sites[name] > 1:
            return {name: Number(c_name(next(left).name), value.kind)}
        if self.sites[name] > 1 and not isinstance(value, (Array, tuple)):
            self.scope.assign(name, number(value))
            return {}
        return {name: _argument(value, left)}

    def _result(self) -> Any:
        if not self.returned:
            return None
        several = [one for one in self.returned if isinstance(one, tuple)]
        if several:
            return tuple(joined({one[i] for one in several}) for i in range(len(several[0])))
        return joined(self.returned)

    def _block(self, statements: list[ast.stmt]) -> bool:
        """Translate statements in order; return whether they always leave the block."""
        for statement in statements:
            translate = getattr(self, f"_{type(statement).__name__.lower()}", None)
            try:
                if translate is None:
                    raise NotTranslated(f"{type(statement).__name__} is not translated")
                if translate(statement):
                    return True
            except NotTranslated as error:
                raise self._placed(error, statement) from None
        return False

    def _placed(self, error: NotTranslated, statement: ast.stmt) -> NotTranslated:
        """Return an error with the function and the line in which it arose, unless it has one."""
        if " of " in str(error) and "line " in str(error):
            return error
        where = f"line {self.line + statement.lineno} of {self.function.__name__} ({self.file})"
        return type(error)(f"{where}: {error}")

    def _expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant):
            return
        value = self.of.value(node.value)
        if isinstance(value, (Nothing, Several)):
            self.scope.emit(f"{value.text};")
        elif isinstance(value, Number):
            self.scope.emit(f"(void){value.within(1)};" if value.kind != "bool" else f"{value.text};")

    def _pass(self, _: ast.Pass) -> None:
        """Do nothing."""

    def _return(self, node: ast.Return) -> bool:
        value = None if node.value is None else self.of.value(node.value)
        self.results.append(value)
        if value is None:
            self.scope.emit("return;")
        elif isinstance(value, Several):
            self.returned.add(value.kinds)
            self.scope.emit(f"return {value.text};")
        elif isinstance(value, tuple):
            kinds = tuple(kind_of(one) for one in value)
            self.returned.add(kinds)
            texts = ", ".join(number(one).text for one in value)
            self.scope.emit(f"return (\0r{self.unit.result(kinds)}\0){{{texts}}};")
        elif isinstance(value, Nothing):
            self.scope.emit(f"{value.text};")
            self.scope.emit("return;")
        else:
            self.returned.add(kind_of(value))
            self.scope.emit(f"return {number(value).text};")
        return True

    def _raise(self, _: ast.Raise) -> bool:
        """Note in the program's memory that a kernel has given up; its step then says so."""
        if any(
            isinstance(one, ast.Return) and isinstance(one.value, ast.Tuple) for one in ast.walk(self.tree)
        ):
            raise NotTranslated("an error is raised in a kernel that returns several numbers")
        broken = self.unit.wrapped(self.unit.broken)
        broken.storage.write()
        self.scope.emit(f"{arithmetic.element(broken, (0,)).text} = 1;")
        returns = any(isinstance(one, ast.Return) and one.value is not None for one in ast.walk(self.tree))
        self.scope.emit("return 0;" if returns else "return;")
        return True

    def _if(self, node: ast.If) -> bool:
        test = self.of.value(node.test)
        if not isinstance(test, Number):
            return self._block(node.body if test else node.orelse)
        with self.scope.inside(f"if ({test.text})") as taken:
            leaves = self._block(node.body)
        if not node.orelse:
            self._drop_empty(taken)
            return False
        with self.scope.inside("else") as other:
            leaves_too = self._block(node.orelse)
        self._drop_empty(other)
        return leaves and leaves_too

    def _drop_empty(self, block: Any) -> None:
        if not block.items and block.head == "else":
            self.scope.block.items.remove(block)

    def _while(self, node: ast.While) -> bool:
        test = self.of.value(node.test)
        if not isinstance(test, Number) and not test:
            return False
        with self.scope.inside(f"while ({number(test).text})"):
            self._block(node.body)
        return not isinstance(test, Number) and not breaks(node)

    def _break(self, _: ast.Break) -> bool:
        self.scope.emit("break;")
        return True

    def _continue(self, _: ast.Continue) -> bool:
        self.scope.emit("continue;")
        return True

    def _for(self, node: ast.For) -> bool:
        iterated = self._iterated(node.iter)
        if isinstance(iterated, _Range):
            self._for_range(node, iterated)
        elif isinstance(iterated, Array):
            self._for_entries(node, iterated)
        elif isinstance(iterated, tuple):
            self._unrolled(node, list(iterated))
        else:
            raise NotTranslated("a loop over something that is no range, array or tuple")
        return False

    def _iterated(self, node: ast.expr) -> Value:
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "range":
            bounds = [self.of.value(one) for one in node.args]
            first, last, step = (
                (0, *bounds, 1) if len(bounds) == 1 else (*bounds, 1) if len(bounds) == 2 else bounds
            )
            return _Range(first, last, step)
        return self.of.value(node)

    def _for_range(self, node: ast.For, over: "_Range") -> None:
        rounds = over.known
        if rounds is not None and len(rounds) == 0:
            return
        mark, here = self.scope.mark(), dict(self.of.here)
        try:
            self._counted(node, over)
        except SizeUnknown:
            if rounds is None or len(rounds) > UNROLLED:
                raise
            self.scope.back_to(mark)
            self.of.here = here
            self._unrolled(node, list(rounds))

    def _counted(self, node: ast.For, over: "_Range") -> None:
        """Write a loop that counts."""
        if not isinstance(node.target, ast.Name) or not isinstance(over.step, int):
            raise NotTranslated("a loop over a range with an unknown step")
        if isinstance(over.last, Number):
            last = self.of.temporary()
            self.scope.assign(last, over.last)
            self.scope.load(last)
            over = _Range(over.first, Number(c_name(last), "int"), over.step)
        name = c_name(node.target.id)
        if any(stores(one, node.target.id) for one in node.body):
            raise NotTranslated(f"{name} counts a loop and is assigned in it")
        first, last_text = number(over.first), number(over.last).within(3)
        order = "<" if over.step > 0 else ">"
        step = {1: f"{name}++", -1: f"{name}--"}.get(over.step, f"{name} += {over.step}")
        outer = self.of.here.get(node.target.id)
        with self.scope.inside(f"for (int {name} = {first.text}; {name} {order} {last_text}; {step})"):
            self.of.here[node.target.id] = Number(name, "int", natural=first.natural and over.step > 0)
            self._block(node.body)
        self._forget(node.target.id, outer)

    def _forget(self, name: str, outer: Value) -> None:
        if outer is None:
            self.of.here.pop(name, None)
        else:
            self.of.here[name] = outer

    def _for_entries(self, node: ast.For, array: Array) -> None:
        """Write a loop over the entries of an array."""
        if not isinstance(node.target, ast.Name) or len(array.shape) != 1:
            raise NotTranslated("a loop over the rows of an array")
        if array.size == 0:
            return
        place = self.of.temporary()
        with self.scope.inside(f"for (int {place} = 0; {place} < {array.size}; {place}++)"):
            at = (Number(place, "int", natural=True),)
            self.scope.assign(node.target.id, arithmetic.element(array, at))
            self._block(node.body)

    def _unrolled(self, node: ast.For, rounds: list[Value]) -> None:
        """Write the rounds of a loop one after the other."""
        if breaks(node):
            raise NotTranslated("a loop that is written out is left in between")
        for one in rounds:
            with self.scope.inside(""):
                self.assigning.bind(node.target, one, sole=True)
                self._block(node.body)

    def _assign(self, node: ast.Assign) -> None:
        self.assigning.assign(node)

    def _annassign(self, node: ast.AnnAssign) -> None:
        self.assigning.annotated(node)

    def _augassign(self, node: ast.AugAssign) -> None:
        self.assigning.augmented(node)


def _argument(value: Value, left: Iterator[Parameter]) -> Value:
    """Return an argument with its parts that are not known replaced by the next parameters."""
    if isinstance(value, tuple):
        kind = type(value)
        found = [_argument(one, left) for one in value]
        return kind(*found) if hasattr(kind, "_fields") else tuple(found)
    if isinstance(value, Number):
        parameter = next(left)
        return Number(c_name(parameter.name), parameter.kind, natural=value.natural)
    if isinstance(value, Array):
        parameter = next(left)
        return Array(
            c_name(parameter.name), parameter.storage or value.storage, 0, value.shape, value.strides
        )
    return value


@dataclass(frozen=True)
class _Range:
    first: Value
    last: Value
    step: Value

    @property
    def known(self) -> range | None:
        """Return the range, if it is known."""
        bounds = (self.first, self.last, self.step)
        return range(*bounds) if known(bounds) else None


def _same(before: dict[str, Any], after: dict[str, Any]) -> bool:
    """Return whether two passes found the same about all variables."""
    return before.keys() == after.keys() and all(
        (one.kinds, one.home, one.assigned, one.loaded > 0, one.size)
        == (other.kinds, other.home, other.assigned, other.loaded > 0, other.size)
        for one, other in ((before[name], after[name]) for name in before)
    )
