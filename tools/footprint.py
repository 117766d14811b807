"""How much of a disk an installed package and all it needs take, by distribution.

    python tools/footprint.py SITE_PACKAGES

Files are counted as they were installed, without the bytecode that Python adds later.
"""

import sys
from importlib.metadata import distributions
from pathlib import Path

INSTALLERS = ("pip", "setuptools", "wheel")  # part of every environment, not of what was asked for


def footprint(folder: Path) -> dict[str, float]:
    """Return MB by distribution of a folder of installed packages, the largest first."""
    sizes = {}
    for one in distributions(path=[str(folder)]):
        name = one.metadata["Name"]
        files = (
            Path(str(one.locate_file(file))) for file in one.files or [] if "__pycache__" not in file.parts
        )
        if name not in INSTALLERS:
            sizes[name] = sum(file.stat().st_size for file in files if file.is_file()) / 1e6
    return dict(sorted(sizes.items(), key=lambda item: -item[1]))


def table(sizes: dict[str, float]) -> str:
    """Return the sizes as lines of text with shares; those below 1 % are one line."""
    whole = sum(sizes.values())
    shown = {name: size for name, size in sizes.items() if size >= 0.01 * whole}
    lines = [f"{size:7.1f} MB {size / whole:5.0%}  {name}" for name, size in shown.items()]
    rest = whole - sum(shown.values())
    lines.append(f"{rest:7.1f} MB {rest / whole:5.0%}  {len(sizes) - len(shown)} others")
    return "\n".join([*lines, f"{whole:7.1f} MB        in all"])


if __name__ == "__main__":
    print(table(footprint(Path(sys.argv[1]))))
