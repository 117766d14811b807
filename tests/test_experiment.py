"""A run's file repeats the run: every setting comes back, and so does every bit of the motion."""

import json
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith import files
from otolith.core.errors import CorruptFile, InputError
from otolith.core.frames import HEAVE, SURGE_PITCH
from otolith.cueing.design import Design
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.objective import Objective
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.cueing.mpc.washout_weights import constant
from otolith.cueing.prediction import Adaptive
from otolith.cueing.washout.tuning import Corners, load_tuning
from otolith.experiment import Experiment, StoredFile, Wanted, differences
from otolith.loop import Run
from otolith.perception import Vestibular
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine
from otolith.record import design_from_record, design_to_record

DAVSI = load("davsi")
ODD = Design(
    platform=DAVSI,
    dofs=(SURGE_PITCH, HEAVE),
    explicit=ExplicitSettings(
        horizon=4, block_from=None, braking=BrakingRows.PRINTED, state_weights=(0.1, 0.2, 0.3, 1 / 3)
    ),
    mpc=MpcSettings(
        horizon=13,
        period=0.02,
        lag=1 / 30,
        objective=Objective(senses=Vestibular(), force=1.1, tilting=0.7, rate=3.0),
        control_weight=0.1 + 0.2,
        washout=constant({"position": 0.9}),
        braking=BrakingRows.LEADING,
        terminal=True,
        soft={"tilt_rate": 100.0},
        blocks=(1, 2, 10),
        firm=1,
        later_penalty=77.0,
        linear=True,
        prediction=Adaptive(near=1 / 3),
        iterations=2,
        tolerance=1e-5,
        engine=CondensedEngine,
    ),
    entry=Entry.PRIMAL,
    liveliness=0.1 + 0.2,
    corners=Corners(high_pass=1.0 + 0.1 + 0.2, low_pass=2 / 3),
    washout=load_tuning("davsi"),
)


def written(value: Any) -> Any:
    """As it comes back from a file."""
    return json.loads(json.dumps(value))


def test_every_setting_of_a_design_comes_back() -> None:
    plain = Design(platform=DAVSI)
    for name in (one.name for one in fields(MpcSettings)):
        assert getattr(ODD.mpc, name) != getattr(plain.mpc, name), f"{name} is not tried"
    record = design_to_record(ODD)
    assert written(record) == record
    back = design_from_record(written(record), DAVSI, ("surge-pitch", "heave"))
    assert design_to_record(back) == record
    for name in ("dofs", "explicit", "entry", "liveliness", "corners", "washout"):
        assert getattr(back, name) == getattr(ODD, name), name
    for name in (one.name for one in fields(MpcSettings) if one.name != "objective"):
        assert getattr(back.mpc, name) == getattr(ODD.mpc, name), name
    senses = back.mpc.objective.senses
    assert senses is not None
    np.testing.assert_array_equal(senses.canal.A, Vestibular().canal.A)


@pytest.fixture
def run() -> Run:
    """A second of a washout, made from Python."""
    wanted = Wanted(scenario="sine:amplitude=0.8,frequency=0.5,duration=2", through="telban", scale=0.5)
    return Experiment(wanted=wanted, cueing="classical", design=Design(platform=DAVSI)).run()


def test_a_run_from_python_repeats_from_its_file(run: Run, tmp_path: Path) -> None:
    files.write_run(run, tmp_path / "run.h5")
    back = files.read_run(tmp_path / "run.h5")
    experiment = Experiment.of(back)
    assert experiment.wanted.scale == 0.5
    assert differences(run, experiment.run()) == []


def test_a_single_bit_is_a_difference(run: Run) -> None:
    pose = run.pose.copy()
    pose[7, 0] = np.nextafter(pose[7, 0], 1.0)
    assert differences(run, replace(run, pose=pose, plant="moon")) == ["plant", "pose"]


def test_another_version_or_damage_is_one_sentence(run: Run) -> None:
    design = {**run.settings["design"], "mpc": {**run.settings["design"]["mpc"], "unknown": 3}}
    for broken in ({**run.settings, "design": design}, {**run.settings, "wanted": {}}, {"wanted": 3}):
        with pytest.raises(CorruptFile, match="not of this version"):
            Experiment.of(replace(run, settings=broken))


def test_a_run_of_objects_says_that_it_cannot_be_repeated(handmade: Run) -> None:
    with pytest.raises(InputError, match="made of objects that its file does not hold"):
        Experiment.of(handmade)


def test_no_file_starts_code_from_outside(run: Run) -> None:
    with pytest.raises(InputError, match="--cueing is absent, must be given: the run names os:abort"):
        Experiment.of(replace(run, cueing="os:abort"))
    mpc = {**run.settings["design"]["mpc"], "engine": "os:abort"}
    settings = {**run.settings, "design": {**run.settings["design"], "mpc": mpc}}
    with pytest.raises(InputError, match="QP engine of the run is 'os:abort', must be one of structured"):
        Experiment.of(replace(run, settings=settings))


def test_a_log_is_known_by_its_content(tmp_path: Path) -> None:
    log = tmp_path / "drive.csv"
    t = np.arange(0.0, 2.0, 0.02)
    rows = [f"{a:.2f},{b:.4f}" for a, b in zip(t, np.sin(t) ** 2, strict=True)]
    log.write_text("\n".join(["t_s,ax_mps2", *rows]))
    run = Experiment(wanted=Wanted(log=log), cueing="classical", design=Design(platform=DAVSI)).run()
    moved = log.rename(tmp_path / "moved.csv")
    with pytest.raises(InputError, match="no longer there, must be an existing file; --log names it anew"):
        Experiment.of(run)
    again = Experiment.of(run, log=moved).run()
    assert differences(run, again) == []
    moved.write_text(moved.read_text() + "\n2.00,0.1")
    with pytest.raises(InputError, match="SHA-256 of log"):
        Experiment.of(run, log=moved)


def test_a_folder_is_known_by_all_its_files(tmp_path: Path) -> None:
    (tmp_path / "bag" / "deep").mkdir(parents=True)
    (tmp_path / "bag" / "deep" / "a.db3").write_bytes(b"1")
    first = StoredFile.of(tmp_path / "bag")
    assert first == StoredFile.of(tmp_path / "bag")
    (tmp_path / "bag" / "metadata.yaml").write_bytes(b"2")
    assert first != StoredFile.of(tmp_path / "bag")
