"""Machine code that comes with the package is used where it fits exactly, and nowhere else."""

import json
import zipfile
from pathlib import Path

import pytest

from otolith.core import shipped
from tests.core.test_jit import package, python

COMPILE = """
from pathlib import Path
from otolith.core import shipped
shipped.ARCHIVE = Path("none")
codes = {}
shipped.on_compiled = codes.__setitem__
from small.caller import call
call(1.0)
for name, code in codes.items():
    Path(FOLDER, name).write_bytes(code)
"""
TAKE = """
import warnings
from pathlib import Path
from otolith.core import shipped
shipped.ARCHIVE = Path(ARCHIVE)
compiled = []
shipped.on_compiled = lambda name, code: compiled.append(name)
from small.caller import call
with warnings.catch_warnings(record=True) as said:
    warnings.simplefilter("always")
    value = call(NUMBER)
print(value, len(shipped.taken), len(compiled), *(one.message for one in said))
"""


@pytest.fixture
def small(tmp_path: Path) -> Path:
    return package(tmp_path)


@pytest.fixture
def archive(small: Path, tmp_path: Path) -> Path:
    """What `call` is made of, compiled in another process, as `tools/ship_kernels.py` packs it."""
    folder = tmp_path / "codes"
    folder.mkdir()
    python(COMPILE.replace("FOLDER", repr(str(folder))), small, tmp_path / "first")
    path = tmp_path / "kernels.zip"
    pack(path, folder, shipped.environment())
    return path


def pack(path: Path, folder: Path, made_for: dict[str, str]) -> None:
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(shipped.MADE_FOR, json.dumps(made_for))
        for code in folder.iterdir():
            archive.write(code, f"{shipped.kind()}/{code.name}")


def take(small: Path, archive: Path, *, number: str = "1.0") -> tuple[float, int, int, str]:
    """Value, functions taken from the archive, functions compiled, and what was said, with empty caches."""
    program = TAKE.replace("ARCHIVE)", f"{str(archive)!r})").replace("NUMBER", number)
    value, taken, compiled, *warned = python(program, small, archive.with_suffix(".caches")).split(maxsplit=3)
    return float(value), int(taken), int(compiled), " ".join(warned)


def test_one_function_is_taken_and_nothing_is_compiled(small: Path, archive: Path) -> None:
    assert take(small, archive) == (2.0, 1, 0, "")  # the machine code of the caller holds that of the callee


def test_a_caller_is_compiled_around_a_callee_that_came_along(
    small: Path, archive: Path, tmp_path: Path
) -> None:
    callee = tmp_path / "callee"
    callee.mkdir()
    python(
        COMPILE.replace("FOLDER", repr(str(callee))).replace(
            "caller import call", "callee import double as call"
        ),
        small,
        tmp_path / "other",
    )
    pack(archive, callee, shipped.environment())
    assert take(small, archive) == (2.0, 1, 1, "")


def test_no_archive_means_compiling(small: Path, tmp_path: Path) -> None:
    assert take(small, tmp_path / "none.zip") == (2.0, 0, 2, "")


def test_other_types_are_compiled(small: Path, archive: Path) -> None:
    assert take(small, archive, number="1") == (2.0, 0, 2, "")


def test_code_of_another_source_is_not_taken(small: Path, archive: Path) -> None:
    callee = small / "callee.py"
    callee.write_text(callee.read_text().replace("2.0 * x", "3.0 * x"))
    assert take(small, archive) == (3.0, 0, 2, "")


def test_an_archive_for_another_numba_is_named_once_and_not_used(
    small: Path, archive: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other.zip"
    pack(other, tmp_path / "codes", {**shipped.environment(), "numba": "0.1"})
    value, taken, compiled, warned = take(small, other)
    assert (value, taken, compiled) == (2.0, 0, 2)
    assert warned.startswith(
        "kernels are compiled on first use: the machine code that came along is for numba 0.1,"
    )
    assert warned.count("numba") == 1


def test_code_for_another_kind_of_processor_is_not_taken(small: Path, archive: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.zip"
    with zipfile.ZipFile(archive) as old, zipfile.ZipFile(other, "w") as new:
        for name in old.namelist():
            new.writestr(name.replace(f"{shipped.kind()}/", "another/"), old.read(name))
    assert take(small, other) == (2.0, 0, 2, "")


def test_the_kind_of_processor_is_that_of_its_features(monkeypatch: pytest.MonkeyPatch) -> None:
    all_of_them = dict.fromkeys(("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe"), True)
    for features, kind in (
        (all_of_them, "x86-64-v3"),
        ({**all_of_them, "fma": False}, "x86-64"),
        ({}, "x86-64"),
    ):
        monkeypatch.setattr(
            "llvmlite.binding.get_host_cpu_features", lambda features_here=features: features_here
        )
        assert shipped.kind.__wrapped__() == kind
