"""Compile what a first start needs, and pack it as `src/otolith/kernels.zip`; see `otolith.core.shipped`.

    python tools/ship_kernels.py [ARCHIVE]

The commands below are run for each kind of processor with empty caches: once to compile, once to see that
nothing is missing. Only what the second pass takes from the archive is packed: the functions that are called
from Python, since their machine code holds that of all others. A wheel that is built afterwards
(`pip wheel .`) holds the archive, and fits this Python, this numba and this system only.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Final

from otolith.core import shipped
from source_digest import source_digest

COMMANDS: Final = (
    ("run", "sine-1"),
    ("run", "step-sine-0.5", "--cueing", "hybrid-all"),  # `make demo`
)
KINDS: Final = (shipped.AVX2, shipped.ANY)
_COMPILE: Final = """
import sys
from pathlib import Path
from otolith.core import shipped
from otolith.cli import main
folder = Path(sys.argv[1])
shipped.ARCHIVE = folder / "none"
shipped.on_compiled = lambda name, code: (folder / name).write_bytes(code)
main(sys.argv[2:])
"""
_TAKE: Final = """
import sys
from pathlib import Path
from otolith.core import shipped
from otolith.cli import main
folder = Path(sys.argv[1])
compiled = []
shipped.ARCHIVE = folder / "all.zip"
shipped.kind = lambda: "all"
shipped.on_compiled = lambda name, code: compiled.append(name)
try:
    main(sys.argv[2:])
except SystemExit as end:
    if end.code:
        raise
(folder / "taken").write_text("\\n".join(shipped.taken))
if compiled:
    sys.exit(f"{len(compiled)} functions were compiled although the archive should hold them")
"""


def main() -> None:
    """Make the archive and say what it holds."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("archive", type=Path, nargs="?", default=shipped.ARCHIVE)
    path = parser.parse_args().archive
    able = KINDS if shipped.kind() == shipped.AVX2 else (shipped.ANY,)
    packed = {kind: code_for(kind) for kind in able}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        source = source_digest(shipped.ARCHIVE.parent)
        archive.writestr(shipped.MADE_FOR, json.dumps({**shipped.environment(), "source": source}, indent=2))
        for kind, codes in packed.items():
            for name, code in sorted(codes.items()):
                archive.writestr(f"{kind}/{name}", code)
    held = ", ".join(f"{len(codes)} functions for {kind}" for kind, codes in packed.items())
    print(f"{path}: {held}, {path.stat().st_size / 1e6:.2f} MB")


def code_for(kind: str) -> dict[str, bytes]:
    """Machine code by name of all functions that the commands call from Python."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for command in COMMANDS:
            run(_COMPILE, command, kind, folder, caches="first")
        compiled = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
        with zipfile.ZipFile(folder / "all.zip", "w") as archive:
            archive.writestr(shipped.MADE_FOR, json.dumps(shipped.environment()))
            for name, code in compiled.items():
                archive.writestr(f"all/{name}", code)
        taken: set[str] = set()
        for command in COMMANDS:
            run(_TAKE, command, kind, folder, caches="second")
            taken |= set((folder / "taken").read_text().split())
        return {name: compiled[name] for name in taken}


def run(program: str, command: tuple[str, ...], kind: str, folder: Path, *, caches: str) -> None:
    """Run a command in a process that compiles for one kind of processor, with caches of its own."""
    print(f"{kind}: {' '.join(command)}", file=sys.stderr)
    environment = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(folder / caches),
        "OTOLITH_CACHE": str(folder / "text"),
        "NUMBA_CPU_NAME": kind,
        "NUMBA_CPU_FEATURES": "",  # or this machine's own would be used with any name
        "NUMBA_DISABLE_INTEL_SVML": "1",  # a library that is not everywhere
    }
    line = [sys.executable, "-c", program, str(folder), *command, "--out", str(folder / "out"), "--force"]
    subprocess.run(line, env=environment, check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
