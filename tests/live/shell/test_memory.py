"""Shared memory of one writer: messages come whole or not at all."""

import multiprocessing
import os
from multiprocessing.synchronize import Event

import numpy as np
import pytest

from otolith.live.messages import Plan, Report, Rung, State, Word
from otolith.live.packed import (
    pack_plan,
    pack_report,
    pack_words,
    unpack_plan,
    unpack_report,
    unpack_words,
)
from otolith.live.shell.memory import SIZE, SLOTS, Channel, WrongMemory


def name(what: str) -> str:
    return f"otolith-test-{os.getpid()}-{what}"


def test_the_latest_message_is_read_once() -> None:
    with Channel(name("latest"), create=True) as writer, Channel(name("latest")) as reader:
        assert reader.read() is None
        for k in range(10):
            writer.write(bytes([k]) * (k + 1))
        assert reader.read() == bytes([9]) * 10
        assert reader.read() is None


def test_a_slot_that_was_written_again_while_it_was_copied_is_not_believed() -> None:
    with Channel(name("torn"), create=True) as writer, Channel(name("torn")) as reader:
        writer.write(b"whole")
        counts = iter([1, 1 + SLOTS - 1])  # three messages came between the two looks at the counter
        kind = type("Slow", (Channel,), {"published": property(lambda _: next(counts))})
        reader.__class__ = kind
        assert reader.read() is None


def write_many(where: str, enough: Event) -> None:
    channel, k = Channel(where), 0
    while k % 1_000 != 0 or not enough.is_set():
        channel.write(k.to_bytes(8, "little") * (1 + k % 700))
        k += 1
    channel.close()


def test_no_message_is_torn_while_another_process_writes_as_fast_as_it_can() -> None:
    context = multiprocessing.get_context("spawn")
    enough = context.Event()
    with Channel(name("race"), create=True) as reader:
        writer = context.Process(target=write_many, args=(name("race"), enough))
        writer.start()
        found, last = 0, -1
        try:
            while writer.is_alive() or reader.published != reader._seen:
                message = reader.read()
                if message is not None:
                    k = int.from_bytes(message[:8], "little")
                    assert message == k.to_bytes(8, "little") * (1 + k % 700)
                    assert k > last
                    found, last = found + 1, k
                    if found == 300:
                        enough.set()
        finally:
            enough.set()
            writer.join()
        assert last == reader.published - 1


def give_signs(where: str, count: int) -> None:
    channel = Channel(where)
    for _ in range(count):
        channel.write(b"")
        channel.beat()
    channel.close()


def test_a_reader_never_sees_a_counter_that_is_half_written() -> None:
    with Channel(name("counters"), create=True) as reader:
        writer = multiprocessing.get_context("spawn").Process(
            target=give_signs, args=(name("counters"), 200_000)
        )
        writer.start()
        published = beats = 0
        while writer.is_alive():
            for _ in range(1_000):
                before, published = published, reader.published
                assert before <= published
                before, beats = beats, reader.beats
                assert before <= beats
        writer.join()
        assert (reader.published, reader.beats) == (200_000, 200_000)


def test_another_layout_and_a_message_too_long_are_refused() -> None:
    with Channel(name("layout"), create=True) as channel:
        with pytest.raises(WrongMemory, match="at most"):
            channel.write(b"x" * SIZE)
        channel.buffer[8] = 9
        with pytest.raises(WrongMemory, match="has layout"):
            Channel(name("layout"))


def test_plans_reports_and_words_come_back_as_they_were() -> None:
    rng = np.random.default_rng(0)
    for count in (0, 1, 1000):
        plan = Plan(
            sequence=7,
            generation=2,
            time_ns=10**18,
            period_ns=10_000_000,
            stages=rng.normal(size=(count, 6)),
            rung=Rung.FADE,
            reason="Größer als erlaubt: 5 m/s²",
            healthy=True,
            telemetry_ns=123,
            outcome="decided",
            residual=1e-9,
        )
        again = unpack_plan(pack_plan(plan))
        assert len(pack_plan(plan)) < SIZE - 8
        np.testing.assert_array_equal(again.stages, plan.stages)
        for field in ("sequence", "generation", "time_ns", "period_ns", "rung", "reason", "healthy"):
            assert getattr(again, field) == getattr(plan, field)
        assert (again.telemetry_ns, again.outcome, again.residual) == (123, "decided", 1e-9)
    report = Report(time_ns=5, motion=rng.normal(size=(3, 6)), state=State.HOLDING, generation=3, follows=8)
    back = unpack_report(pack_report(report))
    np.testing.assert_array_equal(back.motion, report.motion)
    assert (back.time_ns, back.state, back.generation, back.follows) == (5, State.HOLDING, 3, 8)
    assert unpack_words(pack_words((Word.REARM, Word.ARM))) == (Word.REARM, Word.ARM)
