"""A virtual drive in any form of log reads back right, or is refused; `benchmarks/read_back.py` does more."""

from pathlib import Path

import numpy as np
import pytest

from otolith import files
from otolith.core.errors import OtolithError
from otolith.recordings import Log
from otolith.vehicle import Lap
from tests.recordings.mutilated import Form, Written, hockenheim, judge, put, random_form, truth, write


@pytest.fixture(scope="module")
def lap() -> Lap:
    return hockenheim()


def log_or_sentence(path: Path, written: Written) -> Log | str:
    try:
        return files.read_log(path, written.columns)
    except OtolithError as error:
        return str(error)


@pytest.mark.parametrize("part", range(10))
def test_what_is_read_is_the_truth_or_says_that_left_and_right_are_not_proven(
    part: int, lap: Lap, tmp_path: Path
) -> None:
    rng = np.random.default_rng(part)
    read = 0
    for _ in range(20):
        form, start = random_form(rng), float(rng.uniform(5.0, 150.0))
        drive = truth(lap, start, start + 40.0, 20.0)
        written = write(drive, form, rng)
        log = log_or_sentence(put(written, tmp_path), written)
        if isinstance(log, str):
            assert "\n" not in log
            continue
        outcome, read = judge(log, drive, written), read + 1
        reported = outcome == "mirrored" and any("not proven" in note for note in log.notes)
        assert outcome == "right" or reported, (outcome, form, log.notes)
    assert read > 5  # of 20: refusing everything is no way to be right


def test_a_plain_log_is_read_right_and_a_false_one_is_found(lap: Lap, tmp_path: Path) -> None:
    """The judge itself: it knows right from mirrored from wrong."""
    drive = truth(lap, 72.0, 94.0, 20.0)
    rng = np.random.default_rng(0)
    log = files.read_log(put(written := write(drive, Form(), rng), tmp_path), {})
    assert judge(log, drive, written) == "right"
    other = truth(lap, 80.0, 102.0, 20.0)
    assert judge(log, other, written).startswith("wrong: ax by")
    turned = write(drive, Form(axes="sae", vertical=False), rng)
    assert judge(files.read_log(put(turned, tmp_path), {}), drive, turned) == "mirrored"
