"""A folder of results appears whole, replaces results whole, and never touches what is the user's."""

import errno
import os
from pathlib import Path

import pytest

from otolith.core import folders
from otolith.core.disk import NotWritten, write_text
from otolith.core.errors import InputError


def fill(folder: Path, *names: str) -> None:
    with folders.whole_folder(folder, command="run") as made:
        for name in names:
            write_text(made / name, name)


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir() if entry.name != folders.LIST)


def test_results_replace_results_whole(tmp_path: Path) -> None:
    fill(tmp_path / "deep" / "out", "run.h5", "figure-sway.png")
    fill(tmp_path / "deep" / "out", "run.h5", "figure.png")
    assert names(tmp_path / "deep" / "out") == ["figure.png", "run.h5"]
    assert names(tmp_path / "deep") == ["out"]


def test_a_file_of_the_users_is_never_lost_nor_mixed_with_results(tmp_path: Path) -> None:
    out = tmp_path / "out"
    fill(out, "run.h5")
    (out / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"'otolith run' did not write \(notes.txt\).*--force replaces"):
        fill(out, "run.h5")
    assert names(out) == ["notes.txt", "run.h5"]
    with folders.whole_folder(out, command="run", force=True) as made:
        write_text(made / "summary.json", "{}")
    assert names(out) == ["summary.json"]


def test_a_file_added_by_a_later_command_is_a_result_too(tmp_path: Path) -> None:
    out = tmp_path / "out"
    fill(out, "run.h5")
    write_text(out / "map.png", "x")
    folders.enlist(out / "map.png")
    fill(out, "run.h5")
    assert names(out) == ["run.h5"]


def test_results_of_another_command_are_not_replaced(tmp_path: Path) -> None:
    """Or `platform show --run out/run.h5 --out out` would lose the run that it shows."""
    fill(tmp_path / "out", "run.h5")
    with pytest.raises(InputError, match=r"'otolith platform show' did not write \(run.h5\)"):
        folders.check_folder(tmp_path / "out", command="platform show")


@pytest.mark.parametrize("stop", [KeyboardInterrupt, ValueError])
def test_whatever_stops_the_work_leaves_the_old_folder_or_none(
    tmp_path: Path, stop: type[BaseException]
) -> None:
    def stopped(out: Path) -> None:
        with folders.whole_folder(out, command="run") as made:
            write_text(made / "half.h5", "x")
            raise stop

    with pytest.raises(stop):
        stopped(tmp_path / "new")
    assert names(tmp_path) == []
    fill(tmp_path / "old", "run.h5")
    with pytest.raises(stop):
        stopped(tmp_path / "old")
    assert names(tmp_path) == ["old"]
    assert names(tmp_path / "old") == ["run.h5"]


def test_a_full_disk_leaves_the_old_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out"
    fill(out, "run.h5")

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(NotWritten, match="out could not be written: No space left on device"):
        fill(out, "other.h5")
    assert names(out) == ["run.h5"]
    assert names(tmp_path) == ["out"]


def test_a_full_disk_elsewhere_is_not_told_of_the_results(tmp_path: Path) -> None:
    (tmp_path / "cache").touch()  # a file, so nothing can be written below it
    with (
        pytest.raises(NotWritten, match=r"solver\.py could not be written"),
        folders.whole_folder(tmp_path / "out", command="run"),
    ):
        write_text(tmp_path / "cache" / "solver.py", "text")
    assert names(tmp_path) == ["cache"]


def test_a_second_rename_that_fails_puts_the_old_folder_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, rename = tmp_path / "out", Path.rename
    fill(out, "run.h5")

    def fails(self: Path, target: Path) -> Path:
        if ".part-" in self.name and not self.name.endswith("-old"):
            raise OSError(errno.EIO, os.strerror(errno.EIO))
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fails)
    with pytest.raises(NotWritten, match="Input/output error"):
        fill(out, "other.h5")
    assert names(out) == ["run.h5"]


def test_places_that_cannot_be_replaced_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("x")
    for place, sentence in (
        (tmp_path / "file", "is a file, must be a folder"),
        (tmp_path / "file" / "below", "is not writable"),
        (Path("/proc/otolith"), "is not writable"),
    ):
        with pytest.raises(InputError, match=sentence):
            folders.check_folder(place, command="run")
    (tmp_path / "here" / "below").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "here" / "below")
    for place in (Path(), tmp_path / "here", Path.home(), Path("/")):
        with pytest.raises(InputError, match="a mount point, or a folder that you are in"):
            folders.check_folder(place, command="run", force=True)
    with pytest.raises(InputError, match="is a folder, must be a file"):
        folders.check_file(tmp_path / "here")
    with pytest.raises(InputError, match="not writable"):
        folders.check_file(tmp_path / "file" / "law.h5")
    folders.check_file(tmp_path / "new" / "law.h5")


def test_a_name_that_could_not_be_read_again_is_refused(tmp_path: Path) -> None:
    folders.check_file(tmp_path / "LAW.H5", ".h5")
    sentence = r"law\.txt, must be a name that ends in \.csv or \.h5"
    with pytest.raises(InputError, match=sentence):
        folders.check_file(tmp_path / "law.txt", ".csv", ".h5")


def test_folders_above_results_that_did_not_come_are_removed_unless_somebody_uses_them(
    tmp_path: Path,
) -> None:
    place = tmp_path / "a" / "b" / "out"
    with pytest.raises(ZeroDivisionError), folders.whole_folder(place, command="run"):
        raise ZeroDivisionError
    assert not (tmp_path / "a").exists()
    notes = tmp_path / "a" / "notes"
    with pytest.raises(ZeroDivisionError), folders.whole_folder(place, command="run"):
        notes.write_text(str(1 / (notes.write_text("mine") - 4)))
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["notes"]
