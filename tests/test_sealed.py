"""Runs and laws come back equal; what is damaged, foreign or inconsistent is refused in one sentence."""

import json
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith import files, sealed, stored
from otolith.core.errors import CorruptFile
from otolith.core.frames import SURGE_PITCH
from otolith.core.hdf5 import read_sealed, write_sealed
from otolith.cueing.mpc.explicit_problem import ExplicitSettings, explicit_problem
from otolith.loop import Run
from otolith.loop.run import OF_BASE
from otolith.mpqp import Law, enumerate_regions
from otolith.platforms import load
from tests.mutilation import flipped

RUN: dict[str, Any] = {"kind": stored.RUN_KIND, "version": stored.RUN_VERSION}
LAW: dict[str, Any] = {"kind": sealed.LAW_KIND, "version": sealed.LAW_VERSION}


@pytest.fixture(scope="module")
def law() -> Law:
    """A small law: horizon 2, so that this file stays fast."""
    thesis = load("thesis")
    problem = explicit_problem(
        SURGE_PITCH, thesis.limits(SURGE_PITCH), thesis.braking, ExplicitSettings(horizon=2, block_from=None)
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


def test_a_law_comes_back_equal_in_what_it_says(law: Law, tmp_path: Path) -> None:
    files.write_laws([law, law], tmp_path / "law.h5")
    back, twin = files.read_laws(tmp_path / "law.h5")
    assert len(back) == len(twin) == len(law)
    assert back.problem.digest == law.problem.digest
    rng = np.random.default_rng(0)
    low, high = law.problem.lower, law.problem.upper
    for theta in rng.uniform(low, high, (50, 5)):
        one, other = law.evaluate(theta), back.evaluate(theta)
        assert one.found == other.found
        if one.found:
            np.testing.assert_array_equal(one.z, other.z)


def test_a_flipped_bit_anywhere_is_refused(handmade: Run, law: Law, tmp_path: Path) -> None:
    path = tmp_path / "x.h5"
    files.write_run(handmade, path)
    for _ in flipped(path, count=500):
        with pytest.raises(CorruptFile, match="damaged"):
            files.read_run(path)
    files.write_laws([law], path)
    for _ in flipped(path, count=200):
        with pytest.raises(CorruptFile, match="damaged"):
            files.read_laws(path)


def rewritten(run: Run, path: Path, *, attributes: dict[str, Any], arrays: dict[str, Any]) -> Path:
    """A sound file of a run in which some entries were replaced; None removes one."""
    files.write_run(run, path)
    content = read_sealed(path, **RUN)
    stated = {key: value for key, value in (content.attributes | attributes).items() if value is not None}
    kept = {key: value for key, value in (content.arrays | arrays).items() if value is not None}
    write_sealed(path, stated, kept, **RUN)
    return path


@pytest.mark.parametrize("name", stored.SERIES)
def test_every_series_must_have_the_shape_and_kind_that_the_clocks_give_it(
    handmade: Run, tmp_path: Path, name: str
) -> None:
    path = tmp_path / "run.h5"
    if name in OF_BASE:
        still = np.zeros((len(handmade.time), 18))
        handmade = replace(handmade, base=still, base_command=np.zeros((handmade.decisions, 6)))
    files.write_run(handmade, path)
    values = read_sealed(path, **RUN).arrays[name]
    others = [
        values[:-1],
        values[..., None],
        values.astype("c16")
        if values.dtype.kind == "f"
        else values * 1.5
        if values.dtype.kind == "i"
        else values.astype("S3"),
        None,
    ]
    for other in (
        others if values.dtype.kind != "S" else [values[:-1], values[..., None], np.zeros(len(values)), None]
    ):
        with pytest.raises(CorruptFile, match="is no sound otolith-run file"):
            files.read_run(rewritten(handmade, path, attributes={}, arrays={name: other}))


@pytest.mark.parametrize(
    ("attributes", "sentence"),
    [
        ({"settings": "[" * 200_000 + "]" * 200_000}, "recursion"),
        ({"settings": "[1]"}, "its settings are not a table"),
        ({"settings": None}, "it lacks"),
        ({"platform": "{}"}, "name"),
        ({"dofs": json.dumps(["surge-yaw"])}, "surge-yaw"),
        ({"dofs": "[]"}, "degrees of freedom"),
        ({"dofs": json.dumps(["roll"])}, "roll"),
        ({"period": 0.0}, "do not belong to"),
        ({"period": float("nan")}, "do not belong to"),
        ({"plant_period": -0.01}, "do not belong to"),
        ({"period": 0.2}, "do not belong to"),
    ],
)
def test_attributes_that_make_no_sense_are_refused(
    handmade: Run, tmp_path: Path, attributes: dict[str, Any], sentence: str
) -> None:
    path = rewritten(handmade, tmp_path / "run.h5", attributes=attributes, arrays={})
    with pytest.raises(CorruptFile, match="is no sound otolith-run file") as refused:
        files.read_run(path)
    assert sentence in str(refused.value)


def test_a_clock_that_does_not_tick_evenly_is_refused(handmade: Run, tmp_path: Path) -> None:
    time = handmade.time.copy()
    time[50:] += 1.0
    path = rewritten(handmade, tmp_path / "run.h5", attributes={}, arrays={"time": time})
    with pytest.raises(CorruptFile, match=r"time does not run in steps of 0.01 s"):
        files.read_run(path)


@pytest.mark.parametrize("parts", [0, -1, 2, 10**9])
def test_a_number_of_parts_that_is_not_there_is_refused(law: Law, tmp_path: Path, parts: int) -> None:
    path = tmp_path / "law.h5"
    files.write_laws([law], path)
    content = read_sealed(path, **LAW)
    write_sealed(path, {"parts": parts}, content.arrays, **LAW)
    with pytest.raises(CorruptFile, match=f"it declares {parts} laws and holds 1"):
        files.read_laws(path)


def test_another_kind_of_file_is_named(handmade: Run, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    files.write_run(handmade, path)
    with pytest.raises(CorruptFile, match="is not an otolith-law file"):
        files.read_laws(path)
