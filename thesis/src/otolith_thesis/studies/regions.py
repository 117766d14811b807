"""What the thesis counts as a region: the least thickness, the range of the parameters, overlaps."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from otolith.cueing.mpc.explicit_problem import UNLIMITED
from otolith.mpqp import Verification, enumerate_regions, verify
from otolith_thesis.explicit import Case, cases, constrained_limits
from otolith_thesis.jobs import Answers
from otolith_thesis.outcome import Bearing, Claim, Grid, Outcome
from otolith_thesis.published import published
from otolith_thesis.regions import (
    CHOSEN,
    DEFINITIONS,
    OPEN,
    TOOLBOX,
    counts,
    law_of,
    open_settings,
    overlapping,
)
from otolith_thesis.studies.common import bearing

TABLES: Final = ("table-5.2", "table-c.1", "table-c.3")
NEAR: Final = 0.05  # largest relative difference that counts as agreement of a number of regions
# Rows without limits on the inputs
OPEN_ROWS: Final = ("states but velocity", "states but velocity, stringent")
REACHES: Final = (UNLIMITED, 100.0, OPEN, 2.0 * OPEN)  # [m/s]
SAMPLES: Final = 20_000

# --- the least thickness of a region


def tolerance_jobs() -> list[Case]:
    """Return all rows whose published count is exact and not a lower bound."""
    return [case for table in TABLES for case in cases(table) if not case.printed.get("more_than")]


def tolerance(answers: Answers) -> Outcome:
    """Find the one definition that brings all counts near the published ones."""
    jobs = tolerance_jobs()
    found = {job: answers[job]["counts"] for job in jobs}
    worst = {
        one.label: max(abs(found[job][one.label] / job.printed["regions"] - 1.0) for job in jobs)
        for one in DEFINITIONS
    }
    in_box = {one.label: worst[one.label] for one in DEFINITIONS if not one.own_units}
    return Outcome(
        name="study-tolerance",
        kind="study",
        title="Regions are counted by the toolbox’s rule: a ball 1e-7 across, in the parameters’ own units",
        section="5.2.2, C.3, D.2",
        text=(
            "Every published count of Tables 5.2, C.1 and C.3 by several definitions of what is too thin to "
            "be a region. The Multi-Parametric Toolbox, with which the thesis computed them, takes a "
            "polyhedron as full-dimensional when its largest ball is 1e-7 across in the parameters’ units."
        ),
        claims=(
            _near("One radius relative to the parameters’ box brings every count within 5 %", in_box),
            _near(
                "The toolbox’s rule, 1e-7 across in SI units, brings every count within 5 %",
                {CHOSEN.label: worst[CHOSEN.label]},
            ),
        ),
        grids=(
            Grid(
                title="Regions by the least size of the largest ball in one: its radius in the parameters’ "
                "unit box, or its diameter in SI units",
                header=("case", "published", *worst),
                rows=(
                    *(
                        (f"{_short(job.table)}: {job.name}", job.printed["regions"], *found[job].values())
                        for job in jobs
                    ),
                    ("largest deviation", None, *(f"{100.0 * gap:.1f} %" for gap in worst.values())),
                ),
            ),
        ),
        bears_on=bearing(TABLES, worst[CHOSEN.label] <= NEAR, Bearing.ADOPTED),
    )


def _near(text: str, gaps: dict[str, float]) -> Claim:
    deviations = "; ".join(f"{label}: {100.0 * gap:.1f} %" for label, gap in gaps.items())
    return Claim(text=text, holds=min(gaps.values()) <= NEAR, figures=f"largest deviation with {deviations}")


def _short(table: str) -> str:
    return table.removeprefix("table-").upper()


# --- Table C.1 without limits on the inputs


@dataclass(frozen=True, slots=True)
class Reach:
    """One law of Table C.1 whose unlimited parameters are bounded by `reach`."""

    constraints: str
    reach: float  # [m/s] bound of the velocity; that of the reference follows from `open_settings`

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"law with limits on {self.constraints}, velocity up to {self.reach:g} m/s"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 1.0

    def run(self) -> dict[str, int]:
        """Count, by the toolbox's rule, regions and the active sets that overlap with them."""
        law = law_of(open_settings(self.reach), constrained_limits(self.constraints), finest=TOOLBOX)
        return {"regions": counts(law)[CHOSEN.label], "overlapping": overlapping(law)}


def reach_jobs() -> list[Reach]:
    """Return both rows at every reach."""
    return [Reach(constraints, reach) for constraints in OPEN_ROWS for reach in REACHES]


def open_parameters(answers: Answers) -> Outcome:
    """Show that Table C.1 without limits on the inputs needs unbounded parameters too."""
    printed = {row["constraints"]: row["regions"] for row in published("table-c.1").rows}
    found = {job: answers[job] for job in reach_jobs()}
    gap = {job: abs(one["regions"] / printed[job.constraints] - 1.0) for job, one in found.items()}
    within = {reach: max(gap[Reach(name, reach)] for name in OPEN_ROWS) for reach in REACHES}
    last = [found[Reach(name, reach)]["regions"] for name in OPEN_ROWS for reach in REACHES[-2:]]
    still = max(abs(last[k + 1] / last[k] - 1.0) for k in (0, 2))
    return Outcome(
        name="study-open-parameters",
        kind="study",
        title="Table C.1: what has no limit has regions far out, and the published counts include them",
        section="C.3.1",
        text=(
            "Without limits on velocity and inputs any velocity is feasible and any reference can be "
            f"followed. A law that covers velocities up to {UNLIMITED:g} m/s and references up to 100 m/s² "
            "lacks the regions beyond; from some reach on, nothing is added. The thesis names no bound."
        ),
        claims=(
            Claim(
                text=f"Parameters up to {UNLIMITED:g} m/s and 100 m/s² give the published counts within 5 %",
                holds=within[UNLIMITED] <= NEAR,
                figures=f"apart by up to {100.0 * within[UNLIMITED]:.1f} %",
            ),
            Claim(
                text="Parameters without a bound give them within 5 %",
                holds=within[OPEN] <= NEAR and still < 0.005,
                figures=f"apart by up to {100.0 * within[OPEN]:.1f} % at {OPEN:g} m/s; "
                f"twice as far changes the count by {100.0 * still:.2f} %",
            ),
        ),
        grids=(
            Grid(
                title="Regions by how far velocity [m/s] and reference [m/s²] reach",
                header=(
                    "limits on",
                    *(f"{reach:g}, {_reference(reach):g}" for reach in REACHES),
                    "published",
                ),
                rows=tuple(
                    (name, *(found[Reach(name, reach)]["regions"] for reach in REACHES), printed[name])
                    for name in OPEN_ROWS
                ),
            ),
        ),
        bears_on=bearing(["table-c.1"], within[OPEN] <= NEAR < within[UNLIMITED], Bearing.ADOPTED),
    )


def _reference(reach: float) -> float:
    return open_settings(reach).reference_bound


@dataclass(frozen=True, slots=True)
class Proof:
    """One law of Table C.1 verified against an independent QP."""

    constraints: str

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"proof of the law with limits on {self.constraints}"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 5.0

    def run(self) -> Verification:
        """Enumerate and verify the law."""
        law = law_of(open_settings(UNLIMITED), constrained_limits(self.constraints))
        fresh = enumerate_regions(law.problem)  # at the tolerance of all other laws
        return verify(fresh, SAMPLES, np.random.default_rng(0))


def overlap_jobs() -> list[Proof | Reach]:
    """Return the two rows without limits on the inputs: verifications, and overlapping sets."""
    return [
        *(Proof(name) for name in OPEN_ROWS),
        *(Reach(name, reach) for name in OPEN_ROWS for reach in (UNLIMITED, OPEN)),
    ]


def overlaps(answers: Answers) -> Outcome:
    """Test whether counting active sets that are optimal at the same parameter explains Table C.1."""
    printed = {row["constraints"]: row["regions"] for row in published("table-c.1").rows}
    proofs = {name: answers[Proof(name)] for name in OPEN_ROWS}
    sums = {
        (name, reach): sum(answers[Reach(name, reach)].values())
        for name in OPEN_ROWS
        for reach in (UNLIMITED, OPEN)
    }
    gaps = {key: value / printed[key[0]] - 1.0 for key, value in sums.items()}
    near = max(abs(gaps[name, UNLIMITED]) for name in OPEN_ROWS) <= NEAR
    return Outcome(
        name="study-overlaps",
        kind="study",
        title="Table C.1: overlapping regions do not explain the counts without limits on the inputs",
        section="C.3.1",
        text=(
            "Without limits on the inputs several active sets hold at the same parameter here and there. "
            "Ours count one of them, so that regions form a partition; that is checked at random parameters "
            "against an independent QP. Counted here: all sets that are optimal throughout a ball of the "
            "toolbox’s size."
        ),
        claims=(
            Claim(
                text=f"With overlapping regions, parameters up to {UNLIMITED:g} m/s give the published "
                "counts within 5 %",
                holds=near,
                figures=_gaps_at(gaps, UNLIMITED),
            ),
            Claim(
                text="With overlapping regions, open parameters come nearer than without",
                holds=all(
                    abs(gaps[name, OPEN]) < abs(answers[Reach(name, OPEN)]["regions"] / printed[name] - 1.0)
                    for name in OPEN_ROWS
                ),
                figures=_gaps_at(gaps, OPEN),
            ),
            Claim(
                text="Our partition leaves a hole, overlaps, or gives another input than the QP",
                holds=any(p.missing or p.max_overlap or p.max_law_error > 1e-6 for p in proofs.values()),
                figures="; ".join(
                    f"{p.missing} missing, {p.max_overlap} overlapping, error {p.max_law_error:.1e}"
                    for p in proofs.values()
                ),
            ),
        ),
        grids=(
            Grid(
                title="Regions of the partition, and further active sets that hold at the same parameters",
                header=(
                    "limits on",
                    "velocity up to [m/s]",
                    "regions",
                    "overlapping sets",
                    "together",
                    "published",
                ),
                rows=tuple(
                    (name, reach, *answers[Reach(name, reach)].values(), sums[name, reach], printed[name])
                    for name, reach in sums
                ),
            ),
        ),
        bears_on=bearing(["table-c.1"], near, Bearing.EXPLAINS),
    )


def _gaps_at(gaps: dict[tuple[str, float], float], reach: float) -> str:
    return "; ".join(f"{name}: {100.0 * gap:+.1f} %" for (name, far), gap in gaps.items() if far == reach)
