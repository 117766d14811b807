"""The tables of the explicit MPC: regions, offline time, closed-loop RMSE (5.2, 5.8, C.1 to C.3, benchmark).

A row keeps the published values under their own names, and `Case.run` computes ours. Nothing is fitted: each
case is computed as printed, in the reading that `docs/readings.md` explains.
"""

import itertools
import math
from dataclasses import dataclass, replace
from typing import Any, Final

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.cueing.design import Design, explicit
from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.rows import BrakingRows, Limits
from otolith.loop import Run, simulate
from otolith.metrics import excesses, tracking_rmse
from otolith.mpqp import Law
from otolith.plant.ideal import Ideal
from otolith.platforms import load
from otolith.scenarios import scenario
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import rmse_at_decisions
from otolith_thesis.outcome import Claim, Grid, Outcome
from otolith_thesis.published import Row, published
from otolith_thesis.regions import (
    CHOSEN,
    FINEST,
    RULE,
    TOOLBOX,
    UNIT_BOX,
    counts,
    law_of,
    open_settings,
)
from otolith_thesis.verdict import Number, judged

REACH_4_DOF: Final = 0.35  # [m] reach per axis, which keeps both inside the limit circle (section 4.2.1)
DEGREE: Final = math.pi / 180.0
LONG: Final = {10: 45.0, 7: 10.0}  # [s] duration by horizon without blocking


@dataclass(frozen=True, slots=True)
class Case:
    """One row of a table of explicit laws."""

    table: str
    row: int

    @property
    def printed(self) -> Row:
        """Return the row as published."""
        return published(self.table).rows[self.row]

    @property
    def name(self) -> str:
        """Return the description of the row."""
        described = {key: self.printed[key] for key in _CASE_KEYS if key in self.printed}
        return ", ".join(str(v) if k in _WORDS else f"{_SAY[k]} {v}" for k, v in described.items())

    @property
    def label(self) -> str:
        """Return the text for the progress line."""
        return f"{self.table}: {self.name}"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        free = "block_from" not in self.printed and self.table == "table-5.2"
        return LONG.get(self.printed.get("horizon", 0), 1.5) if free else 1.5

    def run(self) -> Row:
        """Compute our values of the row."""
        return _CASES[self.table](self.printed)


def cases(table: str) -> list[Case]:
    """Return all rows of a table."""
    return [Case(table, row) for row in range(len(published(table).rows))]


def _size(law: Law) -> Row:
    """Return the number of regions by the toolbox's rule, in the unit box, and by all definitions."""
    found = counts(law)
    return {
        "regions": found[CHOSEN.label],
        "seconds": law.seconds,
        "in the unit box": found[UNIT_BOX.label],
        "counts": found,
    }


def _run(settings: ExplicitSettings, name: str, *laws: Law) -> Run:
    """Simulate the explicit controller alone on one scenario."""
    thesis = load("thesis")
    design = Design(platform=thesis, explicit=settings, stored_laws=laws)
    return simulate(
        explicit(design), Ideal(lag=0.0), scenario(name), platform=thesis, dofs=(SURGE_PITCH.name,)
    )


def _errors(run: Run, column: str) -> Row:
    """Return the RMSE [m/s²] at the decisions, as in the thesis, and over every sample of the plant."""
    return {
        column: rmse_at_decisions(run, SURGE_PITCH),
        f"{column}, every sample": float(tracking_rmse(run)[0]),
    }


def _move_blocking(row: Row) -> Row:
    settings = ExplicitSettings(horizon=row["horizon"], block_from=row.get("block_from"))
    law = law_of(settings, finest=TOOLBOX if row.get("more_than") else FINEST)
    return {**_size(law), **_errors(_run(settings, "sine-2", law), "rmse")}


def _four_dof(row: Row) -> Row:
    """Compute the 4 DOF law as two independent laws; the joint count is their product."""
    thesis = load("thesis")
    settings = ExplicitSettings(
        horizon=row["horizon"], period=row["period"], block_from=row.get("block_from")
    )
    parts = [law_of(settings, _within(thesis.limits(pair), REACH_4_DOF)) for pair in (SURGE_PITCH, SWAY_ROLL)]
    found = [counts(part)[CHOSEN.label] for part in parts]
    return {
        "parts": " × ".join(map(str, found)),
        "regions": math.prod(found),
        "seconds": sum(part.seconds for part in parts),
    }


def _within(limits: Limits, reach: float) -> Limits:
    """Return the limits of a pair with a travel of ± `reach` [m]."""
    travel, tilt = limits
    return replace(travel, position=(-reach, reach)), tilt


def constrained_limits(constraints: str) -> Limits:
    """Return the limits of one row of Table C.1."""
    travel, tilt = load("thesis").limits(SURGE_PITCH)
    slow_tilt = replace(tilt, velocity=math.pi * DEGREE)
    no_velocity = replace(travel, velocity=math.inf)
    position_only = replace(no_velocity, acceleration=math.inf)
    limits: dict[str, Limits] = {
        "states and a_tran": (travel, slow_tilt),
        "states and both inputs": (travel, replace(slow_tilt, acceleration=10.0 * DEGREE)),
        "states but velocity, and a_tran": (no_velocity, slow_tilt),
        "states but velocity": (position_only, slow_tilt),
        "states but velocity, stringent": (
            replace(position_only, position=(-0.4, 0.4)),
            replace(tilt, velocity=2.5 * DEGREE),
        ),
    }
    return limits[constraints]


def _constraints(row: Row) -> Row:
    return _size(law_of(open_settings(), constrained_limits(row["constraints"])))


def _braking(row: Row) -> Row:
    braking = ExplicitSettings(braking=BrakingRows.POSITION)
    return {
        **_errors(_run(ExplicitSettings(), row["scenario"]), "rmse_without"),
        **_errors(_run(braking, row["scenario"]), "rmse_with"),
    }


def _weights(row: Row) -> Row:
    on = row["weighted"]
    state_weights = (0.1,) * on + (0.0,) * (4 - on)
    return _size(law_of(ExplicitSettings(block_from=None, state_weights=state_weights)))


def _benchmark(row: Row) -> Row:
    """Compute the controller of eq. C.4, with wider limits, braking rows and limited tilt acceleration."""
    platform = load("benchmark")
    settings = ExplicitSettings(
        horizon=row["horizon"],
        block_from=row.get("block_from"),
        braking=BrakingRows.POSITION,
        control_weight=0.1,
    )
    design = Design(platform=platform, explicit=settings)
    run = simulate(
        explicit(design),
        Ideal(lag=0.0),
        scenario(row["scenario"]),
        platform=platform,
        dofs=(SURGE_PITCH.name,),
    )
    return {
        "regions": len(design.laws[0]),
        "seconds": design.laws[0].seconds,
        "rmse": float(tracking_rmse(run)[0]),
        "travel": float(abs(run.pose[:, 0]).max()),
        "violations": sum(excess.violations for excess in excesses(run)),
    }


_CASE_KEYS: Final = ("constraints", "scenario", "weighted", "horizon", "period", "block_from")
_WORDS: Final = ("constraints", "scenario")
_SAY: Final = {
    "weighted": "weighted states",
    "horizon": "N =",
    "period": "Ts =",
    "block_from": "blocked from",
}
_CASES: Final = {
    "table-5.2": _move_blocking,
    "table-5.8": _four_dof,
    "table-c.1": _constraints,
    "table-c.2": _braking,
    "table-c.3": _weights,
    "benchmark-c.2": _benchmark,
}
_FELT: Final = (
    "RMSE of the felt specific force [m/s²], the explicit MPC alone at 10 Hz: at its instants of decision, "
    "where its model has an output (eq. 4.1). Beside it over every sample of the plant."
)
_DIGITS: Final = {"regions": 0}
_JUDGED: Final = ("regions", "rmse", "rmse_without", "rmse_with")
_REASONS: Final = {
    "table-5.2": ("study-tolerance",),
    "table-c.1": ("study-open-parameters", "study-overlaps", "study-tolerance"),
    "table-c.3": ("study-tolerance",),
    "table-c.2": ("study-step", "study-explicit-signals"),
}


def table(name: str, answers: Answers) -> Outcome:
    """Build one table of explicit laws with our numbers."""
    printed = published(name)
    done = [(case, answers[case]) for case in cases(name)]
    numbers: list[Number] = []
    for column in _JUDGED:
        group = [_number(case, ours, column) for case, ours in done if column in case.printed]
        numbers += judged(group)
    by_row = sorted(numbers, key=lambda number: [case.name for case, _ in done].index(number.row))
    return Outcome(
        name=name,
        kind="table",
        title=printed.title,
        section=printed.section,
        text=RULE if any(number.column == "regions" for number in numbers) else _FELT,
        numbers=tuple(by_row),
        claims=tuple(_CLAIMS[name]([ours for _, ours in done])),
        grids=_rest(done),
        reasons=_REASONS.get(name, ()),
    )


def _number(case: Case, ours: Row, column: str) -> Number:
    bound = bool(case.printed.get("more_than")) and column == "regions"
    return Number(
        row=case.name,
        column=column,
        published=float(case.printed[column]),
        ours=float(ours[column]),
        digits=_DIGITS.get(column, 4),
        at_least=bound,
    )


def _rest(done: list[tuple[Case, Row]]) -> tuple[Grid, ...]:
    """Return what is not judged, if anything: times differ by machine and method, not by reading."""
    keys = list(dict.fromkeys(key for _, ours in done for key in ours if key not in (*_JUDGED, "counts")))
    minutes = any("minutes" in case.printed for case, _ in done)
    rows = [
        (
            case.name,
            *([case.printed.get("minutes")] if minutes else []),
            *(ours.get(key) for key in keys),
        )
        for case, ours in done
    ]
    header = ("case", *(["thesis: minutes"] if minutes else []), *(f"ours: {key}" for key in keys))
    return (Grid(title="Beside it", header=header, rows=tuple(rows)),) if len(header) > 1 else ()


# --- the thesis's statements about these tables


def _falls(rows: list[Row], key: str) -> tuple[bool, str]:
    values = [row[key] for row in rows]
    falling = all(b < a for a, b in itertools.pairwise(values))
    shown = (str(value) if isinstance(value, int) else f"{value:.4g}" for value in values)
    return falling, ", ".join(shown)


def _claims_5_2(rows: list[Row]) -> list[Claim]:
    free, blocked = rows[:3], rows[3:]
    better, rmse = _falls(blocked, "rmse")
    fewer = all(b["regions"] < 0.2 * f["regions"] for f, b in zip(free, blocked, strict=False))
    worse = all(b["rmse"] > f["rmse"] for f, b in zip(free, blocked, strict=False))
    pairs = [(f["regions"], b["regions"]) for f, b in zip(free, blocked, strict=False)]
    return [
        Claim(
            text="Move blocking reduces the regions drastically",
            holds=fewer,
            figures=", ".join(f"{f} to {b}" for f, b in pairs),
        ),
        Claim(text="It costs a little tracking at the same horizon", holds=worse, figures=rmse),
        Claim(text="Tracking improves with the horizon", holds=better, figures=f"blocked: {rmse}"),
    ]


def _claims_5_8(rows: list[Row]) -> list[Claim]:
    return [
        Claim(
            text="The blocked law at 0.1 s is far larger than the one at 0.25 s",
            holds=rows[1]["regions"] > 4 * rows[0]["regions"],
            figures=f"{rows[0]['regions']} against {rows[1]['regions']}",
        ),
        Claim(
            text="It cannot be computed",
            holds=False,
            figures=f"as two laws side by side, {rows[1]['parts']} regions, in {rows[1]['seconds']:.2f} s",
        ),
    ]


def _claims_c_1(rows: list[Row]) -> list[Claim]:
    regions = [row["regions"] for row in rows]
    return [
        Claim(
            text="More constraints, more regions",
            holds=regions[1] > regions[0] >= regions[2] > regions[3],
            figures=f"{', '.join(map(str, regions[:4]))}; in print 11131, 34887, 11120, 9239",
        ),
        Claim(
            text="Stricter limits cost more",
            holds=regions[4] > regions[3],
            figures=f"{regions[3]} to {regions[4]} regions; in print 9239 to 9182, in 9 % more time",
        ),
    ]


def _claims_c_2(rows: list[Row]) -> list[Claim]:
    gain = [row["rmse_without"] / row["rmse_with"] for row in rows]
    return [
        Claim(
            text="Braking constraints lower the error on every signal",
            holds=min(gain) > 1.0,
            figures=f"by a factor of {min(gain):.1f} to {max(gain):.1f}",
        )
    ]


def _claims_c_3(rows: list[Row]) -> list[Claim]:
    falling, regions = _falls(rows, "regions")
    return [Claim(text="Every further state weight lowers the count", holds=falling, figures=regions)]


def _claims_benchmark(rows: list[Row]) -> list[Claim]:
    return [
        Claim(
            text="The controller uses its rail and stays on it",
            holds=all(row["violations"] == 0 and row["travel"] <= 2.6 for row in rows),
            figures=", ".join(f"{row['travel']:.2f} m" for row in rows),
        )
    ]


_CLAIMS: Final[dict[str, Any]] = {
    "table-5.2": _claims_5_2,
    "table-5.8": _claims_5_8,
    "table-c.1": _claims_c_1,
    "table-c.2": _claims_c_2,
    "table-c.3": _claims_c_3,
    "benchmark-c.2": _claims_benchmark,
}
