"""Run the cells of a notebook as a notebook does, and print how many of them showed a table or a figure.

python tests/run_notebook.py NOTEBOOK
"""

import ast
import json
import sys
from pathlib import Path
from typing import Any


def code(notebook: Path) -> list[str]:
    """The source of each cell of code, without the lines that only a notebook understands."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    sources = (one["source"] for one in cells if one["cell_type"] == "code")
    return ["".join(line for line in lines if not line.startswith("%")) for lines in sources]


def shows(source: str, names: dict[str, Any]) -> bool:
    """Run a cell; whether its last line is a value with a table or a figure, which is drawn."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "<cell>", "exec"), names)
    if not isinstance(last, ast.Expr):
        return False
    value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
    if hasattr(value, "savefig"):
        value.savefig("picture.png")
        return Path("picture.png").stat().st_size > 5_000
    return hasattr(value, "_repr_html_") and "<table" in value._repr_html_()


if __name__ == "__main__":
    shared: dict[str, Any] = {"__name__": "__main__"}
    shown = sum(shows(source, shared) for source in code(Path(sys.argv[1])))
    sys.stdout.write(f"{shown}\n")
