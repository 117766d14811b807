"""Measurement data in ASAM MDF, versions 3 and 4, read through asammdf (extra `logs`)."""

import logging
import struct
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final

import asammdf
import numpy as np
from asammdf import MDF
from asammdf.blocks.utils import MdfException

from otolith.core.errors import CorruptFile, InputError
from otolith.recordings.channels import Layout
from otolith.recordings.columns import recognise
from otolith.recordings.recorded import Columns, Signal, with_own_clocks

logging.getLogger("asammdf").disabled = True  # damage is reported by one error of ours instead
# Quantities that a group of channels may be recorded over (ASAM MDF 4.1, cn_sync_type); only time is a clock.
TIME: Final = 1
MASTERS: Final = {2: "angle", 3: "distance", 4: "index"}


def read_mdf(path: Path, wanted: Callable[[str], bool]) -> Columns:
    """Read the channels of an MDF file that are wanted, each with its valid samples on its own clock.

    Samples whose invalidation bit is set are left out, so a dropout becomes a gap in the clock. Channels that
    are recorded over distance, angle or index have no time and are left out with a note.

    Parameters
    ----------
    wanted : returns whether a channel of this name is read.

    Raises
    ------
    CorruptFile : asammdf cannot read the file.
    InputError : no wanted channel has two samples over time.
    """
    try:
        with MDF(path) as file:
            read = [
                _signal(file, name, group, index)
                for name, places in file.channels_db.items()
                for group, index in places
                if wanted(name) and not _is_clock(name)
            ]
            layout = Layout(form=f"MDF {file.version}", rows=max((len(s.t) for s, _ in read), default=0))
    except (MdfException, OSError, ValueError, struct.error) as error:
        raise CorruptFile(f"{path.name} is damaged or no MDF file: {error}") from error
    numeric = [(s, master) for s, master in read if np.issubdtype(s.values.dtype, np.number)]
    timed = [s for s, master in numeric if master == TIME]
    left = {s.name: MASTERS.get(master, "something else") for s, master in numeric if master != TIME}
    if left and not timed:
        quantities = " and ".join(f"{name!r} over {over}" for name, over in left.items())
        raise InputError(
            f"channels of {path.name}", f"recorded without time: {quantities}", "recorded over time"
        )
    notes = tuple(
        f"{path.name}: {name!r} runs over {over}, not over time: left out" for name, over in left.items()
    )
    return with_own_clocks(path.name, timed, layout, notes)


def write_mdf(path: Path, tables: Mapping[str, Sequence[Signal]]) -> None:
    """Write tables as MDF 4, one group of channels for each; the signals of a table share its clock.

    Parameters
    ----------
    tables : by name. Texts are bytes of UTF-8.
    """
    with MDF(version="4.10") as file:
        for name, signals in tables.items():
            channels = [
                asammdf.Signal(one.values, one.t, name=one.name, unit=one.unit, encoding="utf-8")
                for one in signals
            ]
            file.append(channels, acq_name=name, common_timebase=True)
        file.save(path, overwrite=True, compression=2)


def _signal(file: MDF, name: str, group: int, index: int) -> tuple[Signal, int]:
    """Return a channel, and the code of the quantity that it is recorded over."""
    channel = file.get(name, group=group, index=index)  # without the samples that are marked as invalid
    metadata = channel.master_metadata
    t, values = np.asarray(channel.timestamps), np.asarray(channel.samples)
    return Signal(name, channel.unit or "", t, values), TIME if metadata is None else metadata[1]


def _is_clock(name: str) -> bool:
    """Return whether a channel is a clock, which every other channel carries already."""
    meaning = recognise(name)
    return meaning is not None and meaning[0] == "t"
