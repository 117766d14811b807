"""Reads thousands of random logs of any vehicle, in any axes and units, and follows the remedies of refusals.

Vehicles, roads, channels, axes, units and events of `tests/scenarios/checks/anyones.py`. A log that is read
wrongly without a word, or a remedy that does not lead to the truth, is printed and makes the exit code 1.

Run from the repository: python benchmarks/log_physics.py [combinations] [seed]
"""

import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

from tests.recordings.checks.anyones import outcome, random_case

if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 5000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    found: Counter[str] = Counter()
    began, wrong = time.monotonic(), 0
    for k in range(count):
        case = random_case(np.random.default_rng([seed, k]))
        became = outcome(case)
        found[became.split(":")[0].split(" (")[0]] += 1
        if "wrong" in became:
            wrong += 1
            print(f"{k}: {case.what}\n    {became}", flush=True)
    print(f"{count} combinations in {time.monotonic() - began:.0f} s: {dict(found)}")
    sys.exit(1 if wrong else 0)
