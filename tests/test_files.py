"""What is written comes back equal; what is damaged or foreign is refused; nothing half-written stays."""

from dataclasses import fields
from pathlib import Path

import h5py
import numpy as np
import pytest

from otolith import files
from otolith.core.errors import CorruptFile, InputError
from otolith.core.frames import SURGE_PITCH
from otolith.mpc.explicit import ExplicitSettings, explicit_problem
from otolith.mpqp import Law, enumerate_regions
from otolith.platforms import load
from otolith.simulate import Run


@pytest.fixture(scope="module")
def law() -> Law:
    """A small law: horizon 2, so that this file stays fast."""
    thesis = load("thesis")
    problem = explicit_problem(
        thesis.pair_limits(SURGE_PITCH), thesis.braking, ExplicitSettings(horizon=2, block_from=None)
    )
    return enumerate_regions(problem)


def test_a_run_comes_back_equal(handmade: Run, tmp_path: Path) -> None:
    files.write_run(handmade, tmp_path / "deep" / "run.h5")
    back = files.read_run(tmp_path / "deep" / "run.h5")
    for field in fields(Run):
        before, after = getattr(handmade, field.name), getattr(back, field.name)
        if isinstance(before, np.ndarray):
            np.testing.assert_array_equal(after, before)
            assert after.dtype == before.dtype
        else:
            assert after == before, field.name
    assert [path.name for path in (tmp_path / "deep").iterdir()] == ["run.h5"]


def test_a_run_of_the_first_version_is_read_without_the_rates_it_did_not_keep(
    handmade: Run, tmp_path: Path
) -> None:
    path = tmp_path / "run.h5"
    files.write_run(handmade, path)
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = 1
        del file.attrs["singles"], file["reference_rate"]
    old = files.read_run(path)
    assert old.singles == ()
    assert np.isnan(old.reference_rate).all()
    np.testing.assert_array_equal(old.reference_force, handmade.reference_force)


def test_a_law_comes_back_equal_in_what_it_says(law: Law, tmp_path: Path) -> None:
    files.write_laws([law], tmp_path / "law.h5")
    (back,) = files.read_laws(tmp_path / "law.h5")
    assert len(back) == len(law)
    assert back.problem.digest == law.problem.digest
    rng = np.random.default_rng(0)
    low, high = law.problem.lower, law.problem.upper
    for theta in rng.uniform(low, high, (50, 5)):
        one, other = law.evaluate(theta), back.evaluate(theta)
        assert one.found == other.found
        if one.found:
            np.testing.assert_array_equal(one.z, other.z)


def test_an_altered_law_is_refused(law: Law, tmp_path: Path) -> None:
    path = tmp_path / "law.h5"
    files.write_laws([law], path)
    with h5py.File(path, "r+") as file:
        part = file["part-0"]
        name = next(name for name, data in part.items() if data.dtype.kind == "f" and data.size > 10)
        values = part[name][()]
        values.flat[3] += 1e-3
        part[name][...] = values
    with pytest.raises(CorruptFile, match="does not match its SHA-256"):
        files.read_laws(path)


@pytest.mark.parametrize("keep", [0, 100, 2000])
def test_a_truncated_file_is_refused(handmade: Run, tmp_path: Path, keep: int) -> None:
    path = tmp_path / "run.h5"
    files.write_run(handmade, path)
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(CorruptFile, match="is damaged or no otolith-run file"):
        files.read_run(path)


def test_a_foreign_kind_and_another_version_are_refused(handmade: Run, law: Law, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    files.write_run(handmade, path)
    with pytest.raises(CorruptFile, match="is not an otolith-law file"):
        files.read_laws(path)
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = 99
    with pytest.raises(CorruptFile, match="has version 99 of otolith-run, this program reads 2"):
        files.read_run(path)
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = files.RUN_VERSION
        del file["pose"]
    with pytest.raises(CorruptFile, match="damaged"):
        files.read_run(path)
    with pytest.raises(InputError, match="absent, must be an existing file"):
        files.read_run(tmp_path / "no.h5")


def test_a_failure_while_writing_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "summary.json"
    files.write_json(path, {"a": 1})
    with pytest.raises(ValueError, match="not JSON compliant"):
        files.write_json(path, {"a": float("nan")})

    def interrupted(temporary: Path) -> None:
        temporary.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        files.write_figure(path, interrupted)
    assert path.read_text() == '{\n  "a": 1\n}\n'
    assert [p.name for p in tmp_path.iterdir()] == ["summary.json"]


def test_an_unwritable_place_is_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="not writable"):
        files.write_text(tmp_path / "file" / "below.txt", "x")


def test_platforms_are_found_by_name_and_by_path(tmp_path: Path) -> None:
    assert files.read_platform("davsi").name == "davsi"
    with pytest.raises(InputError, match=r"platform is 'davsy', must be a .toml file or one of"):
        files.read_platform("davsy")
    with pytest.raises(InputError, match="not readable"):
        files.read_platform(str(tmp_path / "rig.toml"))
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"name = '\xff'")
    with pytest.raises(InputError, match="not UTF-8 at byte 8, must be a UTF-8 text file"):
        files.read_platform(str(binary))
