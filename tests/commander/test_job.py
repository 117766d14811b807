"""The worker's job by itself: parameters that are changed while it runs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from otolith.cli.commander_job import Runs, make_runs
from otolith.commander.schema import checked
from otolith.core.arrays import Mat
from otolith.core.errors import InputError

STEP = {"scenario": "step:amplitude=1.0,start=0.2,end=1.5,duration=3.0", "platform": "davsi"}


def job(folder: Path, **values: Any) -> Runs:
    chosen = {"cueing": "classical", **STEP, **values}
    return make_runs(folder, checked(chosen).model_dump(), lambda _: None, "run")


def pose(of: Runs) -> Mat:
    of.loops[0].advance(300)
    return of.loops[0].run().pose


def test_corner_frequencies_change_from_the_next_decision_on(tmp_path: Path) -> None:
    changed, steady = job(tmp_path), job(tmp_path)
    changed.loops[0].advance(100)
    changed.change("high_pass", 2.0)
    found, other = pose(changed), pose(steady)
    np.testing.assert_array_equal(found[:1000], other[:1000])
    assert np.abs(found - other).max() > 1e-3


def test_what_is_changed_before_the_first_decision_is_what_is_chosen(tmp_path: Path) -> None:
    changed, chosen = job(tmp_path), job(tmp_path, high_pass=1.5, low_pass=0.7)
    changed.change("high_pass", 1.5)
    changed.change("low_pass", 0.7)
    np.testing.assert_array_equal(pose(changed), pose(chosen))
    assert "--high-pass 1.5 --low-pass 0.7" in chosen.command


def test_what_no_algorithm_reads_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no algorithm of this run reads it"):
        job(tmp_path).change("liveliness", 0.9)
    with pytest.raises(InputError, match="would ignore it"):
        job(tmp_path, cueing="adaptive", high_pass=1.5)
