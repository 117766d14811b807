"""Ring and recorder: nothing is half there, nothing is lost without being counted, and nobody waits."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from otolith.live.recorder import SILENT_NS, Recorder, lamp
from otolith.live.records import Records, record
from otolith.live.ring import LOST, Ring, room
from otolith.live.virtual_log import MemoryDisk


def made(capacity: int) -> Ring:
    return Ring(memoryview(bytearray(room(capacity))), capacity)


@given(
    steps=st.lists(st.integers(0, 90) | st.none(), max_size=60), capacity=st.integers(40, 300), data=st.data()
)
def test_a_ring_gives_what_had_room_in_order_and_counts_the_rest(
    steps: list[int | None], capacity: int, data: st.DataObject
) -> None:
    """Against a plain list: a number writes a record of so many bytes, None takes all that waits."""
    ring, model, lost, taken, unsaid = made(capacity), b"", 0, b"", 0
    for number, step in enumerate(steps):
        if step is None:
            taken += ring.take()
            model, room_left = b"", capacity
            continue
        chunk = record(2, bytes([number]) * step)
        said = record(LOST, struct.pack("<Q", unsaid)) if unsaid else b""
        room_left = capacity - len(model)
        fits = len(said + chunk) <= room_left
        assert ring.write(chunk) is fits
        if fits:
            model, unsaid = model + said + chunk, 0
        else:
            lost, unsaid = lost + 1, unsaid + 1
        assert (ring.filled, ring.lost) == (len(model), lost)
    taken += ring.take()
    found = list(Records(taken, "ring", {}, most=1000))
    kept = sum(one.kind == 2 for one in found)
    counted = sum(struct.unpack("<Q", one.payload)[0] for one in found if one.kind == LOST)
    assert kept + counted + unsaid == sum(step is not None for step in steps)


def test_a_ring_is_found_again_in_the_same_memory() -> None:
    memory = memoryview(bytearray(room(100)))
    with pytest.raises(ValueError, match="there is no ring"):
        Ring(memory)
    writer, reader = Ring(memory, 100), Ring(memory)
    writer.write(b"some bytes")
    assert reader.take() == b"some bytes"
    reader.beat(5, 28)
    assert (writer.filled, writer.heard_ns, writer.error) == (0, 5, 28)


@given(
    sizes=st.lists(st.tuples(st.integers(0, 1), st.integers(0, 40)), max_size=40), free=st.integers(0, 900)
)
def test_a_disk_that_fills_and_is_emptied_leaves_whole_records(
    sizes: list[tuple[int, int]], free: int
) -> None:
    """Two rings, a disk that takes a part of a record and then nothing for a while: no record is torn."""
    rings, disk = [made(10_000), made(10_000)], MemoryDisk(free=free)
    recorder = Recorder(rings, disk)
    written: dict[int, list[bytes]] = {0: [], 1: []}
    for n, (which, size) in enumerate(sizes):
        chunk = record(2 + which, bytes([n]) * size)
        rings[which].write(chunk)
        written[which].append(bytes([n]) * size)
        recorder.tick(n)
    recorder.tick(len(sizes))  # a disk that took a part refuses the rest now
    full = sum(len(record(2, one)) for which in written.values() for one in which) > free
    assert bool(lamp(rings, len(sizes))) == bool(full)
    disk.free = None
    recorder.tick(100)
    recorder.tick(101)
    assert lamp(rings, 101) == ""
    found = list(Records(bytes(disk.data), "disk", {}, most=1000))
    for which in (0, 1):
        assert [one.payload for one in found if one.kind == 2 + which] == written[which]


def test_the_lamp_names_a_full_disk_a_silent_recorder_and_what_is_missing() -> None:
    rings, disk = [made(100)], MemoryDisk(free=0)
    recorder = Recorder(rings, disk)
    rings[0].write(b"1" * 60)
    recorder.tick(1)
    assert lamp(rings, 2) == "the log: cannot be written: No space left on device; the platform goes on"
    rings[0].write(b"2" * 101)
    assert lamp(rings, 2 + 2 * SILENT_NS).endswith(
        "its recorder has said nothing for 2 s, 1 ticks are missing; the platform goes on"
    )
