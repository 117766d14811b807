from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from otolith.loop import Run
from otolith.metrics.false_cues import KINDS, false_cues, spans, totals


def with_forces(run: Run, wanted: np.ndarray, felt: np.ndarray, axis: int = 0) -> Run:
    forces = [np.zeros((len(run.time), 3)) for _ in range(2)]
    for force, series in zip(forces, (wanted, felt), strict=True):
        force[:, axis] = series
    return replace(run, reference_force=forces[0], felt_force=forces[1])


@pytest.mark.parametrize(
    ("wanted", "felt", "kind"),
    [
        (1.0, -0.5, "inverted"),
        (0.0, 0.4, "unwanted"),
        (-0.1, 0.4, "unwanted"),
        (-1.0, 0.05, "missing"),
        (1.0, 0.5, "scaled"),
        (1.0, 1.5, "scaled"),
        (1.0, 0.9, None),  # not noticed
        (0.16, 0.19, None),  # on both sides of the threshold, but alike
        (0.15, -0.15, None),  # neither is a cue
    ],
)
def test_every_mismatch_has_one_kind(handmade: Run, wanted: float, felt: float, kind: str | None) -> None:
    n = len(handmade.time)
    cues = false_cues(with_forces(handmade, np.full(n, wanted), np.full(n, felt)))
    assert [cue.kind for cue in cues] == ([] if kind is None else [kind])


def test_a_cue_has_its_interval_peak_and_integral(handmade: Run) -> None:
    # wanted: 1 m/s² from 0.2 s to 0.6 s; felt: a ramp against it, −2.5 (t − 0.2), then nothing
    t = handmade.time
    inside = (t > 0.2 + 1e-9) & (t <= 0.6 + 1e-9)
    felt = np.where(inside, -2.5 * (t - 0.2), 0.0)
    missing, inverted = false_cues(with_forces(handmade, inside.astype(float), felt))
    assert (missing.kind, inverted.kind) == ("missing", "inverted")
    assert (missing.start, missing.end) == (pytest.approx(0.2), pytest.approx(0.26))  # |felt| < 0.17
    assert inverted.end == pytest.approx(0.6)
    assert inverted.peak == pytest.approx(2.0)
    # ∫ (1 + 2.5 s) ds from 0.06 to 0.4 by right-hand sums: 0.01 Σ over s = 0.07 … 0.40
    s = np.arange(7, 41) * 0.01
    assert inverted.integral == pytest.approx(0.01 * np.sum(1.0 + 2.5 * s))
    assert inverted.duration == pytest.approx(0.34)


def test_short_stretches_and_uncued_axes_are_left_out(handmade: Run) -> None:
    blip = np.zeros(len(handmade.time))
    blip[10:14] = 1.0  # 0.04 s
    assert false_cues(with_forces(handmade, 0.0 * blip, blip)) == []
    assert len(false_cues(with_forces(handmade, 0.0 * blip, blip), shortest=0.03)) == 1
    assert false_cues(with_forces(handmade, 0.0 * blip, blip + 1.0, axis=1)) == []
    both = replace(with_forces(handmade, 0.0 * blip, blip + 1.0, axis=1), dofs=("surge-pitch", "sway-roll"))
    assert [cue.dof for cue in false_cues(both)] == ["sway-roll"]


def test_totals_add_up_and_tell_kinds_that_did_not_occur(handmade: Run) -> None:
    wanted = np.zeros(len(handmade.time))
    felt = np.zeros_like(wanted)
    felt[10:20], felt[50:80] = 0.3, -0.6
    found = totals(false_cues(with_forces(handmade, wanted, felt)))
    assert found["unwanted"] == {
        "count": 2,
        "duration_s": pytest.approx(0.4),
        "peak": pytest.approx(0.6),
        "integral": pytest.approx(0.01 * (10 * 0.3 + 30 * 0.6)),
    }
    assert all(
        found[kind]["count"] == 0 and found[kind]["peak"] == 0.0 for kind in KINDS if kind != "unwanted"
    )


@settings(derandomize=True, max_examples=80)
@given(st.lists(st.booleans(), max_size=40))
def test_spans_cover_exactly_what_holds(condition: list[bool]) -> None:
    covered = [False] * len(condition)
    for first, stop in spans(np.array(condition, dtype=bool)):
        assert first < stop
        assert not any(condition[max(first - 1, 0) : first])
        assert not any(condition[stop : stop + 1])
        covered[first:stop] = [True] * (stop - first)
    assert covered == condition
