"""Recorded drives on disk: the format of a file is recognised, and the file is read within size limits."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from otolith import registry
from otolith.core.disk import read_bytes
from otolith.core.errors import InputError, damage_reported
from otolith.recordings.blocks import has_blocks, parse_blocks
from otolith.recordings.columns import recognise
from otolith.recordings.erg import parse_erg
from otolith.recordings.jsonlog import looks_like_json, parse_json
from otolith.recordings.recorded import Recorded
from otolith.recordings.table import decode, split

JSON: Final = (".json", ".jsonl", ".ndjson")
OWN: Final = (
    *JSON,
    "",
    ".csv",
    ".txt",
    ".tsv",
    ".asc",
    ".dat",
    ".log",
)  # read as text, whatever is installed
MAX_FILE: Final = 2**30  # [bytes] largest size of a log, 1 GiB
MAX_LINE: Final = 2**20  # [bytes] longest line of a table, 1 MiB
MAX_JSON: Final = 2**26  # [bytes] longest line of JSON, 64 MiB, because it is parsed in memory
CHUNK: Final = 2**20  # [bytes] read at once
_XML: Final = re.compile(r"\s*<(\?xml|!doctype|html|gpx|kml)\b", re.IGNORECASE)


def recorded(
    path: Path, columns: Mapping[str, str], *, header: int | None = None, units: int | None = None
) -> Recorded:
    """Read the columns of a recorded drive; the ending of the name gives the format, by default text.

    Parameters
    ----------
    columns : the user's mapping, so that formats with thousands of channels need not return all of them.
    header, units : lines of names and units in a text, counted from 1, if they are not found automatically.

    Raises
    ------
    InputError : the file is absent, unreadable, too large, or holds no table.
    CorruptFile : the file is damaged, or not of the format that its name states.
    """
    if not path.exists():
        raise InputError(f"log {path}", "absent", "an existing file")
    found = _of_format(path, columns)
    if found is None:
        text, notes = decode(_text(path), path.name)
        if _XML.match(text, 0, 1000):
            track = path.suffix.lower() == ".gpx"
            way = (
                f" (it holds a way and no forces: otolith drive {path} makes a drive of it)" if track else ""
            )
            raise InputError(f"log {path.name}", "XML, such as GPX and HTML are", f"a table or JSON{way}")
        if not (path.suffix.lower() in JSON or looks_like_json(text)):
            if not has_blocks(text):
                return split(text, path.name, notes, header=header, units=units)
            found = parse_blocks(text, path.name, notes)
        else:
            found = parse_json(text, path.name)
    for option, line in (("--header", header), ("--units", units)):
        if line is not None:
            raise InputError(option, "given", f"left out, for {path.name} is no table of text")
    return found


def _of_format(path: Path, columns: Mapping[str, str]) -> Recorded | None:
    """Read the columns of a log that is not text; None for text."""
    ending = path.suffix.lower()
    verdict = f"{path.name} is damaged, or not of the format that its name says"
    if ending == ".erg":
        info, _ = decode(read_bytes(path.with_name(f"{path.name}.info"), "description of the log"), path.name)
        with damage_reported(verdict):
            return parse_erg(info, read_bytes(path, "log", most=MAX_FILE), path.name)
    if ending in (".mf4", ".mdf") or (ending == ".dat" and _begins(path, b"MDF")):
        mapped = " ".join(columns.values())
        read = registry.LOG_FORMATS["mdf"].load()
        with damage_reported(verdict):
            channels: Recorded = read(path, lambda name: recognise(name) is not None or name in mapped)
        return channels
    if path.is_dir() and any(path.rglob("*.npy")) and not (path / "metadata.yaml").exists():
        bound = "one table (write time and values side by side as CSV, with a line of names)"
        raise InputError(f"log {path.name}", "a folder of numpy's arrays", bound)
    if ending in (".bag", ".mcap", ".db3") or path.is_dir():
        read = registry.LOG_FORMATS["rosbag"].load()
        with damage_reported(verdict):
            bag: Recorded = read(path.parent if ending == ".db3" else path)
        return bag
    return _of_plugin(path, verdict)


def _of_plugin(path: Path, verdict: str) -> Recorded | None:
    """Read the columns of a log with an installed package; None if no package reads this format.

    The name of its entry point is the ending without the dot. Packages never read tables or our own formats.
    """
    ending = path.suffix.lower()
    if ending in OWN:
        return None
    entry = registry.LOG_FORMATS.get(ending.removeprefix("."))
    if entry is None or not entry.outside:
        return None
    read = entry.load()
    with damage_reported(verdict):
        found: Recorded = read(path)
    return found


def _begins(path: Path, mark: bytes) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(mark)) == mark
    except OSError as error:
        raise _unreadable(path, error) from error


def _text(path: Path) -> bytes:
    """Read the bytes of a text, but stop at a line that is too long to be a row."""
    read, line, limit = bytearray(), 0, MAX_LINE
    try:
        with path.open("rb") as file:
            while chunk := file.read(CHUNK):
                if not read and looks_like_json(chunk[:1000].decode("latin-1").lstrip("ï»¿")):
                    limit = MAX_JSON
                read += chunk
                first, last = chunk.find(b"\n"), chunk.rfind(b"\n")
                _bounded(f"a line of log {path}", line + (len(chunk) if first < 0 else first), limit)
                line = line + len(chunk) if last < 0 else len(chunk) - last - 1
                _bounded(f"log {path}", len(read), MAX_FILE)
    except OSError as error:
        raise _unreadable(path, error) from error
    return bytes(read)


def _bounded(what: str, size: int, limit: int) -> None:
    if size > limit:
        raise InputError(f"size of {what}", f"more than {limit >> 20} MiB", f"at most {limit >> 20} MiB")


def _unreadable(path: Path, error: OSError) -> InputError:
    return InputError(f"log {path}", f"not readable ({error.strerror})", "a readable file")
