"""The table of speed: this version beside another one, all figures measured in one run.

    git worktree add /tmp/before 6f24dd5
    python benchmarks/speed.py /tmp/before [--only WORDS] [--json FILE]

Every script below runs both versions in turns, in processes of their own; what a figure means is said at its
head. The whole takes about an hour on two cores. Run it once on an idle machine and once on a busy one:
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
    "start_up.py": False,
    "loop_speed.py": True,
    "solver_speed.py": True,
    "explicit_speed.py": True,
    "memory.py": True,
    "two_cores.py": True,
}  # whether a script takes the other version's `src` instead of its folder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("before", type=Path, help="Folder of the other checkout.")
    parser.add_argument("--only", default="", help="Scripts whose names contain these words.")
    parser.add_argument("--json", type=Path, help="File for all rows.")
    given = parser.parse_args()
    rows: list[Row] = []
    for script, of_source in SCRIPTS.items():
        if given.only in script:
            before = given.before.resolve()
            rows += rows_of(script, before / "src" if of_source else before)
    print("\n".join(as_lines(rows)))
    if given.json:
        write_rows(given.json, rows)


def rows_of(script: str, before: Path) -> list[Row]:
    """Run a script beside another version, show what it prints, and return its rows."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rows.json"
        print(f"{script} {before}", flush=True)
        line = [sys.executable, str(HERE / script), str(before), "--json", str(path)]
        subprocess.run(line, check=True)  # noqa: S603 (a script beside this one)
        return read_rows(path)


if __name__ == "__main__":
    main()
