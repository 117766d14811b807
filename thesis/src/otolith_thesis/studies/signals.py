"""How long the thesis's step lasts, and how large its limit circle is."""

from typing import Final

import numpy as np

from otolith.cueing.mpc.explicit_problem import ExplicitSettings
from otolith.cueing.mpc.rows import BrakingRows
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import FOUR_DOF, Loop
from otolith_thesis.model_tables import ADAPTIVE_4
from otolith_thesis.outcome import Bearing, Cell, Claim, Grid, Outcome
from otolith_thesis.studies.common import ERRORS, bearing, cells, column, fit, rmse, row_of, signals

CIRCLES: Final = (0.25, 0.5)  # [m] radius as printed, and radius that reproduces the tables

# --- the duration of the step

_STEPS: Final = ("step-1", "step-2", "step-sine-0.5", "step-sine-1")
_EXPLICIT_STEPS: Final = ("step-0.5", "step-1", "step-2")
_BRAKING_LAW: Final = ExplicitSettings(braking=BrakingRows.POSITION)


def _step_loops(*, literal: bool) -> dict[tuple[str, str], Loop]:
    implicit = {("table-5.7", s): Loop(scenario=s, solver="structured", literal=literal) for s in _STEPS}
    explicit = {
        ("table-c.2", s): Loop(scenario=s, cueing="explicit", explicit=_BRAKING_LAW, literal=literal)
        for s in _EXPLICIT_STEPS
    }
    return implicit | explicit


def step_jobs() -> list[Loop]:
    """Return both readings of the step, implicit and explicit."""
    return [loop for literal in (False, True) for loop in _step_loops(literal=literal).values()]


def step(answers: Answers) -> Outcome:
    """Decide whether the "step signal (from 1-4 seconds)" lasts until 4 s or for 4 s."""
    keys = {"table-5.7": "implicit", "table-c.2": "rmse_with"}
    long, short = (_step_loops(literal=literal) for literal in (False, True))
    printed = [float(row_of(table, s)[keys[table]]) for table, s in long]
    ours = {"until 5 s": rmse(answers, long), "until 4 s": rmse(answers, short)}
    fits = {name: fit(values, printed) for name, values in ours.items()}
    rows: list[tuple[Cell, ...]] = [(name, f"{fits[name]:.3f}", *cells(v)) for name, v in ours.items()]
    return Outcome(
        name="study-step",
        kind="study",
        title="The step from 1 to 4 seconds lasts four seconds",
        section="5.1",
        text="The step as printed, until 4 s, against one until 5 s, on the implicit and the explicit MPC.",
        claims=(
            Claim(
                text="The tables fit a step until 4 s better",
                holds=fits["until 4 s"] < fits["until 5 s"],
                figures=", ".join(f"{value:.3f} {name}" for name, value in fits.items()),
            ),
        ),
        grids=(
            Grid(
                title="RMSE [m/s²]: Table 5.7 (iMPC) and Table C.2 (with braking)",
                header=("step", "fit", *(f"{s} ({table})" for table, s in long)),
                rows=(*rows, ("published", "", *cells(printed))),
            ),
        ),
        bears_on=bearing([*ERRORS, "table-c.2"], fits["until 5 s"] < fits["until 4 s"], Bearing.ADOPTED),
    )


# --- the limit circle of section 4.2


def _circle_loops(radius: float) -> dict[str, Loop]:
    return {
        s: Loop(scenario=s, dofs=FOUR_DOF, circle=radius, solver="structured") for s in ADAPTIVE_4.scenarios
    }


def circle_jobs() -> list[Loop]:
    """Return both radii on the signals of Tables 5.11 and 5.12."""
    return [loop for radius in CIRCLES for loop in _circle_loops(radius).values()]


def circle(answers: Answers) -> Outcome:
    """Decide whether √(s_x² + s_y²) ≤ 0.5² means a radius of 0.25 m, as printed, or 0.5 m."""
    printed = column("table-5.11") + column("table-5.12")
    fits = {}
    for radius in CIRCLES:
        loops = _circle_loops(radius)
        fits[radius] = fit(rmse(answers, loops) + rmse(answers, loops, "sway-roll"), printed)
    rows = tuple((f"{radius:g} m", *cells(rmse(answers, _circle_loops(radius)))) for radius in CIRCLES)
    return Outcome(
        name="study-circle",
        kind="study",
        title="Section 4.2: the limit circle has a radius of 0.5 m",
        section="4.2.1",
        text=(
            "Printed is √(s_x² + s_y²) ≤ 0.5², 0.25 m. The explicit law's box of 0.35 m is said to lie "
            "within the circle, which is so for 0.5 m only: its corner is at 0.495 m. The published errors "
            "alone do not decide."
        ),
        claims=(
            Claim(
                text="The box of 0.35 m lies within a circle of 0.25 m",
                holds=bool(np.hypot(0.35, 0.35) <= CIRCLES[0]),
                figures=f"its corner is at {np.hypot(0.35, 0.35):.3f} m",
            ),
            Claim(
                text="Tables 5.11 and 5.12 fit 0.25 m better",
                holds=fits[0.25] < fits[0.5],
                figures=f"{fits[0.25]:.3f} at 0.25 m, {fits[0.5]:.3f} at 0.5 m",
            ),
        ),
        grids=(
            Grid(
                title="RMSE along x [m/s²]",
                header=("radius", *signals("table-5.11")),
                rows=(*rows, ("published", *cells(column("table-5.11")))),
            ),
        ),
        bears_on=bearing(["table-5.11", "table-5.12"], fits[0.25] < 0.5 * fits[0.5], Bearing.EXPLAINS),
    )
