"""One number for all source of the package: an archive of machine code of another source is of no use."""

import hashlib
from pathlib import Path


def source_digest(package: Path) -> str:
    """SHA-256 of the names and contents of all Python files below a folder."""
    total = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        total.update(f"{path.relative_to(package).as_posix()} {len(text)}\n".encode() + text)
    return total.hexdigest()
