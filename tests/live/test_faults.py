"""The fault matrix in virtual time, and that it sees what is wrong."""

from dataclasses import replace

import numpy as np
import pytest

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design
from otolith.interfaces import Cueing
from otolith.live.core.gate import PASSES, Gate
from otolith.live.core.rollout import Rollout
from otolith.live.faults import CASES, ROWS, prepare, row_of, run_case, run_matrix
from otolith.live.faults.case import Result
from otolith.live.messages import State
from otolith.platforms import Platform
from otolith.registry import make_cueing

TICK = 4e-3  # [s] of the output: four times as fast to play as real operation


def account(result: Result) -> str:
    return f"{result.case.row} {result.case.fault}: expected {result.case.expected}, saw {result.seen}"


def test_every_fault_has_its_answer(washout: Cueing, machine: Platform) -> None:
    results = list(run_matrix(washout, machine, tick=TICK))
    assert [account(result) for result in results if not result.right] == []
    rows = {row_of(case) for case in CASES}
    assert rows == set(range(1, ROWS + 1))


def test_an_mpc_meets_the_faults_of_its_decisions(machine: Platform) -> None:
    mpc = make_cueing("implicit", Design(platform=machine, dofs=(SURGE_PITCH,)))
    cases = tuple(case for case in CASES if case.row in {"2c", "8a", "8c", "8f", "9b", "10"})
    results = list(run_matrix(mpc, machine, cases, tick=TICK))
    assert [account(result) for result in results if not result.right] == []


@pytest.mark.parametrize(("method", "kind"), [("follow", "speed"), ("brake", "speed"), ("plan", "")], ids=str)
def test_the_judge_sees_a_gate_that_does_not_work(
    method: str, kind: str, washout: Cueing, machine: Platform, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the gate in the controller, that of the output still holds; without that, limits are passed."""
    hostile = next(case for case in CASES if case.row == "8d")
    endless = replace(hostile, begin=lambda world: _hostile(world), seconds=1.0)
    _, engaged = prepare(washout, machine, tick=TICK)

    def lets_pass(self: Rollout, command: np.ndarray, dt: float) -> object:
        self.gate.move(self.motion, np.ascontiguousarray(command), dt)
        return PASSES

    monkeypatch.setattr(Gate, "plan", lambda *_: PASSES)
    if method == "follow":
        monkeypatch.setattr(Rollout, "follow", lets_pass)
    result = run_case(endless, engaged, machine)
    assert bool(result.violations) is (method == "follow")
    if method == "follow":
        assert any(kind in violation.what for violation in result.violations)


def _hostile(world: object) -> None:
    from otolith.live.faults.decisions import Failing, _too_strong

    world.controller.cueing = Failing(world.controller.cueing, _too_strong, 10**6)  # type: ignore[attr-defined]


def test_equal_seeds_give_equal_traces_bit_for_bit(washout: Cueing, machine: Platform) -> None:
    traces = []
    for _ in range(2):
        _, engaged = prepare(washout, machine, seed=3, tick=TICK)
        engaged.links["telemetry"].loss = engaged.links["telemetry"].corruption = 0.3
        engaged.run(engaged.seconds + 1.0)
        traces.append(np.array([row.motion for row in engaged.trace]))
    np.testing.assert_array_equal(traces[0], traces[1])
    assert engaged.state in {State.ENGAGED, State.HOLDING}
    assert np.abs(traces[0]).max() > 0.01


def test_the_motion_is_what_the_algorithm_predicted(washout: Cueing, machine: Platform) -> None:
    """The set-point one period after a decision is the pose that the decision's own model leads to."""
    _, engaged = prepare(washout, machine, tick=1e-3)
    engaged.run(engaged.seconds + 0.5)
    rows = {row.time_ns: row for row in engaged.trace}
    plan = engaged.plans[-20]
    begin = max(time_ns for time_ns in rows if time_ns <= plan.time_ns)
    motion = rows[begin].motion.copy()
    for k in range(10):
        engaged.gate.move(motion, plan.stages[0], 1e-3)
        found = rows[begin + (k + 1) * 1_000_000]
        if found.follows == plan.sequence:
            assert np.abs(found.motion[0] - motion[0]).max() < 5e-6
