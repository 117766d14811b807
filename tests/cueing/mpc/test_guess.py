"""Hints of any quality in closed loop: the commands stay the same, and a missing hint is told."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.errors import InputError
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design, hybrid_law, hybrid_learned, hybrid_table
from otolith.cueing.hints.stored import Refused
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.guess import HeldPlan
from otolith.cueing.mpc.settings import BLOCKS, Entry, MpcSettings
from otolith.interfaces import Cueing, Status
from otolith.loop import Run, simulate
from otolith.plant import Ideal
from otolith.platforms import load
from otolith.qp.engines import CondensedEngine, StructuredEngine
from otolith.scenarios import scenario
from tests.cueing.hints.training.tiny import tiny_hint

THESIS, PAIRS = load("thesis"), (SURGE_PITCH,)
FORMS = {"full": MpcSettings(), "blocked": MpcSettings(horizon=sum(BLOCKS), blocks=BLOCKS)}


class Hostile:
    """Hints that nothing good can come of: random, all rows at once, alternating, of absurd values."""

    def __init__(self, shape: tuple[int, int], *, several: int = 1) -> None:
        self._rng, self._shape, self._turn = np.random.default_rng(8), (several, *shape), 0

    def reset(self) -> None:
        pass

    def sets(self, x: Vec, wanted: Vec, plan: Mat) -> Ints:
        self._turn += 1
        kinds = (
            self._rng.integers(-1, 2, self._shape),
            np.ones(self._shape, dtype=np.int64),
            np.where(np.indices(self._shape).sum(axis=0) % 2, 1, -1),
            np.full(self._shape, -(2**40)),
            np.zeros(self._shape, dtype=np.int64),
        )
        return np.ascontiguousarray(kinds[self._turn % len(kinds)], dtype=np.int64)


def drive(mpc: Cueing) -> Run:
    steps = scenario("step:amplitude=1.6,start=0.3,end=1.4,duration=2.5")
    return simulate(mpc, Ideal(), steps, platform=THESIS, dofs=("surge-pitch",), plant_period=0.01)


@pytest.mark.parametrize("engine", [StructuredEngine, CondensedEngine])
@pytest.mark.parametrize("form", FORMS)
def test_a_hostile_hint_changes_no_command(form: str, engine: type) -> None:
    settings = replace(FORMS[form], engine=engine)
    plain = Mpc(THESIS, PAIRS, settings)
    shape = (len(settings.lengths), plain.problem.structure.rows)
    several = 3 if engine is CondensedEngine else 1
    hinted = Mpc(THESIS, PAIRS, settings, hint=Hostile(shape, several=several))
    runs = [drive(plain), drive(hinted)]
    assert set(runs[1].status) == {Status.DECIDED}
    assert max(runs[1].residual) < 1e-6
    assert_allclose(runs[1].command, runs[0].command, atol=1e-6)


@pytest.mark.parametrize("make", [hybrid_learned, hybrid_law, hybrid_table])
def test_a_stored_hint_changes_no_command_either(make) -> None:
    mpc = make(Design(platform=THESIS, hint=tiny_hint()))
    plain = Mpc(THESIS, PAIRS, FORMS["full"])
    assert_allclose(drive(mpc).command, drive(plain).command, atol=1e-6)


def test_a_guess_as_working_set_changes_no_command() -> None:
    plain = Mpc(THESIS, PAIRS, FORMS["full"])
    guessed = Mpc(THESIS, PAIRS, FORMS["full"], guess=HeldPlan(), entry=Entry.WORKING_SET)
    assert_allclose(drive(guessed).command, drive(plain).command, atol=1e-6)


def test_a_refused_hint_is_missing_where_it_is_asked_for_and_none_at_all_is_refused() -> None:
    run = drive(hybrid_learned(Design(platform=THESIS, hint=Refused("it is stale"))))
    np.testing.assert_array_equal(run.guess_missed, run.changes > 0)
    assert run.guess_missed.any()
    assert set(run.status) == {Status.DECIDED}
    with pytest.raises(InputError, match="--hint is absent, must be a file of 'otolith hint build'"):
        hybrid_learned(Design(platform=THESIS))
