"""What the thesis may have counted as one false cue in Tables 5.3 and 5.4."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from otolith.core.arrays import Bools
from otolith.metrics.false_cues import spans
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import Closed, Loop
from otolith_thesis.model_tables import READINGS, best_constant
from otolith_thesis.outcome import Bearing, Cell, Claim, Grid, Outcome
from otolith_thesis.published import Row, published
from otolith_thesis.studies.common import PAIR, bearing

THRESHOLDS: Final = (0.05, 0.1, 0.17, 0.3, 0.5)  # [m/s²] least mismatch
SHORTEST: Final = (0.05, 0.3)  # [s] shortest duration of a false cue
TABLES: Final = ("table-5.3", "table-5.4")


def _loops() -> list[tuple[Loop, int]]:
    """Return each loop with its published count: the best constant weights, then the adaptive ones."""
    best, adaptive = (published(table).rows for table in TABLES)
    return [
        *((Loop(scenario=s, washout=best_constant(s, READINGS[0])), n) for s, n in _counts(best)),
        *((Loop(scenario=s), n) for s, n in _counts(adaptive)),
    ]


def _counts(rows: Sequence[Row]) -> list[tuple[str, int]]:
    return [(row["scenario"], row["false_cues"]) for row in rows]


def jobs() -> list[Loop]:
    """Return the loops of both tables."""
    return [loop for loop, _ in _loops()]


def _heads() -> list[tuple[str, str]]:
    """Return signal and number of the table, in the order of the loops."""
    return [
        (row["scenario"], table.removeprefix("table-")) for table in TABLES for row in published(table).rows
    ]


def _by_mismatch(closed: Closed, threshold: float, shortest: float) -> int:
    """Count stretches of at least this duration in which felt and wanted differ by the threshold or more."""
    motion = closed.motion[PAIR]
    apart: Bools = np.abs(motion.felt - motion.wanted) >= threshold
    lasting = [float(motion.time[stop - 1] - motion.time[first]) for first, stop in spans(apart)]
    return sum(time >= shortest for time in lasting)


def study(answers: Answers) -> Outcome:
    """Compare ten definitions of a false cue with eighteen published counts."""
    loops = _loops()
    printed = [count for _, count in loops]
    found = {
        (threshold, shortest): [_by_mismatch(answers[loop], threshold, shortest) for loop, _ in loops]
        for threshold in THRESHOLDS
        for shortest in SHORTEST
    }
    equal = {key: sum(a == b for a, b in zip(ours, printed, strict=True)) for key, ours in found.items()}
    best = max(equal, key=equal.__getitem__)
    rows: list[tuple[Cell, ...]] = [
        (*head, printed[k], *(ours[k] for ours in found.values())) for k, head in enumerate(_heads())
    ]
    return Outcome(
        name="study-false-cues",
        kind="study",
        title="No threshold on the mismatch gives the thesis’s numbers of false cues",
        section="5.2.4",
        text=(
            "The thesis counts false cues and does not say what one is. Tried: stretches in which felt and "
            "wanted force differ by a threshold or more, for at least so long, in the runs of Tables 5.3 "
            "(constant weights) and 5.4 (adaptive)."
        ),
        claims=(
            Claim(
                text="One definition gives all the published counts",
                holds=equal[best] == len(printed),
                figures=f"at best {equal[best]} of {len(printed)}, {best[0]:g} m/s² for {best[1]:g} s",
            ),
        ),
        grids=(
            Grid(
                title="False cues by threshold [m/s²] and shortest duration [s]",
                header=("signal", "table", "published", *(f"{t:g}, {d:g}" for t, d in found)),
                rows=(*rows, ("equal", "", len(printed), *equal.values())),
            ),
        ),
        bears_on=bearing(TABLES, equal[best] == len(printed), Bearing.EXPLAINS),
    )
