"""The table of speed: this version beside another one, all figures measured in one run.

    git worktree add /tmp/before 6f24dd5
    python benchmarks/speed.py /tmp/before [--only WORDS] [--json FILE]

Every script below runs both versions in turns, in processes of their own; what a figure means is said at its
head. The whole takes half an hour on two cores. Run it once on an idle machine and once on a busy one:
ratios change less than times do.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

from rows import Row, as_lines, read_rows, write_rows

HERE: Final = Path(__file__).parent
SCRIPTS: Final = {
    "two_cores.py": None,  # one version on one core and on two; its wall times want the machine to itself
    "start_up.py": "",
    "loop_speed.py": "src",
    "solver_speed.py": "src",
    "explicit_speed.py": "src",
    "memory.py": "src",
}  # and what each takes of the other checkout: nothing, or a folder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=Path, help="Folder of the other checkout.")
    parser.add_argument("--only", default="", help="Scripts whose names contain these words.")
    parser.add_argument("--json", type=Path, help="File for all rows.")
    given = parser.parse_args()
    rows: list[Row] = []
    for script, folder in SCRIPTS.items():
        if given.only in script:
            rows += rows_of(script, [] if folder is None else [str(given.before.resolve() / folder)])
    print("\n".join(as_lines(rows)))
    if given.json:
        write_rows(given.json, rows)


def rows_of(script: str, before: list[str]) -> list[Row]:
    """Run a script, show what it prints, and return its rows."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rows.json"
        print(script, *before, flush=True)
        line = [sys.executable, str(HERE / script), *before, "--json", str(path)]
        subprocess.run(line, check=True)  # noqa: S603 (a script beside this one)
        return read_rows(path)


if __name__ == "__main__":
    main()
