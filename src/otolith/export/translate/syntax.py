"""The source text of kernels, and questions about it."""

import ast
import inspect
import textwrap
from collections import Counter
from functools import cache
from typing import Any

from otolith.export.translate.values import NotTranslated


@cache
def source_of(function: Any) -> tuple[ast.FunctionDef, str, int]:
    """Return the syntax tree of a function, its file, and the line before its first."""
    lines, first = inspect.getsourcelines(function)
    tree = ast.parse(textwrap.dedent("".join(lines))).body[0]
    if not isinstance(tree, ast.FunctionDef):
        raise NotTranslated(f"{function.__name__} has no source text")
    return tree, inspect.getsourcefile(function) or "", first - 1


def assignments(tree: ast.FunctionDef) -> Counter[str]:
    """Return in how many places each name is assigned; a parameter counts as one."""
    found = Counter(argument.arg for argument in tree.args.args)
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found[node.id] += 1
    return found


def stores(statement: ast.stmt, name: str) -> bool:
    """Return whether a statement assigns a name, except in a loop of its own that counts with it."""
    counts = isinstance(statement, ast.For) and isinstance(statement.target, ast.Name)
    if counts and statement.target.id == name:  # type: ignore[attr-defined]
        return False
    return any(
        isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Store)
        for node in ast.walk(statement)
    )


def breaks(loop: ast.For | ast.While) -> bool:
    """Return whether a loop is left, or a round cut short, by a statement of its own."""
    waiting: list[ast.AST] = list(loop.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, (ast.Break, ast.Continue)):
            return True
        if not isinstance(node, (ast.For, ast.While)):
            waiting.extend(ast.iter_child_nodes(node))
    return False
