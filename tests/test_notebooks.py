"""The notebooks of the docs run from top to bottom without a warning, and are kept without outputs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / "docs" / "notebooks").glob("*.ipynb"))


def cells(notebook: Path, kind: str) -> list[dict[str, object]]:
    return [
        one for one in json.loads(notebook.read_text(encoding="utf-8"))["cells"] if one["cell_type"] == kind
    ]


def test_there_are_notebooks() -> None:
    assert len(NOTEBOOKS) >= 3


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_no_output_is_kept(notebook: Path) -> None:
    """Pictures made by an older version would look like those of this one; the site draws them anew."""
    for cell in cells(notebook, "code"):
        assert cell["outputs"] == []
        assert cell["execution_count"] is None


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_cells_run_and_show_their_last_value(notebook: Path, tmp_path: Path) -> None:
    """As a notebook does: every cell in turn, and the last expression of each is shown."""
    done = subprocess.run(
        [sys.executable, "-W", "error", str(Path(__file__).with_name("run_notebook.py")), str(notebook)],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "agg"},
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout.split()[-1]) >= 2
