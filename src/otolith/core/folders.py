"""Folders of results. A folder is replaced as a whole or not at all; old and new results are never mixed.

A folder is filled under a temporary name next to its place and then renamed. It contains a list of the files
that were written and the command that wrote them. With this list the same command can distinguish results,
which it may replace, from files of the user or of other commands.
"""

import contextlib
import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

from otolith.core.disk import NotWritten, part_prefix, sweep, write_text
from otolith.core.errors import InputError

LIST: Final = ".otolith"  # name of the list: first line the command, then one file per line
PICTURES: Final = (".pdf", ".png", ".svg")  # file endings of the figure formats that can be drawn
_REPORTED: Final = 3  # how many foreign files an error message names


def check_folder(folder: Path, *, command: str, force: bool = False) -> None:
    """Refuse a folder that `whole_folder` could not write or should not replace, before any work is done.

    Raises
    ------
    InputError : the folder is a file or not writable, or it holds files that `command` did not write and
        `force` is not set.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"output {folder}", "a file", "a folder, or the name of one to make")
    _check_writable(folder)
    if not folder.exists():
        return
    place = folder.resolve()
    if place.is_mount() or any(place in (home, *home.parents) for home in (Path.cwd(), Path.home())):
        bound = "a folder below it: results replace a folder whole"
        raise InputError(f"output {folder}", "a mount point, or a folder that you are in", bound)
    foreign = _foreign(folder, command)
    if foreign and not force:
        names = ", ".join(foreign[:_REPORTED]) + (" and others" if len(foreign) > _REPORTED else "")
        bound = "empty, absent or another name; --force replaces the folder and all that it holds"
        raise InputError(
            f"output {folder}", f"a folder with what 'otolith {command}' did not write ({names})", bound
        )


def check_file(path: Path, *endings: str) -> None:
    """Refuse an output file before any work is done, if it could not be written or not be recognised later.

    Parameters
    ----------
    endings : allowed endings of the name, in lower case with their dots; with none, any name is allowed.

    Raises
    ------
    InputError : the name has another ending, the path is a folder, or its folder is not writable.
    """
    if endings and path.suffix.lower() not in endings:
        raise InputError("name of the output", str(path), f"a name that ends in {' or '.join(endings)}")
    if path.is_dir():
        raise InputError(f"output {path}", "a folder", "a file, or the name of one to make")
    _check_writable(path.parent)


@contextlib.contextmanager
def whole_folder(folder: Path, *, command: str, force: bool = False) -> Iterator[Path]:
    """Yield a temporary folder to fill. It replaces `folder` on success and is removed on any failure.

    Raises
    ------
    InputError : the folder is refused, see `check_folder`.
    NotWritten : writing failed, e.g. because the disk is full; what stood at `folder` is unchanged.
    """
    check_folder(folder, command=command, force=force)
    place = folder.resolve()
    absent = [parent for parent in place.parents if not parent.exists()]  # the nearest first
    temporary: Path | None = None
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        sweep(place.parent)
        temporary = Path(tempfile.mkdtemp(dir=place.parent, prefix=part_prefix(place)))
        temporary.chmod(0o755)  # mkdtemp makes the folder accessible to its owner only
        yield temporary
        _write_list(temporary, command, _names(temporary))
        _exchange(temporary, place)
    except OSError as error:
        raise NotWritten(folder, error.strerror or str(error)) from error
    except NotWritten as error:
        if temporary is None or not error.path.is_relative_to(temporary):
            raise  # of a file elsewhere, such as the cache of solvers, which it names
        raise NotWritten(folder, error.reason) from error
    finally:
        if temporary is not None:
            shutil.rmtree(temporary, ignore_errors=True)
        if not place.exists():
            _remove_empty(absent)


def _remove_empty(folders: Sequence[Path]) -> None:
    """Remove folders that were made for results that did not come, unless somebody else uses them by now."""
    for folder in folders:
        try:
            folder.rmdir()
        except OSError:
            return


def enlist(path: Path) -> None:
    """Add a file that was written later to its folder's list of results, so that it counts as a result
    too.
    """
    if (path.parent / LIST).is_file():
        command, names = _list(path.parent)
        _write_list(path.parent, command, sorted({*names, path.name}))


def _write_list(folder: Path, command: str, names: Sequence[str]) -> None:
    write_text(folder / LIST, "".join(f"{line}\n" for line in (f"# otolith {command}", *names)))


def _list(folder: Path) -> tuple[str, list[str]]:
    """Read a folder's list: the command that wrote the folder, and the names of the files it wrote."""
    head, *names = (folder / LIST).read_text(encoding="utf-8", errors="replace").splitlines() or [""]
    return head.removeprefix("# otolith "), names


def _exchange(temporary: Path, place: Path) -> None:
    """Rename `temporary` to `place`. An existing `place` is moved aside first and restored if this fails."""
    if not place.exists():
        temporary.rename(place)
        return
    aside = temporary.with_name(f"{temporary.name}-old")
    place.rename(aside)
    try:
        temporary.rename(place)
    except BaseException:
        aside.rename(place)
        raise
    shutil.rmtree(aside, ignore_errors=True)


def _foreign(folder: Path, command: str) -> list[str]:
    """Names of the files in a folder that are not on its list, or all files if another command wrote the
    list.
    """
    writer, listed = _list(folder) if (folder / LIST).is_file() else ("", [])
    return [name for name in _names(folder) if name != LIST and (writer != command or name not in listed)]


def _names(folder: Path) -> list[str]:
    """Paths of all files below a folder, relative to that folder."""
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if not path.is_dir())


def _check_writable(folder: Path) -> None:
    """Check that the nearest existing folder is writable by creating an anonymous temporary file in it."""
    existing = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    try:
        if not existing.is_dir():
            raise NotADirectoryError(20, os.strerror(20))
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        raise InputError(
            f"output {folder}", f"not writable ({error.strerror})", "in a writable folder"
        ) from error
