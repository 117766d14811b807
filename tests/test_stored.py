"""A run that is kept in a file while it is made is the run in memory, and whole or not there."""

import os
import resource
import shutil
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith import files, registry
from otolith.core.errors import CorruptFile
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design
from otolith.experiment import differences
from otolith.interfaces import Command, Cueing, PlatformState, Reference
from otolith.loop import Keeper, Run, simulate
from otolith.loop import run as loop_run
from otolith.metrics import perceived_error, summarise
from otolith.platforms import load
from otolith.report.motion import motion_panels
from otolith.report.view import frames_of
from otolith.scenarios import scenario
from tests.metrics.stored_runs import noisy

DRIVE = "multisine:seed=3,amplitude=1.5,duration=7.3"
POSIX = pytest.mark.skipif(os.name != "posix", reason="limits of a process are POSIX's")


class InPython:
    """An algorithm without a kernel."""

    def __init__(self, cueing: Cueing) -> None:
        self._cueing, self.period = cueing, cueing.period

    def reset(self, state: PlatformState) -> None:
        self._cueing.reset(state)

    def step(self, state: PlatformState, reference: Reference) -> Command:
        return self._cueing.step(state, reference)


def simulated(keep: Keeper | None = None, *, compiled: bool = True, stop_at: float = 2.0) -> Run:
    """7.3 s of a washout on a plant with a state of its own, stopped at a share of the way."""
    platform = load("davsi")
    plant = registry.make_plant("actuator", platform)
    cueing = registry.make_cueing("classical", Design(platform=platform), dead_time=plant.dead_time)

    def progress(done: float) -> None:
        if done >= stop_at:
            raise KeyboardInterrupt

    return simulate(
        cueing if compiled else InPython(cueing),
        plant,
        scenario(DRIVE),
        platform=platform,
        dofs=(SURGE_PITCH.name,),
        settings={"scale": 1.0},
        keep=keep,
        progress=progress,
    )


@pytest.mark.parametrize("compiled", [True, False])
def test_a_run_kept_in_parts_is_the_run_of_one_part_to_the_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compiled: bool
) -> None:
    whole = simulated(compiled=compiled)
    monkeypatch.setattr(loop_run, "PART", 1000)
    with files.run_file(tmp_path / "run.h5") as keep:
        kept = simulated(keep, compiled=compiled)
        assert len(list(kept.parts())) == 8
        assert differences(whole, kept) == differences(kept, whole) == []
        for one in fields(Run):
            if one.name != "step_time":
                np.testing.assert_array_equal(getattr(kept, one.name), getattr(whole, one.name), one.name)
        np.testing.assert_array_equal(kept.felt_rate, whole.felt_rate)
        assert (kept.outcomes, kept.samples, kept.duration) == (whole.outcomes, 7300, whole.duration)
        assert not (tmp_path / "run.h5").exists()
    assert differences(files.read_run(tmp_path / "run.h5"), simulated(compiled=compiled)) == []
    assert [one.name for one in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.parametrize(
    ("platform", "dofs"),
    [("thesis", ("surge-pitch", "sway-roll")), ("davsi", ("surge-pitch", "sway-roll", "heave", "yaw"))],
)
def test_figures_and_curves_of_parts_are_those_of_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, platform: str, dofs: tuple[str, ...]
) -> None:
    run = noisy(platform, dofs, seed=5)
    summary, error = summarise(run), perceived_error(run)
    panels = [motion_panels(run, dof) for dof in run.dofs]
    frames = frames_of(run)
    files.write_run(run, tmp_path / "run.h5")
    monkeypatch.setattr(loop_run, "PART", 70)  # cuts through cues, and leaves a part of 40 samples
    with files.open_run(tmp_path / "run.h5") as stored:
        assert summarise(stored) == summarise(run)  # bit by bit
        assert_close(summarise(run), summary)
        np.testing.assert_array_equal(perceived_error(stored), error)
        for ours, theirs in zip(frames_of(stored), frames, strict=True):
            np.testing.assert_array_equal(ours, theirs)
        for dof, of_whole in zip(run.dofs, panels, strict=True):
            for panel, expected in zip(motion_panels(stored, dof), of_whole, strict=True):
                for one, other in zip(panel.curves, expected.curves, strict=True):
                    np.testing.assert_array_equal((one.x, one.y), (other.x, other.y))


def assert_close(one: Any, other: Any) -> None:
    """Values of summaries are equal but for the last digits, which the order of a sum decides."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for key in one:
            assert_close(one[key], other[key])
    else:
        assert one == (pytest.approx(other, rel=1e-11) if isinstance(other, float) else other)


def test_curves_of_a_long_run_keep_the_same_points_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    run = noisy("thesis", ("surge-pitch",), seed=6)
    from otolith.report import series

    for part in (30, 70, 110, 1000):
        monkeypatch.setattr(loop_run, "PART", part)
        for limit in (4, 7, 50, 599):
            line = series.thinned(run, lambda one: {"felt": one.felt_force[:, 0]}, limit)["felt"]
            x, y = series.decimate(run.time, run.felt_force[:, 0], limit)
            np.testing.assert_array_equal((line.x, line.y), (x, y))
            assert len(x) <= limit


def test_what_is_interrupted_leaves_nothing_and_looks_like_no_run_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(loop_run, "PART", 1000)
    seen = tmp_path / "seen.h5"

    def half() -> None:
        with files.run_file(tmp_path / "run.h5") as keep:
            try:
                simulated(keep, stop_at=0.6)
            finally:
                (unfinished,) = tmp_path.iterdir()
                assert unfinished.stat().st_size > 10_000
                shutil.copy(unfinished, seen)

    with pytest.raises(KeyboardInterrupt):
        half()
    with pytest.raises(CorruptFile, match="is no otolith-run file"):
        files.read_run(seen)
    seen.unlink()
    assert not list(tmp_path.iterdir())


@POSIX
def test_a_disk_that_fills_up_is_one_sentence_and_leaves_nothing(tmp_path: Path) -> None:
    """The HDF5 library would crash the process; 200 kB stand for a full disk."""
    code = (
        "from pathlib import Path\n"
        "from otolith import files\n"
        "from otolith.loop import run\n"
        "from tests.test_stored import simulated\n"
        "run.PART = 1000\n"
        "with files.run_file(Path('run.h5')) as keep:\n"
        "    simulated(keep)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[1]), *sys.path])},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 1, ended.stderr
    assert "NotWritten: run.h5 could not be written: File too large; nothing half-" in ended.stderr
    assert not list(tmp_path.iterdir())
