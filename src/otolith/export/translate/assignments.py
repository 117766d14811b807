"""Assignments of a kernel: to variables, to local arrays and into arrays."""

import ast
from collections import Counter
from typing import Any, Final

import numpy as np

from otolith.export.translate import arithmetic
from otolith.export.translate.expressions import MAKERS, Expressions
from otolith.export.translate.scope import Scope, c_name
from otolith.export.translate.values import (
    Array,
    Choice,
    Elementwise,
    NotTranslated,
    Number,
    Several,
    Value,
    number,
)

_IN_PLACE: Final[dict[type[ast.operator], str]] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


class Assignments:
    """Translates assignments in the environment of one function.

    Parameters
    ----------
    sites : in how many places of the function each name is assigned. A name that is assigned in one only
        may stand for what is known, or for a view.
    """

    def __init__(self, unit: Any, scope: Scope, of: Expressions, sites: Counter[str]) -> None:
        self.unit, self.scope, self.of, self.sites = unit, scope, of, sites

    def assign(self, node: ast.Assign) -> None:
        """Translate targets = value."""
        if self._made(node):
            return
        value = self.of.value(node.value)
        if len(node.targets) > 1 and isinstance(value, Number):
            value = self.of.kept(value)
        for target in node.targets:
            self.bind(target, value)

    def annotated(self, node: ast.AnnAssign) -> None:
        """Translate target: type = value."""
        if node.value is not None:
            self.assign(ast.Assign(targets=[node.target], value=node.value, lineno=node.lineno))

    def _made(self, node: ast.Assign) -> bool:
        """Make the local arrays of an assignment; return whether its right side makes some."""
        (target, *others), made = node.targets, node.value
        if isinstance(target, ast.Tuple) and isinstance(made, ast.Tuple) and not others:
            if not any(self._is_maker(one) for one in made.elts):
                return False
            for one, value in zip(target.elts, made.elts, strict=True):
                self.assign(ast.Assign(targets=[one], value=value, lineno=node.lineno))
            return True
        if not self._is_maker(made) or not isinstance(target, ast.Name) or not isinstance(made, ast.Call):
            return False
        size = self.of.value(made.args[0])
        self.of.here[target.id] = self.of.made(self.of.value(made.func), size, target.id)
        return True

    def _is_maker(self, node: ast.expr) -> bool:
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            return False
        of = node.func.value
        numpy = isinstance(of, ast.Name) and self.of.outer.get(of.id) is np
        return numpy and getattr(np, node.func.attr) in MAKERS

    def bind(self, target: ast.expr, value: Value, sole: bool = False) -> None:
        """Let a target receive a value."""
        if isinstance(target, ast.Tuple):
            self._spread(target, value, sole)
        elif isinstance(target, ast.Name):
            self._name(target.id, value, sole)
        elif isinstance(target, ast.Subscript):
            self._store(target, value)
        else:
            raise NotTranslated(f"an assignment to {type(target).__name__} is not translated")

    def _name(self, name: str, value: Value, sole: bool) -> None:
        once = sole or self.sites[name] == 1
        if isinstance(value, Choice):
            array = self.scope.point(name, value.text, value.a)
            for one in (value.a, value.b):
                array.storage.point_into(one.storage)
            self.of.here[name] = array
        elif isinstance(value, Elementwise):
            self.of.here[name] = self.of.stored(name, value)
        elif isinstance(value, Array):
            if once and value.stable:
                self.of.here[name] = value
                return
            array = self.scope.point(name, self.of.address(value), value)
            array.storage.point_into(value.storage)
            self.of.here[name] = array
        elif isinstance(value, Number):
            self._assign_number(name, value)
        elif once:
            self.of.here[name] = self.of.as_now(value)
        else:
            self._assign_number(name, number(value))

    def _assign_number(self, name: str, value: Number) -> None:
        if name in self.scope.parameters:
            if name not in self.scope.unread:
                self.scope.targets[name] += 1
                self.scope.emit(f"{c_name(name)} = {value.text};")
            return
        self.of.here.pop(name, None)
        self.scope.assign(name, value)

    def _spread(self, target: ast.Tuple, value: Value, sole: bool) -> None:
        """Assign several values at once: all are computed before the first is assigned."""
        if isinstance(value, Several):
            value = self.of.unpacked(value)
        elif isinstance(value, Array):
            value = self.unit.entries(value)
        if not isinstance(value, tuple) or len(value) != len(target.elts):
            raise NotTranslated("what is spread over several targets has another length")
        kept = [
            self.of.kept(one) if i > 0 and isinstance(one, Number) and _touched(one, target.elts[:i]) else one
            for i, one in enumerate(value)
        ]
        for one, part in zip(target.elts, kept, strict=True):
            self.bind(one, part, sole)

    def _store(self, target: ast.Subscript, value: Value) -> None:
        of = self.of.value(target.value)
        if not isinstance(of, Array):
            raise NotTranslated("an assignment into something that is no array")
        self.of.store(self.of.view(of, target.slice), value)

    def augmented(self, node: ast.AugAssign) -> None:
        """Translate target op= value."""
        if isinstance(node.target, ast.Name):
            value, of = self.of.value(node.value), self.of.here.get(node.target.id)
            if isinstance(of, Array):  # in place, as NumPy does
                self.of.store(of, arithmetic.binary(node.op, of, value))
            elif not self._added_in_place(node.op, node.target.id, value):
                now = self.of.value(ast.Name(id=node.target.id, ctx=ast.Load()))
                self._name(node.target.id, arithmetic.binary(node.op, now, value), sole=False)
            return
        if not isinstance(node.target, ast.Subscript):
            raise NotTranslated("an assignment to an attribute is not translated")
        of = self.of.value(node.target.value)
        view = self.of.view(of, node.target.slice)
        value = self.of.value(node.value)
        view.storage.write()
        if view.shape:
            self.of.store(view, arithmetic.binary(node.op, view, value))
            return
        entry = arithmetic.element(view, ())
        if type(node.op) not in _IN_PLACE:
            self.scope.emit(f"{entry.text} = {number(arithmetic.binary(node.op, entry, value)).text};")
            return
        self.scope.emit(f"{entry.text} {_IN_PLACE[type(node.op)]}= {number(value).text};")

    def _added_in_place(self, op: ast.operator, name: str, by: Value) -> bool:
        """Write x += y where that leaves the kind of x; return whether it is written."""
        if type(op) not in _IN_PLACE or name not in self.scope.found or name in self.of.here:
            return False
        value = number(by)
        kind = self.scope.kind(name)
        divided = kind == "int" and isinstance(op, ast.Div)
        if kind not in ("double", value.kind) or kind == "bool" or divided:
            return False
        of = self.scope.note(name)
        of.assigned += 1
        self.scope.targets[name] += 1
        known_before = self.scope.before.get(name)
        if known_before is not None and known_before.loaded == 0:
            return True
        self.scope.emit(f"{c_name(name)} {_IN_PLACE[type(op)]}= {value.text};")
        return True


def _touched(value: Number, targets: list[ast.expr]) -> bool:
    """Return whether a number may change when targets are assigned before it is."""
    for target in targets:
        if isinstance(target, ast.Name) and c_name(target.id) in value.text:
            return True
        if isinstance(target, ast.Subscript) and ("[" in value.text or "\0" in value.text):
            return True
    return False
