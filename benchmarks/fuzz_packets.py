"""A million damaged packets of every format, of sources and of devices: each must give sound values or a
`WireError`, and keep no memory.

    python benchmarks/fuzz_packets.py [COUNT] [PART OF A NAME]

Prints for every format how many packets were read and refused, the mean time of each with its making, and
by how many blocks Python's memory has grown. Any other exception, or a number that is not finite, ends the
run with a traceback.
"""

import gc
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "src")]

from tests.live.wire.fuzz import FORMATS, Format, outcomes, sound  # noqa: E402

from otolith.live.wire.formats import WireError  # noqa: E402


def run(one: Format, count: int) -> None:
    """Damage packets of one format and print what came of them."""
    one.parse(one.packet)  # what is compiled on first use is no growth
    read, begin = 0, time.thread_time()
    gc.collect()
    blocks = sys.getallocatedblocks()
    for outcome in outcomes(one, count, seed=1):
        if not isinstance(outcome, WireError):
            if not sound(outcome):
                raise AssertionError(f"{one.name}: {outcome}")
            read += 1
    each = 1e6 * (time.thread_time() - begin) / count
    gc.collect()  # errors keep their frames until then
    grown = sys.getallocatedblocks() - blocks
    print(
        f"{one.name:20} read {read:8} refused {count - read:8} {each:5.1f} us  blocks {grown:+d}",
        flush=True,
    )


if __name__ == "__main__":
    for chosen in FORMATS:
        if sys.argv[2:] == [] or sys.argv[2] in chosen.name:
            run(chosen, int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
