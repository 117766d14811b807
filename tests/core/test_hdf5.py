"""Sealed files: any damage is told before the HDF5 library sees it; hostile ones take no memory."""

import hashlib
import os
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from otolith.core import hdf5
from otolith.core.errors import CorruptFile, InputError

KIND: dict[str, Any] = {"kind": "otolith-test", "version": 1}


@pytest.fixture
def path(tmp_path: Path) -> Path:
    made = tmp_path / "test.h5"
    arrays = {"a": np.arange(3000.0).reshape(-1, 3), "group/b": np.array(7, dtype=np.int16)}
    hdf5.write_sealed(made, {"title": "α"}, arrays, **KIND)
    return made


def reseal(path: Path) -> None:
    """What a person can do who wants to deceive."""
    content = path.read_bytes()[hdf5.SEAL_BYTES :]
    path.write_bytes(hdf5._seal(hashlib.sha256(content).hexdigest()) + content)


def refusal(path: Path) -> str:
    with pytest.raises(CorruptFile) as refused:
        hdf5.read_sealed(path, **KIND)
    assert "\n" not in str(refused.value)
    return str(refused.value)


def test_content_comes_back_equal_and_any_hdf5_reader_opens_it(path: Path) -> None:
    back = hdf5.read_sealed(path, **KIND)
    assert back.attributes == {"title": "α"}
    assert set(back.arrays) == {"a", "group/b"}
    np.testing.assert_array_equal(back.arrays["a"], np.arange(3000.0).reshape(-1, 3))
    assert (back.arrays["group/b"], back.arrays["group/b"].dtype) == (7, np.int16)
    with h5py.File(path) as file:
        assert file["a"][1, 2] == 5.0
        assert file.attrs["kind"] == "otolith-test"


def test_equal_content_makes_equal_files(path: Path) -> None:
    before = path.read_bytes()
    content = hdf5.read_sealed(path, **KIND)
    hdf5.write_sealed(path, content.attributes, content.arrays, **KIND)
    assert path.read_bytes() == before


def test_every_flipped_bit_and_every_lost_byte_is_refused(path: Path) -> None:
    good, rng = path.read_bytes(), np.random.default_rng(14)
    places = [*range(min(4096, len(good))), *map(int, rng.integers(4096, len(good), 500))]
    with path.open("r+b", buffering=0) as file:
        for place in places:
            flipped = good[place] ^ 1 << int(rng.integers(8))
            os.pwrite(file.fileno(), bytes([flipped]), place)
            assert "damaged" in refusal(path)
            os.pwrite(file.fileno(), good[place : place + 1], place)
    for length in (0, 1, 500, 512, 513, len(good) - 1):
        path.write_bytes(good[:length])
        assert "damaged" in refusal(path)


def test_another_kind_or_version_and_an_absent_file_are_named(path: Path, tmp_path: Path) -> None:
    with pytest.raises(CorruptFile, match="is not an otolith-run file"):
        hdf5.read_sealed(path, kind="otolith-run", version=1)
    with pytest.raises(CorruptFile, match="has version 1 of otolith-test, this program reads 2"):
        hdf5.read_sealed(path, kind="otolith-test", version=2)
    with pytest.raises(InputError, match="absent, must be an existing file"):
        hdf5.read_sealed(tmp_path / "no.h5", **KIND)
    with pytest.raises(InputError, match="not readable"):
        hdf5.read_sealed(tmp_path, **KIND)


@pytest.mark.parametrize("compressed", [True, False])
def test_ninety_six_gigabytes_in_a_small_file_take_no_memory(path: Path, *, compressed: bool) -> None:
    options: dict[str, Any] = {"compression": "gzip", "chunks": (1 << 17,)} if compressed else {}
    with h5py.File(path, "r+") as file:
        file.create_dataset("huge", shape=(12_000_000_000,), dtype="f8", **options)
    reseal(path)
    assert "declares 9.6e+10 bytes of data, a file of its size holds at most" in refusal(path)


def test_a_file_that_borrows_its_data_from_another_is_refused(path: Path, tmp_path: Path) -> None:
    (tmp_path / "secret").write_bytes(b"x" * 80)
    with h5py.File(path, "r+") as file:
        file.create_dataset("secret", shape=(10,), dtype="f8", external=[(tmp_path / "secret", 0, 80)])
    reseal(path)
    assert "secret lies in another file" in refusal(path)
