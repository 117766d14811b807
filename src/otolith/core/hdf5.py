"""Sealed HDF5 files: their SHA-256 is checked before the HDF5 library sees a single byte.

The HDF5 library cannot be trusted with damaged files: one flipped bit can make it crash the whole process,
and so can a full disk while it writes. Therefore a file is composed in memory and written in one go, or, if
it is too large for that, through a layer that hides a failing disk from the library (`GrowingFile`). It
begins with a *seal*, 512 bytes that contain the SHA-256 of the rest. HDF5 calls such bytes a user block and
skips them, so MATLAB's h5read and Python's h5py open these files like any others. The seal is written last.

The seal protects against accidental damage. It does not protect against a person, who can compute a new one.
"""

import contextlib
import hashlib
import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from otolith.core.disk import write_bytes
from otolith.core.errors import CorruptFile, InputError, damage_reported
from otolith.core.signals import signals_wait

if TYPE_CHECKING:
    import h5py  # imported on use, so that commands without such files start faster

SEAL_BYTES: Final = 512
_SEAL: Final = "Otolith file, an HDF5 file after its first 512 bytes. SHA-256 of all that follows them:\n"
MOST_BYTES: Final = 4 * 2**30  # limit on the unpacked data of a file [bytes]: five hours of a run
CHUNK_ROWS: Final = 10_000  # rows of a growing array that are compressed together, at most
MOST_RATIO: Final = 1100  # limit on the compression ratio; gzip reaches 1032 at most
Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Content:
    """The content of a file: attributes, and arrays by name; a "/" in an array's name separates groups."""

    attributes: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


def write_sealed(
    path: Path,
    attributes: Mapping[str, Any],
    arrays: Arrays,
    *,
    kind: str,
    version: int,
    units: Mapping[str, str] | None = None,
) -> None:
    """Write a sealed HDF5 file completely or not at all; raises `NotWritten` as `disk.whole` does.

    Parameters
    ----------
    units : of arrays by name; stored as the attribute `unit` of each.
    """
    import h5py

    buffer = io.BytesIO()
    with h5py.File(buffer, "w", userblock_size=SEAL_BYTES) as file:
        file.attrs.update(kind=kind, version=version, **attributes)
        for name, array in arrays.items():
            options = {"compression": "gzip"} if np.ndim(array) else {}
            made = file.create_dataset(name, data=array, **options)
            if units is not None and name in units:
                made.attrs["unit"] = units[name]
    content = buffer.getvalue()[SEAL_BYTES:]
    write_bytes(path, _seal(hashlib.sha256(content).hexdigest()) + content)


class GrowingFile:
    """A sealed file that is written row by row, so that its arrays need not be in memory as a whole.

    Until `seal` is called, nothing takes the file for a sealed one. A failure of the disk is an `OSError`.
    """

    def __init__(self, path: Path) -> None:
        import h5py

        self._disk = _Disk(path, "w+")
        with signals_wait():
            self._file = h5py.File(self._disk, "w", userblock_size=SEAL_BYTES)

    def append(self, arrays: Arrays) -> None:
        """Append rows to the arrays of these names; the first call makes them.

        Whole multiples of `CHUNK_ROWS`, the last call aside, give the smallest file.
        """
        with self._disk.failures_told():
            for name, rows in arrays.items():
                if name not in self._file:
                    shape = rows.shape[1:]
                    self._file.create_dataset(
                        name,
                        shape=(0, *shape),
                        maxshape=(None, *shape),
                        chunks=(min(max(1, len(rows)), CHUNK_ROWS), *shape),
                        dtype=rows.dtype,
                        compression="gzip",
                    )
                data = self._file[name]
                before = len(data)
                data.resize(before + len(rows), axis=0)
                data[before:] = rows

    def seal(self, attributes: Mapping[str, Any], *, kind: str, version: int) -> None:
        """Write the attributes, close the file, and seal it."""
        with self._disk.failures_told():
            self._file.attrs.update(kind=kind, version=version, **attributes)
            self._file.close()
        self._disk.seek(SEAL_BYTES)
        digest = hashlib.file_digest(self._disk, "sha256").hexdigest()
        self._disk.seek(0)
        with self._disk.failures_told():
            self._disk.write(_seal(digest))
        self._disk.close()

    def close(self) -> None:
        """Close the file, whether or not it was sealed; what is not sealed is to be thrown away."""
        if self._disk.closed:
            return
        with (
            signals_wait(),
            contextlib.suppress(Exception),
        ):  # the library finds nothing of what a full disk has not taken
            self._file.close()
        self._disk.close()


class _Disk(io.FileIO):
    """A file whose failures the HDF5 library does not see, because it would crash; we ask for them.

    For the same reason, signals wait while the library may call `write`.
    """

    def __init__(self, path: Path, mode: str) -> None:
        super().__init__(path, mode)
        self._failure: OSError | None = None

    def write(self, data: Any) -> int:
        """Write all bytes, or keep the reason why not."""
        left = memoryview(data).cast("B")
        size = len(left)
        try:
            while self._failure is None and len(left):
                left = left[super().write(left) :]
        except OSError as error:
            self._failure = error
        return size

    @contextlib.contextmanager
    def failures_told(self) -> Iterator[None]:
        """Raise a failure of the disk after the block, also in place of what the library says of it."""
        with signals_wait():
            try:
                yield
            finally:
                if self._failure is not None:
                    raise self._failure


def read_sealed(path: Path, *, kind: str, version: int) -> Content:
    """Read a sealed HDF5 file of the given kind and version.

    Raises
    ------
    InputError : the file does not exist or cannot be read.
    CorruptFile : the file is damaged, was altered, has another kind or version, or unpacks to more than
        `MOST_BYTES`.
    """
    file = open_sealed(path, kind=kind, version=version)
    with damage_reported(f"{path} is no readable {kind} file"), file:
        return Content(attributes_of(file), _arrays(file))


def open_sealed(path: Path, *, kind: str, version: int) -> "h5py.File":
    """Open a sealed HDF5 file of the given kind and version; the errors are those of `read_sealed`."""
    import h5py

    _check_seal(path, kind)
    with damage_reported(f"{path} is no readable {kind} file"), contextlib.ExitStack() as stack:
        file = stack.enter_context(h5py.File(path, "r"))
        _check_kind(file, path, kind, version)
        _check_size(file, path)
        stack.pop_all()
    return file


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


def attributes_of(file: "h5py.File") -> dict[str, Any]:
    """Return a file's attributes except kind and version, which were checked before."""
    return {name: value for name, value in file.attrs.items() if name not in ("kind", "version")}
