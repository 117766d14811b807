import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import files
from otolith.core.errors import InputError, MissingExtra
from otolith.recordings import log_from
from otolith.recordings.channels import Layout
from otolith.recordings.recorded import Columns, Signal, with_own_clocks

FAST, SLOW = np.arange(0.0, 5.0, 0.01), np.arange(1.0, 4.0, 0.1)


MDF = Layout(form="MDF")


def test_signals_keep_their_clocks_and_the_drive_lasts_where_all_forces_run() -> None:
    signals = [Signal("ax", "m/s^2", FAST, 2.0 * FAST), Signal("ay", "g", SLOW, 0.3 * SLOW)]
    log = log_from(with_own_clocks("d.x", signals, MDF))
    assert log.duration == pytest.approx(SLOW[-1] - SLOW[0])
    assert len(log.channels["ax"].t) == len(FAST)
    assert_allclose(log.force[:, 0], 2.0 * (1.0 + log.t), atol=1e-9)
    assert_allclose(log.force[:, 1], 9.80665 * 0.3 * (1.0 + log.t), atol=1e-9)
    assert log.notes[0] == "d.x: 500 rows, 2.9 s, 100 Hz (others 10 Hz)"
    assert any(
        note.startswith("the drive lasts where all that is cued runs, 1 s to 3.9 s") for note in log.notes
    )


@pytest.mark.parametrize(
    ("signals", "sentence"),
    [
        ([], "d.x is without a signal of at least 2 samples, must be a recorded drive"),
        (
            [Signal("ax", "", FAST[::-1], FAST)],
            "time in sample 2 of d.x is -0.01 s after the first row, must be after the row before, 0 s",
        ),
        (
            [Signal("ax", "", FAST, FAST), Signal("ay", "", FAST + 99.0, FAST)],
            "time that ax and ay of d.x have in common is none, must be some, or leave one of them out with "
            "NAME=none",
        ),
    ],
)
def test_signals_that_do_not_belong_together_are_refused(signals: list[Signal], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        log_from(with_own_clocks("d.x", signals, MDF))
    assert str(caught.value) == sentence


def columns(**values: np.ndarray) -> Columns:
    return Columns(
        source="d.x", names=tuple(values), units=("",) * len(values), values=tuple(values.values())
    )


def test_samples_are_named_in_errors() -> None:
    spoilt = FAST.copy()
    spoilt[6] = np.inf
    with pytest.raises(InputError, match=r"'ax' in sample 7 of d.x is inf, must be a finite number"):
        log_from(columns(t=FAST, ax=spoilt))
    with pytest.raises(InputError, match=r"number of samples of 'ax' in d.x is 1, must be at least 2"):
        log_from(columns(t=FAST[:1], ax=FAST[:1]))


class Absent:
    """Lets an import find nothing, as where the library is not installed."""

    def __init__(self, library: str) -> None:
        self.library = library

    def find_spec(self, name: str, *_: object) -> None:
        if name == self.library:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


@pytest.mark.parametrize(
    ("name", "library"), [("d.mf4", "asammdf"), ("d.bag", "rosbags"), ("d.mcap", "rosbags")]
)
def test_a_format_whose_library_is_absent_is_one_sentence(
    name: str, library: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    readers = ("otolith.recordings.mdf", "otolith.recordings.rosbag")
    for loaded in [module for module in sys.modules if module.startswith((library, *readers))]:
        monkeypatch.delitem(sys.modules, loaded)
    monkeypatch.setattr(sys, "meta_path", [Absent(library), *sys.meta_path])
    (tmp_path / name).write_bytes(b"")
    with pytest.raises(MissingExtra, match=rf"needs {library}.*pip install 'otolith\[logs\]'"):
        files.read_log(tmp_path / name, {})


def test_a_dat_file_that_is_text_is_read_as_text(tmp_path: Path) -> None:
    path = tmp_path / "drive.dat"
    path.write_text("t_s ax_mps2\n0 1\n0.1 2\n0.2 3\n")
    assert_allclose(files.read_log(path, {}).force[:, 0], [1, 2, 3])
