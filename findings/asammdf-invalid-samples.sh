#!/bin/sh
# asammdf 8.8.28: samples that an MDF file marks as invalid become a straight line in to_dataframe and in CSV.
#
# An MDF 4 file may mark samples as invalid (invalidation bits). `MDF.get` leaves them out, `MDF.resample` keeps
# the marks. But `MDF.to_dataframe` and `MDF.export("csv")`, as they are called by default, join the neighbours of a
# stretch of invalid samples by a straight line: 20 s without a sensor come out as 2000 numbers, none of them NaN.
# With use_interpolation=False the dataframe holds NaN there. Who reads a drive through either should know.
#
# Run by hand. Exits 0 while this holds, 1 once it does not.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet "asammdf==8.8.28"
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import sys

import numpy as np
from asammdf import MDF, Signal

t = np.arange(0.0, 60.0, 0.01)
lost = (t >= 20.0) & (t < 40.0)
with MDF(version="4.10") as file:
    sensor = Signal(np.sin(t), t, name="sensor", invalidation_bits=lost)
    file.append([sensor, Signal(np.cos(t), t, name="other")], common_timebase=True)
    file.save("lost.mf4")
with MDF("lost.mf4") as file:
    got = len(file.get("sensor").samples)
    filled = file.to_dataframe(channels=["sensor", "other"])["sensor"]
    marked = file.to_dataframe(channels=["sensor", "other"], use_interpolation=False)["sensor"]
    kept = int(file.resample(0.01).get("sensor", ignore_invalidation_bits=True).invalidation_bits.sum())
inside = filled[(filled.index > 20.1) & (filled.index < 39.9)]
bend = float(np.abs(np.diff(inside, 2)).max())
print(f"of {len(t)} samples {int(lost.sum())} are invalid; get() gives {got}; resample keeps {kept} marks")
print(f"to_dataframe: {int(filled.isna().sum())} NaN, second differences within the dropout at most {bend:.1e}")
print(f"to_dataframe(use_interpolation=False): {int(marked.isna().sum())} NaN")
as_told = got == 4000 and kept == 2000 and not filled.isna().any() and bend < 1e-12 and marked.isna().sum() == 2000
sys.exit(0 if as_told else 1)
PYTHON
