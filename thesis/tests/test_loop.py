"""Closed loops as jobs: every variant runs, and changes what it says and nothing else."""

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from otolith.core.frames import SURGE_PITCH
from otolith.cueing.hints.training.fit import QUICK
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import Entry, MpcSettings
from otolith.interfaces import PlatformState, Reference
from otolith.loop import simulate
from otolith.metrics import tracking_rmse
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine
from otolith.qp.stage import StageProblem, StageSolution
from otolith_thesis.hint_loops import Hinted
from otolith_thesis.loop import FOUR_DOF, Loop, rmse_at_decisions
from otolith_thesis.solver_variants import QPOASES, Start, TerminalWeight

PAIR = "surge-pitch"
SHORT = Loop(scenario="step:amplitude=1,duration=1.5,start=0.2,end=1")


def test_equal_loops_are_one_job_and_travel_between_processes() -> None:
    assert pickle.loads(pickle.dumps(SHORT)) == SHORT
    assert len({SHORT, replace(SHORT), replace(SHORT, terminal=2.0)}) == 2


def test_the_parts_of_the_felt_force_add_up() -> None:
    closed = SHORT.run()
    motion = closed.motion[PAIR]
    assert np.allclose(motion.translation + motion.tilt_part, motion.felt)
    assert np.max(np.abs(motion.tilt_rate_deg)) <= 3.2
    rmse = np.sqrt(np.mean((motion.felt - motion.wanted) ** 2))
    assert rmse == pytest.approx(closed.rmse[PAIR], rel=0.05)  # nodes, not plant samples


@pytest.mark.parametrize("start", [Start.COLD, Start.SHIFTED])
def test_where_the_solver_starts_changes_its_effort_and_not_the_motion(start: Start) -> None:
    other, base = replace(SHORT, start=start).run(), SHORT.run()
    assert other.rmse[PAIR] == pytest.approx(base.rmse[PAIR], rel=1e-6)
    if start is Start.COLD:
        assert other.spread()["mean"] > 2.0 * base.spread()["mean"]


def test_the_thesiss_own_solver_gives_the_same_motion_and_prints_nothing(
    capfd: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip("casadi")
    brief = replace(SHORT, scenario="step:amplitude=1,duration=0.3,start=0.1,end=0.2")
    other = replace(brief, solver=QPOASES).run()
    assert other.unsolved == 0
    assert capfd.readouterr().out == ""
    assert other.rmse[PAIR] == pytest.approx(brief.run().rmse[PAIR], rel=1e-6)


def test_one_variant_changes_one_thing() -> None:
    fast = replace(SHORT, solver="structured")
    errors = {
        "base": fast.run().rmse[PAIR],
        "terminal": replace(fast, terminal=100.0).run().rmse[PAIR],
        "none": replace(fast, terminal=0.0).run().rmse[PAIR],
        "guess": replace(fast, cueing="hybrid-all").run().rmse[PAIR],
        "primal": replace(fast, cueing="hybrid-all", entry=Entry.PRIMAL).run().rmse[PAIR],
    }
    assert errors["primal"] == pytest.approx(errors["base"], rel=1e-3)
    assert len({round(errors[name], 6) for name in ("base", "terminal", "guess")}) == 3


def test_a_terminal_weight_weighs_the_last_stage_once_and_leaves_the_memory_as_it_was() -> None:
    """What a controller does not write anew in every period would else be weighted again and again."""
    seen = []

    class Weighed(CondensedEngine):
        def run(self, *arguments: Any, **options: Any) -> StageSolution:
            seen.append(self.memory.output[-1, 1])
            return super().run(*arguments, **options)

    def weighted(problem: StageProblem, **options: Any) -> TerminalWeight:
        return TerminalWeight(Weighed(problem, **options), 4.0)

    mpc = Mpc(load("thesis"), (SURGE_PITCH,), MpcSettings(engine=weighted))
    for _ in range(3):
        mpc.step(PlatformState(), Reference(specific_force=np.ones(3)))
        assert mpc.engine.memory.output[-1, 1] == 1.0
    assert seen == [2.0] * len(seen)  # of the acceleration, which every period has in common


def test_damping_draws_the_controls_to_the_plan_only_a_little() -> None:
    fast = replace(SHORT, solver="structured", damping=1e-4)
    for model in ("implicit", "implicit-trajectory", "hybrid-first", "hybrid-all"):
        damped = replace(fast, cueing=model).run()
        assert damped.unsolved == 0
        free = replace(fast, cueing=model, damping=0.0).run()
        assert damped.rmse[PAIR] == pytest.approx(free.rmse[PAIR], rel=0.05)


def test_the_platform_takes_another_circle_and_other_braking_times() -> None:
    four = replace(SHORT, dofs=FOUR_DOF, circle=0.25, braking_times=(3.0, 0.7))
    assert four.platform.circle == 0.25
    assert (four.platform.braking.position_s, four.platform.braking.tilt_s) == (3.0, 0.7)
    explicit = replace(
        SHORT,
        cueing="explicit",
        braking_times=(3.0, 0.5),
        explicit=ExplicitSettings(braking=BrakingRows.POSITION),
    )
    assert explicit.run().unsolved == 0


def test_a_certified_guess_keeps_the_motion() -> None:
    hinted = Hinted(
        dofs=SHORT.dofs, washout=SHORT.washout, scenarios=(SHORT.scenario,), every=60, effort=QUICK
    )
    (found,) = hinted.run().values()
    assert found.rmse[PAIR] == pytest.approx(SHORT.run().rmse[PAIR], rel=1e-6)
    assert found.unsolved == 0


def test_at_its_decisions_a_controller_without_lag_has_the_error_of_its_own_model() -> None:
    """The output of eq. 4.1 from what was commanded, with the tilt integrated here."""
    loop = replace(SHORT, cueing="explicit", scenario="sine:amplitude=1,duration=3,start=0.5")
    run = simulate(loop.controller(), Ideal(lag=0.0), loop.reference, platform=loop.platform, dofs=loop.dofs)
    T, tilt, rate, errors = run.period, 0.0, 0.0, []
    for t, command in zip(run.command_time, run.command, strict=True):
        wanted = float(loop.reference.specific_force(np.array([t]))[0, 0])
        errors.append(command[0] + 9.81 * np.sin(tilt) - wanted)
        tilt, rate = tilt - T * rate - 0.5 * T**2 * command[4], rate + T * command[4]
    expected = float(np.sqrt(np.mean(np.square(errors))))
    assert rmse_at_decisions(run, SURGE_PITCH) == pytest.approx(expected, rel=2e-3)
    assert abs(tracking_rmse(run)[0] / expected - 1.0) > 5e-3  # over every sample it is another
