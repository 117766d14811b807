"""Every command of the docs, run in order, page by page, each page in an empty folder of its own.

    python benchmarks/docs_lines.py [--all] [PAGE ...]

Blocks marked `sh` run line by line, blocks marked `python` as one program, as a reader would try them from
the repository: `benchmarks/` is there, and whatever the page itself has made so far. Prints a line per
command with its exit code and seconds, and the end of a failed one's output; exits with 1 if one failed or
showed a traceback. What takes minutes is left out unless `--all` is given; what would install, or needs a
file of the reader's own, always is: `LEFT_OUT` says why.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    "thesis/README.md",
    *sorted(
        p.relative_to(ROOT).as_posix() for p in [*ROOT.glob("docs/*.md"), *ROOT.glob("docs/tutorials/*.md")]
    ),
)
PROGRAMS = ("otolith ", "python ", "make ", "pip ", "pre-commit ", ". ")
LEFT_OUT = {  # beginning of a line: why it is never run
    "make ": "installs, or is what CI runs",
    "pip ": "installs from the network",
    "pre-commit ": "changes the repository",
    ". .venv": "the caller's environment is used",
    "otolith run --log drive.csv": "a drive of the reader's own",
    "otolith log check drive.csv": "a drive of the reader's own",
    "otolith run --log lap.erg": "a drive of the reader's own",
    "otolith export fmu --cueing classical --compiler": "a cross compiler of the reader's own",
    "otolith live record": "a game of the reader's own",
    "otolith live learn --log minute.otc": "what that game sent",
}
MINUTES = {  # beginning of a line: why it runs with --all only
    "otolith reproduce all": "all tables and laps of the thesis",
    "otolith hint build": "records and learns",
    "python benchmarks/": "every algorithm on every plant and platform",
}


@dataclass(frozen=True)
class Ended:
    """How one command ended."""

    code: int
    seconds: float
    output: str

    @property
    def failed(self) -> bool:
        return self.code != 0 or "Traceback (most recent call last)" in self.output


def commands(page: str) -> Iterator[list[str]]:
    """Commands of a page as argument lists: of `sh` blocks one per line, of `python` blocks one each."""
    for language, body in re.findall(r"^```(\w*)\n(.*?)^```$", (ROOT / page).read_text(), re.M | re.S):
        if language == "python":
            yield [sys.executable, "-W", "error", "-c", body]
        elif language == "sh":
            lines = body.replace("\\\n", " ").splitlines()
            yield from (["bash", "-c", line] for line in lines if line.split("#")[0].strip())
        elif body.startswith(PROGRAMS):
            raise SystemExit(f"{page}: a block of commands is not marked as `sh`: {body.splitlines()[0]}")


def reason(line: str, table: dict[str, str]) -> str:
    """Why a line is left out by this table; empty where it is not."""
    return next((why for start, why in table.items() if line.startswith(start)), "")


def run(command: list[str], folder: Path) -> Ended:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    began = time.monotonic()
    done = subprocess.run(  # noqa: S603 (the docs are our own)
        command,
        cwd=folder,
        env={**os.environ, "PATH": path},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    return Ended(done.returncode, time.monotonic() - began, done.stdout)


def try_page(page: str, *, everything: bool) -> int:
    """Run a page's commands and return how many failed."""
    failures = 0
    with tempfile.TemporaryDirectory(prefix="otolith-docs-") as name:
        folder = Path(name)
        (folder / "benchmarks").symlink_to(ROOT / "benchmarks")
        for command in commands(page):
            words = " ".join(command[-1].split("#")[0].split()) if command[0] == "bash" else "python block"
            why = reason(words, LEFT_OUT) or ("" if everything else reason(words, MINUTES))
            if why:
                print(f"  left out  {words}  ({why})", flush=True)
                continue
            ended = run(command, folder)
            failures += ended.failed
            print(f"  {ended.code:3d} {ended.seconds:6.1f} s  {words}", flush=True)
            if ended.failed:
                print("\n".join(f"      | {line}" for line in ended.output.splitlines()[-12:]), flush=True)
    return failures


def main() -> None:
    parser = argparse.ArgumentParser(description="Run every command of the docs.")
    parser.add_argument("pages", nargs="*", default=PAGES, metavar="PAGE")
    parser.add_argument("--all", action="store_true", help="also what takes minutes")
    given = parser.parse_args()
    failures = 0
    for page in given.pages:
        print(page, flush=True)
        failures += try_page(page, everything=given.all)
    print(f"{failures} failed" if failures else "all ran")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
