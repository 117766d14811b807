"""Writes a virtual lap in thousands of random forms of log and reads each back: right, refused, or wrong.

Forms, units, axes, clocks, preambles and gaps of `tests/scenarios/mutilated.py`. A log may be read right
within 1 % or refused; one in mirrored axes without any witness may be read if a note says that left and right
are not proven. Anything else is wrong, is printed, and makes the exit code 1.

Run from the repository: python benchmarks/read_back.py [combinations] [seed]
"""

import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from tests.recordings.mutilated import hockenheim, judge, put, random_form, truth, write

from otolith import files
from otolith.core.errors import OtolithError

if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 5000
    rng = np.random.default_rng(int(sys.argv[2]) if len(sys.argv) > 2 else 1)
    lap, began, wrong = hockenheim(), time.monotonic(), 0
    found: Counter[str] = Counter()
    refusals: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(count):
            form = random_form(rng)
            drive = truth(lap, start := float(rng.uniform(5.0, 150.0)), start + 40.0, 20.0)
            written = write(drive, form, rng)
            try:
                log = files.read_log(put(written, Path(folder)), written.columns)
            except OtolithError as error:
                found["refused"] += 1
                refusals[f"{form.axes}, {form.stated}: {str(error)[:60]}"] += 1
                continue
            outcome = judge(log, drive, written)
            reported = outcome == "mirrored" and any("not proven" in note for note in log.notes)
            found["mirrored, and reported" if reported else outcome.split(":")[0]] += 1
            if outcome != "right" and not reported:
                wrong += 1
                print(outcome, form, *log.notes, sep="\n    ")
    print(f"{count} combinations in {time.monotonic() - began:.0f} s: {dict(found)}")
    for reason, times in refusals.most_common(25):
        print(f"{times:6d} {reason}")
    sys.exit(1 if wrong else 0)
