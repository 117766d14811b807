"""A fingerprint changes with every file that a module takes something from, and with no other."""

from pathlib import Path

import pytest

from otolith.core.sources import fingerprint

FILES = {
    "small/__init__.py": "",
    "small/a.py": "from small.b import double\nfrom small import (\n    tables,\n)\n",
    "small/b.py": "from small.c import FACTOR\n",
    "small/c.py": "FACTOR = 1.0\nimport small.b\n",  # a circle ends
    "small/tables.py": "from .deep import numbers\n",
    "small/deep/__init__.py": "",
    "small/deep/numbers.py": "from ..d import ONE\n",
    "small/d.py": "ONE = 1\n",
    "small/stranger.py": "import small.a\n",
    "other/__init__.py": "",
    "other/e.py": "TWO = 2\n",
}
READ = set(FILES) - {"small/stranger.py", "other/__init__.py", "other/e.py"}


def written(folder: Path, changed: str = "") -> str:
    """Fingerprint of small.a in a fresh copy, in which one file says something else."""
    for name, text in FILES.items():
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text + ("# changed\n" if name == changed else ""))
    return fingerprint(str(folder / "small/a.py"), "small.a")


@pytest.mark.parametrize("changed", sorted(FILES))
def test_the_fingerprint_is_of_all_that_is_imported_and_of_nothing_else(tmp_path: Path, changed: str) -> None:
    before, after = written(tmp_path / "before"), written(tmp_path / "after", changed)
    assert (before != after) == (changed in READ)


def test_what_is_taken_from_otolith_counts_from_any_place(tmp_path: Path) -> None:
    """A generated module in the user's cache is another one when `otolith.core.jit` is."""
    alone, taking = tmp_path / "alone.py", tmp_path / "taking.py"
    alone.write_text("X = 1\n")
    taking.write_text("from otolith.core.jit import kernel\n")
    copy = tmp_path / "copy" / "taking.py"
    copy.parent.mkdir()
    copy.write_text(taking.read_text())
    assert fingerprint(str(taking), "taking") == fingerprint(str(copy), "taking")
    assert len({fingerprint(str(path), path.stem) for path in (alone, taking)}) == 2
