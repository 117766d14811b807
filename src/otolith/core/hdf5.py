"""Sealed HDF5 files: their SHA-256 is checked before the HDF5 library sees a single byte.

The HDF5 library cannot be trusted with damaged files: one flipped bit can make it crash the whole process,
and so can a full disk while it writes. Therefore a file is composed in memory and written in one go. It
begins with a *seal*, 512 bytes that contain the SHA-256 of the rest. HDF5 calls such bytes a user block and
skips them, so MATLAB's h5read and Python's h5py open these files like any others.

The seal protects against accidental damage. It does not protect against a person, who can compute a new one.
"""

import hashlib
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.disk import write_bytes
from otolith.core.errors import CorruptFile, InputError, damage_reported

if TYPE_CHECKING:
    import h5py  # imported on use, so that commands without such files start faster

SEAL_BYTES: Final = 512
_SEAL: Final = "Otolith file, an HDF5 file after its first 512 bytes. SHA-256 of all that follows them:\n"
MOST_BYTES: Final = 4 * 2**30  # limit on the unpacked data of a file [bytes]: five hours of a run
MOST_RATIO: Final = 1100  # limit on the compression ratio; gzip reaches 1032 at most
Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Content:
    """The content of a file: attributes, and arrays by name; a "/" in an array's name separates groups."""

    attributes: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


def write_sealed(
    path: Path, attributes: Mapping[str, Any], arrays: Arrays, *, kind: str, version: int
) -> None:
    """Write a sealed HDF5 file completely or not at all; raises `NotWritten` as `disk.whole` does."""
    import h5py

    buffer = io.BytesIO()
    with h5py.File(buffer, "w", userblock_size=SEAL_BYTES) as file:
        file.attrs.update(kind=kind, version=version, **attributes)
        for name, array in arrays.items():
            options = {"compression": "gzip"} if np.ndim(array) else {}
            file.create_dataset(name, data=array, **options)
    content = buffer.getvalue()[SEAL_BYTES:]
    write_bytes(path, _seal(hashlib.sha256(content).hexdigest()) + content)


def read_sealed(path: Path, *, kind: str, version: int) -> Content:
    """Read a sealed HDF5 file of the given kind and version.

    Raises
    ------
    InputError : the file does not exist or cannot be read.
    CorruptFile : the file is damaged, was altered, has another kind or version, or unpacks to more than
        `MOST_BYTES`.
    """
    import h5py

    _check_seal(path, kind)
    with damage_reported(f"{path} is no readable {kind} file"), h5py.File(path, "r") as file:
        _check_kind(file, path, kind, version)
        _check_size(file, path)
        return Content(_attributes(file), _arrays(file))


def _seal(digest: str) -> bytes:
    return f"{_SEAL}{digest}\n".encode().ljust(SEAL_BYTES, b"\0")


def _check_seal(path: Path, kind: str) -> None:
    try:
        with path.open("rb") as file:
            seal = file.read(SEAL_BYTES)
            if not seal.startswith(_SEAL.encode()):
                raise CorruptFile(
                    f"{path} is no {kind} file, or its beginning is damaged, or an earlier version wrote it"
                )
            found = hashlib.file_digest(file, "sha256").hexdigest()
    except FileNotFoundError as error:
        raise InputError(f"file {path}", "absent", "an existing file") from error
    except OSError as error:
        raise InputError(f"file {path}", f"not readable ({error.strerror})", "a readable file") from error
    if seal != _seal(found):
        raise CorruptFile(f"{path} is damaged or was altered: its content does not match its SHA-256")


def _check_kind(file: "h5py.File", path: Path, kind: str, version: int) -> None:
    found, written = file.attrs.get("kind"), file.attrs.get("version")
    if found != kind:
        raise CorruptFile(f"{path} is not an {kind} file")
    if written != version:
        raise CorruptFile(f"{path} has version {written} of {kind}, this program reads {version}")


def _check_size(file: "h5py.File", path: Path) -> None:
    """Refuse a file whose data sets declare too many bytes, before any memory is allocated for them."""
    declared = sum(data.nbytes for data in _datasets(file).values())
    most = min(MOST_BYTES, MOST_RATIO * path.stat().st_size)
    if declared > most:
        raise CorruptFile(
            f"{path} declares {declared:.3g} bytes of data, a file of its size holds at most {most:.3g}"
        )


def _datasets(file: "h5py.File") -> dict[str, "h5py.Dataset"]:
    """All data sets by path; links to other files are not followed."""
    import h5py

    found: dict[str, h5py.Dataset] = {}

    def note(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset):
            if item.external or item.is_virtual:
                raise ValueError(f"{name} lies in another file")
            found[name] = item

    file.visititems(note)
    return found


def _arrays(file: "h5py.File") -> dict[str, NDArray[Any]]:
    return {name: data[()] for name, data in _datasets(file).items()}


def _attributes(file: "h5py.File") -> dict[str, Any]:
    """The file's attributes except kind and version, which were checked before."""
    return {name: value for name, value in file.attrs.items() if name not in ("kind", "version")}
