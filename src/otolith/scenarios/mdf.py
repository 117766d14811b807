"""Measurement data of ASAM MDF, versions 3 and 4, through asammdf (extra `logs`)."""

import logging
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
from asammdf import MDF
from asammdf.blocks.utils import MdfException

from otolith.core.errors import CorruptFile
from otolith.scenarios.channels import Layout
from otolith.scenarios.columns import recognise
from otolith.scenarios.recorded import Columns, Signal, with_own_clocks

logging.getLogger("asammdf").disabled = True  # what it logs of a damaged file comes as one sentence of ours


def read_mdf(path: Path, wanted: Callable[[str], bool]) -> Columns:
    """The channels of an MDF file whose name is `wanted`, each on its own clock.

    Raises
    ------
    CorruptFile : asammdf cannot read it.
    InputError : no such channel has two samples, or they have no time in common.
    """
    try:
        with MDF(path) as file:
            signals = [
                _signal(file, name, group, index)
                for name, places in file.channels_db.items()
                for group, index in places
                if wanted(name) and not _is_clock(name)
            ]
    except (MdfException, OSError, ValueError, struct.error) as error:
        raise CorruptFile(f"{path.name} is damaged or no MDF file: {error}") from error
    numeric = [s for s in signals if np.issubdtype(s.values.dtype, np.number)]
    return with_own_clocks(path.name, numeric, Layout(form="MDF"))


def _signal(file: MDF, name: str, group: int, index: int) -> Signal:
    channel = file.get(name, group=group, index=index)
    return Signal(name, channel.unit or "", np.asarray(channel.timestamps), np.asarray(channel.samples))


def _is_clock(name: str) -> bool:
    """Every channel comes with its clock; a channel that is one would be a second."""
    told = recognise(name)
    return told is not None and told[0] == "t"
