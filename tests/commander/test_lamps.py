"""The lamps of a live session: what is counted, how late packets are, and what is not known any more."""

from typing import Any

import numpy as np
import pytest

from otolith.commander.lamps import FRESH, Lamps
from otolith.live.core.parameters import Parameters
from otolith.live.messages import Plan, Vitals
from otolith.live.packed import pack_vitals, unpack_vitals
from otolith.live.recorder import SILENT_NS
from otolith.live.ring import Ring, room

PARAMETERS = Parameters(scale=0.1 + 0.2, liveliness=1e-300)
MS, S = 1_000_000, 1_000_000_000
COUNTS = ("missed", "gate_refused", "missed_lately", "refused_lately", "clock")


def vitals(time_ns: int, missed: int = 0, clock_ns: int | None = 0) -> Vitals:
    return Vitals(time_ns=time_ns, asked=np.zeros(3), missed=missed, clock_ns=clock_ns, parameters=PARAMETERS)


def plan(time_ns: int, outcome: str = "decided") -> Plan:
    return Plan(
        sequence=0,
        generation=0,
        time_ns=time_ns,
        period_ns=10 * MS,
        stages=np.zeros((1, 6)),
        telemetry_ns=time_ns - 3 * MS,
        outcome=outcome,
    )


@pytest.mark.parametrize("clock", [None, -(2**40), 17])
def test_what_the_controller_shows_comes_back_bit_for_bit(clock: int | None) -> None:
    asked = np.array([0.1, np.nan, -1e300])
    sent = Vitals(time_ns=2**40, asked=asked, missed=7, clock_ns=clock, parameters=PARAMETERS)
    back = unpack_vitals(pack_vitals(sent))
    assert (back.time_ns, back.missed, back.clock_ns, back.parameters) == (2**40, 7, clock, PARAMETERS)
    np.testing.assert_array_equal(back.asked, sent.asked)


def test_counts_are_of_the_whole_session_and_of_the_last_ten_seconds() -> None:
    lamps = Lamps()
    shown: list[dict[str, Any]] = []
    for second in range(25):
        lamps.vitals(vitals(second * S, missed=3 if second >= 5 else 0))
        lamps.plan(plan(second * S, "gate: leg 3" if second == 5 else "decided"))
        shown.append(lamps.shown(second * S))
    assert [one["missed"] for one in shown] == [0] * 5 + [3] * 20
    assert [one["missed_lately"] for one in shown] == [0] * 5 + [3] * 10 + [0] * 10
    assert [one["gate_refused"] for one in shown] == [0] * 5 + [1] * 20
    assert [one["refused_lately"] for one in shown] == [0] * 5 + [1] * 10 + [0] * 10


def test_what_a_controller_does_not_say_anew_is_unknown() -> None:
    lamps = Lamps()
    assert all(lamps.shown(0)[name] is None for name in (*COUNTS, "telemetry_age_s", "log"))
    lamps.vitals(vitals(S, missed=3))
    lamps.plan(plan(S))
    assert lamps.shown(S + FRESH)["missed"] == 3
    late = lamps.shown(S + FRESH + 1)
    assert all(late[name] is None for name in COUNTS)
    assert late["telemetry_age_s"] == pytest.approx(0.503)  # a silence grows; it is not unknown


def test_the_difference_and_the_drift_of_clocks_do_not_count_only_what_comes_late() -> None:
    lamps, rng = Lamps(), np.random.default_rng(4)
    base, drift = -(2**50), 100e-6  # another epoch, and 100 ppm
    late = []
    for k in range(6000):  # a minute at 100 Hz
        now = k * 10 * MS
        delay = 40 * MS if 3000 <= k < 3010 else int(rng.uniform(0.0, 0.2) * MS)
        lamps.vitals(vitals(now, clock_ns=base + delay + int(drift * now)))
        late.append(lamps.shown(now)["clock"])
    assert late[3000:3010] == [pytest.approx(0.04, abs=0.0025)] * 10
    assert max(late[:3000] + late[3010:]) < 0.0025  # 20 s of drift are 2 ms
    lamps.vitals(vitals(60 * S, clock_ns=None))
    assert lamps.shown(60 * S)["clock"] is None


def test_a_clock_that_was_set_anew_is_another_clock() -> None:
    lamps = Lamps()
    for k, offset in enumerate((0, 5 * MS, 3600 * S, 3600 * S + 2 * MS, -7 * S, -7 * S + 1 * MS)):
        lamps.vitals(vitals(k, clock_ns=offset))
        if k % 2 == 0:
            assert lamps.shown(k)["clock"] == 0.0
    assert lamps.shown(6)["clock"] == pytest.approx(0.001)


def test_the_log_is_told_by_who_writes_it() -> None:
    ring = Ring(memoryview(bytearray(room(64))), 64)
    lamps = Lamps([ring])
    ring.beat(S, 0)
    assert lamps.shown(S)["log"] == ""
    assert "has said nothing for 2 s" in lamps.shown(S + 2 * SILENT_NS)["log"]
    ring.beat(3 * S, 28)
    assert "No space left" in lamps.shown(3 * S)["log"]
    ring.beat(4 * S, 0)
    assert not ring.write(bytes(100))
    assert "1 ticks are missing" in lamps.shown(4 * S)["log"]
