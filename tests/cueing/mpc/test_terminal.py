"""The certified sets of platforms, and that they are what the MPCs keep."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from otolith.core.errors import InputError
from otolith.core.frames import DOFS, SURGE_PITCH, SWAY_ROLL
from otolith.cueing.mpc.axis_sets import axis_sets
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.predictive import predictive_settings
from otolith.cueing.mpc.problem import Problem
from otolith.cueing.mpc.rows import BrakingRows
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.terminal import CIRCLE, TerminalSets, digest
from otolith.interfaces import PlatformState, Reference, Status
from otolith.platforms import Platform, catalog, load, parse_platform
from otolith.safety.invariant.contraction import cells, certified_ahead
from otolith.safety.law import move

RIG = """
name = "rig"
surge = {{ position_m = 0.1, velocity_mps = 0.5, acceleration_mps2 = 4.0 }}
pitch = {{ angle_deg = 10.0 }}
yaw = {{ angle_deg = 10.0{yaw} }}
{more}
"""


def rig(yaw: str = "", more: str = "") -> Platform:
    return parse_platform(RIG.format(yaw=yaw, more=more), "rig.toml")


@pytest.mark.parametrize("name", catalog())
@pytest.mark.parametrize("braking", list(BrakingRows))
def test_the_sets_of_shipped_platforms_are_proved_whatever_slows_the_axes(
    name: str, braking: BrakingRows
) -> None:
    sets = TerminalSets.of(load(name), braking, period=0.01)
    judged = sets.check()
    assert set(judged) == {
        axis for dof in DOFS.values() if load(name).can_cue(dof) for axis in dof.name.split("-")
    }
    assert all(one.passed for one in judged.values())


def test_adversaries_get_nowhere_on_a_platform_with_a_circle() -> None:
    tried = TerminalSets.of(load("davsi-4dof"), BrakingRows.STOPPING, period=0.01).tried(
        states=200, steps=60, seed=2
    )
    assert set(tried) == {"surge", "pitch", "sway", "roll", CIRCLE}
    assert all(one.passed and one.outermost > 1.0 - 1e-9 for one in tried.values())


@pytest.mark.parametrize("name", ["thesis", "davsi"])
def test_the_rows_of_the_default_mpc_are_those_of_the_sets(name: str) -> None:
    """Every hard row of the stage problem is a row of a set: so whoever keeps them can do so for ever."""
    pairs = (SURGE_PITCH, SWAY_ROLL)
    platform = load(name)
    of = Problem(platform, pairs, MpcSettings(horizon=4))
    sets = TerminalSets.of(platform, BrakingRows.STOPPING, period=0.01)
    for dof, own in zip(pairs, of._rows, strict=True):
        columns = {dof.name.split("-")[0]: [3, 2, 4], dof.name.split("-")[1]: [1, 0, 5]}  # p, v, a
        for row in own:
            (axis,) = [axis for axis, at in columns.items() if row.coefficients[at].any()]
            proved = sets.axes[axis]
            here = np.abs(proved.forms - row.coefficients[columns[axis]]).max(axis=1) < 1e-12
            assert (row.lower, row.upper) in [
                (proved.lower[i], proved.upper[i]) for i in np.flatnonzero(here)
            ]
    assert of.circle is not None
    assert of.circle.weights[[1, 0, 2]] == pytest.approx(sets.axes["surge"].forms[-1], abs=1e-12)
    assert sets.axes["sway"].forms[-1] == pytest.approx(sets.axes["surge"].forms[-1], abs=1e-12)


def test_surge_and_sway_with_different_wedges_are_not_proved_together() -> None:
    """The circle holds one and the same z of both."""
    sets = TerminalSets.of(load("thesis"), BrakingRows.STOPPING, period=0.01)
    other = TerminalSets.of(load("thesis"), BrakingRows.LEADING, period=0.01)
    mixed = replace(sets, axes={**sets.axes, "sway": other.axes["sway"]}, braking=BrakingRows.LEADING)
    judged = mixed.check()
    assert {name for name, one in judged.items() if not one.passed} == {"surge", "sway"}


def test_only_axes_that_can_be_cued_have_sets() -> None:
    assert set(TerminalSets.of(rig(), BrakingRows.STOPPING, period=0.01).axes) == {"surge", "pitch"}
    whole = rig(", rate_degps = 20.0, acceleration_degps2 = 100.0")
    sets = TerminalSets.of(whole, BrakingRows.STOPPING, period=0.01)
    assert set(sets.axes) == {"surge", "pitch", "yaw"}
    with pytest.raises(ValueError, match="not of the axes"):
        replace(sets, platform=rig())


def test_a_braking_law_that_no_motion_keeps_is_refused_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    """No platform within the bounds of a file is known to have one: so the search is made to fail."""
    monkeypatch.setattr("otolith.cueing.mpc.axis_sets.certified_ahead", lambda axes, least: None)
    expected = r"the braking law of surge-pitch is 2\.5 s, must be so slow that an axis with a lag of 0\.01 s"
    with pytest.raises(InputError, match=expected):
        axis_sets(rig(), SURGE_PITCH, BrakingRows.STOPPING, lag=0.01, period=0.01)


def test_the_digest_is_that_of_all_a_platform_is() -> None:
    platform = load("davsi")
    assert digest(platform) == digest(load("davsi")) != digest(load("davsi-4dof"))
    longer: dict[str, Any] = {"description": "another"}
    assert digest(platform.model_copy(update=longer)) != digest(platform)


def settings_of(kind: str, platform: Platform) -> MpcSettings:
    """The thesis's horizon without blocks, or that of `predictive` with them."""
    plain = MpcSettings()
    return plain if kind == "full" else predictive_settings(plain, platform, (SURGE_PITCH,), 0.5)


def fallbacks(kind: str, monkeypatch: pytest.MonkeyPatch, *, factor: float = 1.0) -> int:
    """Decisions without a solution, from vertices of the sets and under forces that want out.

    Parameters
    ----------
    factor : by which the wedges are shorter than proved, in the rows and in the states alike.
    """
    if factor < 1.0:
        monkeypatch.setattr(
            "otolith.cueing.mpc.axis_sets.certified_ahead",
            lambda axes, least: factor * (certified_ahead(axes, least) or 0.0),
        )
    platform, rng, count = load("thesis"), np.random.default_rng(4), 0
    mpc = Mpc(platform, (SURGE_PITCH,), settings_of(kind, platform))
    sets = axis_sets(platform, SURGE_PITCH, BrakingRows.STOPPING, lag=0.01, period=0.01)
    corners = [np.vstack([cell.vertices for cell in cells(one)]) for one in sets]
    for start in range(12):
        motion = np.zeros((3, 6))
        for axis, sign, of_axis in zip(SURGE_PITCH.axes, SURGE_PITCH.signs, corners, strict=True):
            motion[:, axis] = sign * (1.0 - 1e-9) * of_axis[start % len(of_axis)]
        mpc.reset(PlatformState(pose=motion[0], twist=motion[1], acceleration=motion[2]))
        for _ in range(8):
            state = PlatformState(
                pose=motion[0].copy(), twist=motion[1].copy(), acceleration=motion[2].copy()
            )
            wanted = np.array([rng.choice([-8.0, 8.0]), 0.0, 0.0])
            command = mpc.step(state, Reference(specific_force=wanted))
            count += command.outcome.status is not Status.DECIDED
            move(motion, command.acceleration, 0.01, 0.01)
    return count


@pytest.mark.parametrize("kind", ["full", "blocked"])
def test_from_every_state_of_the_sets_each_decision_has_a_solution(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With wedges of half the length, by which a platform can still stop, many have none."""
    assert fallbacks(kind, monkeypatch) == 0
    assert fallbacks(kind, monkeypatch, factor=0.5) > 10
