"""Every example runs, and says what it should."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent / "examples"
SAID = {
    "01_cue_a_sine.py": "0 limit violations",
    "02_own_platform.py": "home-rig: RMSE",
    "03_explicit_law.py": "3 regions",
    "04_fmu.py": "pose_surge: largest difference from `otolith run`",
}


@pytest.mark.parametrize("example", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.name)
def test_the_example_runs_without_a_warning(example: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(example)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert SAID[example.name] in done.stdout
