"""The pages of the API reference, in Markdown, made from the source without importing it.

    python tools/api_pages.py TABLE SOURCE FOLDER      (docs/conf.py calls `write_api_pages`)

Our docstrings are Markdown, and fields state shape and unit in the comment at the end of their line: what
reads the source can show both, and shows kernels that numba has compiled as the functions that they are.
A page per package or module of the table lists the names of its `__all__`, in that order, or else every
public class and function that it defines.
"""

import ast
import re
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

_ROW = re.compile(r"^\| \[(otolith[\w.]*)\]", re.MULTILINE)
_SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)
_LISTED = ("Parameters", "Raises", "Returns", "Attributes")  # sections that are lists of `name : text`
Definition = ast.ClassDef | ast.FunctionDef | ast.Assign | ast.AnnAssign


@dataclass(frozen=True)
class Module:
    """A parsed source file: its full name, whether it is a package, its text and its tree."""

    name: str
    package: bool
    text: str
    tree: ast.Module


@dataclass(frozen=True)
class Found:
    """Where a public name is defined, and by which statement."""

    module: Module
    node: Definition


def write_api_pages(table: Path, source: Path, folder: Path) -> None:
    """Write a page for each package of the table, and remove pages that it no longer names.

    Raises
    ------
    KeyError : a package of the table, or a name of its `__all__`, is not in the source.
    """
    pages = {f"{name}.md": page(name, source) for name in _ROW.findall(table.read_text(encoding="utf-8"))}
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.md"):
        if old.name not in pages:
            old.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:  # Sphinx reads again what is new
            path.write_text(text, encoding="utf-8")


def page(name: str, source: Path) -> str:
    """Return the page of one package or module."""
    module = read(name, source)
    parts = [f"# {name}", prose(ast.get_docstring(module.tree) or "")]
    for public in public_names(module):
        found = find(module, public, source)
        parts += entry(public, found)
    return "\n\n".join(part for part in parts if part) + "\n"


def read(name: str, source: Path) -> Module:
    """Parse a package or module by its full name."""
    path = source / name.replace(".", "/")
    package = path.is_dir()
    file = path / "__init__.py" if package else path.with_suffix(".py")
    if not file.is_file():
        raise KeyError(f"there is no module {name} in {source}")
    text = file.read_text(encoding="utf-8")
    return Module(name, package, text, ast.parse(text))


def public_names(module: Module) -> list[str]:
    """Return the names of `__all__`, or else those of all public classes and functions of the module."""
    for node in module.tree.body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return [str(name) for name in ast.literal_eval(node.value)]
    made = (node for node in module.tree.body if isinstance(node, ast.ClassDef | ast.FunctionDef))
    return [node.name for node in made if not node.name.startswith("_")]


def find(module: Module, name: str, source: Path) -> Found | Module:
    """Return where a name of a module is defined, following imports; a module if the name is one."""
    for node in statements(module.tree.body):
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and node.name == name:
            return Found(module, node)
        if isinstance(node, ast.Assign | ast.AnnAssign) and name in assigned(node):
            return Found(module, node)
        if isinstance(node, ast.ImportFrom) and node.module not in (None, module.name):
            for alias in node.names:
                if (alias.asname or alias.name) == name:
                    return find(read(str(node.module), source), alias.name, source)
    return read(f"{module.name}.{name}", source)


def statements(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Yield the statements of a module, also those below `if TYPE_CHECKING:`."""
    for node in body:
        yield node
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            yield from node.body


def assigned(node: ast.Assign | ast.AnnAssign) -> list[str]:
    """Return the names that a statement assigns to."""
    targets = node.targets if isinstance(node, ast.Assign) else [node.target]
    return [ast.unparse(target) for target in targets]


def entry(name: str, found: Found | Module) -> list[str]:
    """Return the parts of a page that document one name."""
    if isinstance(found, Module):
        return [f"## {name}", prose(ast.get_docstring(found.tree) or ""), f"Module `{found.name}`."]
    node, module = found.node, found.module
    if isinstance(node, ast.FunctionDef):
        return [f"## {name}", signature(node), prose(ast.get_docstring(node) or "")]
    if isinstance(node, ast.ClassDef):
        return [f"## {name}", *of_class(node, module)]
    return [f"## {name}", code(ast.unparse(node)), remark(node, module)]


def of_class(node: ast.ClassDef, module: Module) -> list[str]:
    """Return a class's line, docstring, fields and public methods."""
    bases = f"({', '.join(ast.unparse(base) for base in node.bases)})" if node.bases else ""
    methods = [one for one in node.body if isinstance(one, ast.FunctionDef)]
    parts = [code(f"class {node.name}{bases}"), prose(ast.get_docstring(node) or "")]
    parts += [signature(one, node.name) for one in methods if one.name == "__init__"]
    parts.append(fields(node, module))
    for one in methods:
        if one.name.startswith("_"):
            continue
        marks = {ast.unparse(mark) for mark in one.decorator_list}
        if "property" in marks:
            kept = f"{node.name}.{one.name}: {ast.unparse(one.returns) if one.returns else 'Any'}"
            parts += [code(kept), prose(ast.get_docstring(one) or "")]
        else:
            parts += [signature(one, node.name), prose(ast.get_docstring(one) or "")]
    return parts


def fields(node: ast.ClassDef, module: Module) -> str:
    """Return a table of a class's public fields with the comments that give shape, unit and meaning."""
    rows = []
    for one in node.body:
        if not isinstance(one, ast.Assign | ast.AnnAssign) or assigned(one)[0].startswith("_"):
            continue
        kind = annotation(one.annotation) if isinstance(one, ast.AnnAssign) else ""
        value = "" if one.value is None else shown_default(one.value)
        rows.append([inline(assigned(one)[0]), inline(kind), inline(value), remark(one, module)])
    if not rows:
        return ""
    kept = [k for k in range(4) if any(row[k] for row in rows)]
    head = ("name", "type", "default", "meaning")
    lines = [[head[k] for k in kept], ["---"] * len(kept), *([row[k] for k in kept] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def annotation(kind: ast.expr) -> str:
    """Return a type; one that is written as text, since it is defined later, without its quotes."""
    return kind.value if isinstance(kind, ast.Constant) and isinstance(kind.value, str) else ast.unparse(kind)


def shown_default(value: ast.expr) -> str:
    """Return a field's default as a reader would write it."""
    if isinstance(value, ast.Call) and ast.unparse(value.func) in ("field", "Field"):
        for word in value.keywords:
            if word.arg == "default":
                return ast.unparse(word.value)
            if word.arg == "default_factory":
                made = ast.unparse(word.value)
                return made.removeprefix("lambda: ") if made.startswith("lambda: ") else f"{made}()"
        return ""
    return ast.unparse(value)


def remark(node: Definition, module: Module) -> str:
    """Return the comment at the end of a statement, or in the lines above it, as text of a table's cell."""
    lines = module.text.splitlines()
    last = lines[(node.end_lineno or node.lineno) - 1][node.end_col_offset :]  # byte offset: fields are ASCII
    found = re.search(r"#\s*(.*)$", last)
    if found:
        return cell(found[1])
    above: list[str] = []
    for line in reversed(lines[: node.lineno - 1]):
        if not line.strip().startswith("# "):
            break
        above.insert(0, line.strip()[2:])
    return cell(" ".join(above))


def signature(node: ast.FunctionDef, owner: str = "") -> str:
    """Return a function's line as code; a long one has one argument per line."""
    given = ast.unparse(node.args)
    if owner:
        given = re.sub(r"^(self|cls)(, |$)", "", given)
    name = owner if node.name == "__init__" else f"{owner}.{node.name}" if owner else node.name
    result = "" if node.returns is None or node.name == "__init__" else f" -> {ast.unparse(node.returns)}"
    line = f"{name}({given}){result}"
    if len(line) > 88:
        each = ",\n".join(f"    {one}" for one in split_arguments(given))
        line = f"{name}(\n{each},\n){result}"
    return code(line)


def split_arguments(text: str) -> list[str]:
    """Split a list of arguments at the commas that are not inside brackets."""
    parts, depth, begun = [], 0, 0
    for k, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            parts.append(text[begun:k].strip())
            begun = k + 1
    return [*parts, text[begun:].strip()]


def prose(docstring: str) -> str:
    """Return a docstring as Markdown: its sections become bold lines, what they list becomes a list."""
    pieces = _SECTION.split(docstring)
    parts = [escaped(pieces[0].strip())]
    for title, body in zip(pieces[1::2], pieces[2::2], strict=True):
        parts.append(f"**{title}**")
        if title in _LISTED:
            parts.append(listed(body))
        elif ">>>" in body:
            parts.append(code(body.strip(), "pycon"))
        else:
            parts.append(escaped(body.strip()))
    return "\n\n".join(part for part in parts if part)


def listed(body: str) -> str:
    """Return the lines `name : text`, the text going on in indented lines, as a list."""
    items: list[str] = []
    for line in textwrap.dedent(body).strip().splitlines():
        if items and (line.startswith(" ") or not line):
            items[-1] += " " + line.strip()
        else:
            items.append(line.strip())
    pairs = (item.partition(" : ") for item in items)
    return "\n".join(
        f"- {inline(name)}: {escaped(text)}" if colon else f"- {escaped(name)}" for name, colon, text in pairs
    )


def escaped(text: str) -> str:
    """Keep Markdown from reading letters of formulas as marks, outside of code."""
    pieces = re.split(r"(`[^`]*`)", text)
    marks = re.compile(r"([*_<\[\]#|~])")
    return "".join(piece if k % 2 else marks.sub(r"\\\1", piece) for k, piece in enumerate(pieces))


def cell(text: str) -> str:
    """Return a comment as text of a table's cell, without orders to the tools that check the source."""
    return escaped(re.split(r"\s*#?\s*(?:noqa|type:)", text)[0].strip())


def inline(text: str) -> str:
    """Return text as code within a line, also in a table."""
    return f"`{text.replace('|', chr(92) + '|')}`" if text else ""


def code(text: str, language: str = "python") -> str:
    """Return text as a block of code."""
    return f"```{language}\n{text}\n```"


if __name__ == "__main__":
    write_api_pages(*map(Path, sys.argv[1:]))
