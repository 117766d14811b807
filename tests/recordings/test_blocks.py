"""A text with a block for each channel gives each channel on its own clock."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith import files
from otolith.core.errors import InputError
from otolith.recordings.blocks import has_blocks, parse_blocks

HEAD = "PiToolboxVersionedASCIIDataSet\nVersion\t2\n\n{OutingInformation}\nCarName\tX\nFirstLapNumber\t0\n\n"


def block(name: str, rate: float, scale: float = 1.0, mark: str = ".") -> str:
    """Half a sine of 0.1 Hz, in the unit of the name."""
    t = np.arange(0.0, 20.0, 1 / rate)
    values = scale * np.sin(0.2 * np.pi * t)
    rows = "\n".join(f"{a:.3f}\t{b:.6f}".replace(".", mark) for a, b in zip(t, values, strict=True))
    return f"{{ChannelBlock}}\nTime\t{name}\n{rows}\n\n"


@pytest.mark.parametrize("mark", [".", ","])
def test_each_channel_keeps_its_rate_and_unit(tmp_path: Path, mark: str) -> None:
    text = HEAD + block("Acc Long[g]", 20, 1 / 9.80665, mark) + block("Acc Lat[m/s^2]", 50, 0.5, mark)
    (tmp_path / "pi.txt").write_text(text)
    log = files.read_log(tmp_path / "pi.txt", {})
    t = np.arange(0.5, 19.0, 0.1)
    wave = np.sin(0.2 * np.pi * t)
    assert_allclose(log.felt(t)[:, :2], np.c_[wave, 0.5 * wave], atol=0.002)


def test_time_in_another_unit_is_converted() -> None:
    text = (
        "{ChannelBlock}\nTime[ms]\tax[g]\n0\t1\n50\t2\n\n{ChannelBlock}\nTime[ms]\tay[g]\n0\t1\n20\t\n40\t3\n"
    )
    columns = parse_blocks(text, "pi.txt")
    assert columns.names == ("ax", "ay")
    assert columns.units == ("g", "g")
    assert_allclose(columns.clocks[1], [0.0, 0.02, 0.04])
    assert_allclose(np.asarray(columns.cells([1])[0], dtype=float), [1.0, np.nan, 3.0])


@pytest.mark.parametrize(
    ("second", "sentence"),
    [
        ("Time\tay\n0\t1\n0.1\n0.2\t2\n", "number of values in line 8 of pi.txt is 1, must be 2"),
        ("Time\tay\n0\t1\n0.1\tx\n", "cell in line 8 of pi.txt is 'x', must be a finite number"),
        ("Distance[m]\tay\n0\t1\n", "first column in line 6 of pi.txt is 'Distance[m]', must be time"),
        ("Time[m]\tay\n0\t1\n", "first column in line 6 of pi.txt is 'Time[m]', must be time"),
    ],
)
def test_damaged_blocks_are_refused_with_their_line(second: str, sentence: str) -> None:
    text = f"{{ChannelBlock}}\nTime\tax\n0\t1\n\n{{ChannelBlock}}\n{second}"
    with pytest.raises(InputError) as raised:
        parse_blocks(text, "pi.txt")
    assert sentence in str(raised.value)


def test_one_block_alone_is_a_table() -> None:
    assert not has_blocks(HEAD + block("Acc Lat[g]", 10))
