import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import files
from otolith.core.errors import InputError, MissingExtra
from otolith.scenarios import log_from
from otolith.scenarios.recorded import Channels, Signal, on_one_clock

FAST, SLOW = np.arange(0.0, 5.0, 0.01), np.arange(1.0, 4.0, 0.1)


def test_signals_of_several_clocks_are_put_on_the_fastest_where_all_run() -> None:
    channels = on_one_clock(
        "d.x", [Signal("ax", "m/s^2", FAST, 2.0 * FAST), Signal("ay", "g", SLOW, 0.3 * SLOW)]
    )
    log = log_from(channels)
    assert log.duration == pytest.approx(SLOW[-1] - SLOW[0], abs=0.011)
    assert_allclose(log.force[:, 0], 2.0 * (1.0 + log.t), atol=1e-9)
    assert_allclose(log.force[:, 1], 9.80665 * 0.3 * (1.0 + log.t), atol=1e-9)
    assert "d.x: 2 clocks, all signals put on the fastest by straight lines" in log.notes


@pytest.mark.parametrize(
    ("signals", "sentence"),
    [
        ([], "d.x is without a signal of at least 2 samples, must be a recorded drive"),
        (
            [Signal("ax", "", FAST[::-1], FAST)],
            "time of 'ax' in d.x is running backwards, must be increasing",
        ),
        (
            [Signal("ax", "", FAST, FAST), Signal("ay", "", FAST + 99.0, FAST)],
            "time that the signals of d.x have in common is none, must be at least 2 samples",
        ),
    ],
)
def test_signals_that_do_not_belong_together_are_refused(signals: list[Signal], sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        on_one_clock("d.x", signals)
    assert str(caught.value) == sentence


def channels(**values: np.ndarray) -> Channels:
    return Channels(
        source="d.x", names=tuple(values), units=("",) * len(values), values=tuple(values.values())
    )


def test_samples_are_named_in_errors() -> None:
    spoilt = FAST.copy()
    spoilt[6] = np.nan
    with pytest.raises(InputError, match=r"'ax' in sample 7 of d.x is nan, must be a finite number"):
        log_from(channels(t=FAST, ax=spoilt))
    with pytest.raises(InputError, match=r"number of samples in d.x is 1, must be at least 2"):
        log_from(channels(t=FAST[:1], ax=FAST[:1]))


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
    readers = ("otolith.scenarios.mdf", "otolith.scenarios.rosbag")
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
