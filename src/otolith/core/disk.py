"""Files on disk: read within bounds, and written whole or not at all.

A file is written next to its place under a temporary name, forced to the disk, and renamed into its place.
A program that is killed can leave such a temporary file; the next write to the same folder removes it.
"""

import contextlib
import mmap
import os
import platform
import re
import shutil
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

from otolith.core.errors import InputError, OtolithError

SETTINGS_BYTES: Final = 1_000_000  # largest settings file (TOML) that is read [bytes]
TABLE_BYTES: Final = 50_000_000  # largest table of points (a road, a curve) that is read [bytes]
_HOST: Final = re.sub(r"\W+", "", platform.node())[:20] or "host"
_PART: Final = re.compile(r"\..+\.part-(\w+)-(\d+)-\w+(\.\w+)?")
_ABANDONED: Final = 86_400.0  # [s] age at which another machine's temporary file counts as left behind


class NotWritten(OtolithError):
    """A file or folder could not be written. The message gives the reason; nothing half-written is left."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path} could not be written: {reason}; nothing half-written was left")
        self.path, self.reason = path, reason


def read_bytes(path: Path, what: str, *, most: int = SETTINGS_BYTES) -> bytes:
    """Read a file that the user named.

    Parameters
    ----------
    what : what the file should be; the error message begins with it.
    most : largest size that is accepted [bytes]; a larger file is refused without being read further.

    Raises
    ------
    InputError : the file cannot be read, or is larger than `most`.
    """
    try:
        with path.open("rb") as file:
            data = file.read(most + 1)
    except OSError as error:
        raise InputError(f"{what} {path}", f"not readable ({error.strerror})", "a readable file") from error
    if len(data) > most:
        raise InputError(f"size of {what} {path}", f"more than {most:,} bytes", f"at most {most:,} bytes")
    return data


@contextlib.contextmanager
def mapped(path: Path, what: str) -> Iterator[mmap.mmap | bytes]:
    """Yield the bytes of a file that may be larger than memory; one that grows is read as far as it is now.

    Parameters
    ----------
    what : what the file should be; the error message begins with it.

    Raises
    ------
    InputError : the file cannot be read.
    """
    try:
        with path.open("rb") as file:
            if os.fstat(file.fileno()).st_size == 0:  # which cannot be mapped
                yield b""
                return
            content = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except OSError as error:
        raise InputError(f"{what} {path}", f"not readable ({error.strerror})", "a readable file") from error
    with content:
        yield content


def read_text(path: Path, what: str, *, most: int = SETTINGS_BYTES) -> str:
    """Read a UTF-8 text file that the user named. Arguments and errors are those of `read_bytes`."""
    try:
        return read_bytes(path, what, most=most).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{what} {path}", f"not UTF-8 at byte {error.start}", "a UTF-8 text file") from error


def check_lines(lines: Iterable[str], source: str, *, most: int) -> None:
    """Refuse text with an overlong line before a parser spends memory and hours on it.

    Parameters
    ----------
    source : the file's name, for the error message.
    most : largest number of characters in a line.

    Raises
    ------
    InputError : a line is longer than `most` characters.
    """
    for number, line in enumerate(lines, start=1):
        if len(line) > most:
            where = f"length of line {number} of {source}"
            raise InputError(where, f"{len(line):,} characters", f"at most {most:,} characters")


@contextlib.contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yield a temporary path to write to. It is renamed to `path` on success and removed on any failure.

    Raises
    ------
    NotWritten : the path is a device, a pipe or a socket, the folder is not writable, the disk is full, or
        writing failed in another way.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):  # renaming would put a file in its place
        raise NotWritten(path, "it is a device, a pipe or a socket")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        sweep(path.parent)
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=part_prefix(path), suffix=path.suffix)
    except OSError as error:
        raise NotWritten(path, error.strerror or str(error)) from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o644)  # mkstemp makes the file readable by its owner only
        _force_to_disk(temporary)
        temporary.replace(path)
    except OSError as error:
        raise NotWritten(path, error.strerror or str(error)) from error
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file completely or not at all; raises `NotWritten` as `whole` does."""
    with whole(path) as temporary:
        temporary.write_bytes(data)


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file completely or not at all; raises `NotWritten` as `whole` does."""
    write_bytes(path, text.encode())


def sweep(folder: Path) -> None:
    """Remove from `folder` the temporary files and folders of programs that were killed."""
    for entry in folder.iterdir():
        made = _PART.fullmatch(entry.name)
        if made is None or _in_use(entry, host=made.group(1), process=int(made.group(2))):
            continue
        if entry.is_dir():
            shutil.rmtree(entry, ignore_errors=True)
        else:
            entry.unlink(missing_ok=True)


def part_prefix(path: Path) -> str:
    """Prefix of a temporary file's name: the file it will become, this machine and this process."""
    return f".{path.name}.part-{_HOST}-{os.getpid()}-"


def _in_use(entry: Path, *, host: str, process: int) -> bool:
    """True when the process that made a temporary file may still be writing it."""
    if host == _HOST and os.name == "posix":
        return _is_alive(process)
    with contextlib.suppress(FileNotFoundError):
        return time.time() - entry.stat().st_mtime < _ABANDONED
    return False


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)  # signal 0 only asks whether the process exists
    except ProcessLookupError:
        return False
    except PermissionError:
        return True  # it exists and belongs to someone else
    return True


def _force_to_disk(path: Path) -> None:
    """Wait until the content is on the disk. Without this a power cut could leave a renamed but empty
    file.
    """
    with path.open("rb") as file:
        os.fsync(file.fileno())
