"""What a guess is, and which iterations count."""

from dataclasses import replace
from typing import Final

from otolith.cueing.mpc.settings import Entry
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import MODELS, Loop
from otolith_thesis.outcome import Bearing, Cell, Claim, Grid, Outcome
from otolith_thesis.solver_variants import QPOASES, Start, has_qpoases
from otolith_thesis.studies.common import COUNTED, ERRORS, PAIR, SMALL_SET, bearing, cells, row_of

LAMBDA: Final = 1e-4  # factor of the Levenberg-Marquardt term in Table D.1
SOLVED_BY_BOTH: Final = ("sine-1", "step-1")

# --- what a guess is


def guess_jobs() -> list[Loop]:
    """Return the four models with the guess as reference and as initial point."""
    return [Loop(scenario=s, cueing=m, entry=entry) for s in SMALL_SET for m in MODELS for entry in Entry]


def guess(answers: Answers) -> Outcome:
    """Show that a guess (eq. 3.1) is a reference in the cost, and has no effect as an initial point."""
    rows: list[tuple[Cell, ...]] = []
    moved, primal_moved = 0.0, 0.0
    for s in SMALL_SET:
        base = answers[Loop(scenario=s)]
        for m in MODELS[1:]:
            one, two = (answers[Loop(scenario=s, cueing=m, entry=e)] for e in (Entry.REFERENCE, Entry.PRIMAL))
            changes = [closed.spread()["mean"] for closed in (base, one, two)]
            errors = [closed.rmse[PAIR] for closed in (base, one, two)]
            moved = max(moved, abs(errors[1] / errors[0] - 1.0))
            primal_moved = max(primal_moved, abs(errors[2] / errors[0] - 1.0))
            rows.append((s, m, *(f"{c:.2f}" for c in changes), *cells(errors)))
    return Outcome(
        name="study-guess",
        kind="study",
        title="Eq. 3.1: the initial guess is a reference in the cost, and changes the answer",
        section="3.1",
        text=(
            "Eq. 3.1 puts the guess where the reference of the controls stands, weighted with R = 1e-3. The "
            "same guess as a mere start (the plan that is linearised about) leaves the problem as it is."
        ),
        claims=(
            Claim(
                text="As reference, the guess keeps the tracking (within 2 %)",
                holds=moved <= 0.02,
                figures=f"RMSE changes by up to {100 * moved:.0f} %",
            ),
            Claim(
                text="As a starting point, it keeps the tracking (within 2 %)",
                holds=primal_moved <= 0.02,
                figures=f"RMSE changes by up to {100 * primal_moved:.1f} %",
            ),
        ),
        grids=(
            Grid(
                title="Mean changes and RMSE [m/s²]",
                header=(
                    "signal",
                    "guess",
                    "changes, none",
                    "as reference",
                    "as start",
                    "RMSE, none",
                    "as reference ",
                    "as start ",
                ),
                rows=tuple(rows),
            ),
        ),
        bears_on=bearing(ERRORS, moved > 0.02 >= primal_moved, Bearing.ADOPTED),
    )


# --- how iterations are counted


def start_jobs() -> list[Loop]:
    """Return the implicit MPC with three starts of the solver."""
    return [Loop(scenario=s, start=start) for s in SMALL_SET for start in Start]


def start(answers: Answers) -> Outcome:
    """Show that the thesis's baseline was hot-started: a cold solver would need ten times its iterations."""
    means = {
        (s, one): answers[Loop(scenario=s, start=one)].spread()["mean"] for s in SMALL_SET for one in Start
    }
    printed = {s: float(row_of("table-5.5", s)["implicit"]) for s in SMALL_SET}
    cold = [means[s, Start.COLD] / printed[s] for s in SMALL_SET]
    return Outcome(
        name="study-start",
        kind="study",
        title="The thesis's iterations are those of a solver started from the previous working set",
        section="D.1",
        claims=(
            Claim(
                text="A cold start gives the published order of magnitude",
                holds=max(cold) < 5.0,
                figures="cold over published: " + ", ".join(f"{ratio:.1f}" for ratio in cold),
            ),
        ),
        grids=(
            Grid(
                title="Mean changes of the implicit MPC without a guess",
                header=("signal", *(f"start: {one.value}" for one in Start), "published (5.5)"),
                rows=tuple(
                    (s, *(f"{means[s, one]:.2f}" for one in Start), f"{printed[s]:.2f}") for s in SMALL_SET
                ),
            ),
        ),
        bears_on=bearing(COUNTED, max(cold) < 5.0, Bearing.EXPLAINS),
    )


def solver_jobs() -> list[Loop]:
    """Return the same loops with our dense solver and with the thesis's, if that is installed."""
    ours = [Loop(scenario=s, cueing=m) for s in SOLVED_BY_BOTH for m in ("implicit", "hybrid-all")]
    return ours + ([replace(loop, solver=QPOASES) for loop in ours] if has_qpoases() else [])


def solver(answers: Answers) -> Outcome:
    """Test whether another active-set method counts differently: the thesis's qpOASES, hot-started."""
    rows, ratios = [], []
    for s in SOLVED_BY_BOTH:
        for m in ("implicit", "hybrid-all"):
            ours = answers[Loop(scenario=s, cueing=m)].spread()["mean"]
            theirs = answers.get(Loop(scenario=s, cueing=m, solver=QPOASES))
            mean = theirs.spread()["mean"] if theirs is not None else None
            ratios += [mean / ours] if mean is not None else []
            rows.append((s, m, ours, mean, float(row_of("table-5.5", s)[m])))
    text = (
        "The same closed loops by `daqp` and by the thesis's qpOASES (through casadi), each hot-started."
        if ratios
        else "Not tried: qpOASES needs casadi, pip install 'otolith[check]'."
    )
    return Outcome(
        name="study-solver",
        kind="study",
        title="The solver does not explain the difference in iterations",
        section="D.1",
        text=text,
        claims=(
            Claim(
                text="qpOASES counts at least 1.5 times as many",
                holds=bool(ratios) and min(ratios) >= 1.5,
                figures="qpOASES over daqp: " + ", ".join(f"{ratio:.2f}" for ratio in ratios),
            ),
        )
        if ratios
        else (),
        grids=(
            Grid(
                title="Mean changes per step",
                header=("signal", "model", "daqp", "qpOASES", "published (5.5)"),
                rows=tuple(rows),
            ),
        ),
        bears_on=bearing(COUNTED, min(ratios) >= 1.5, Bearing.EXPLAINS) if ratios else {},
    )


def damping_jobs() -> list[Loop]:
    """Return the four models with and without ACADO's regularisation."""
    return [
        Loop(scenario=s, cueing=m, damping=value)
        for s in SMALL_SET
        for m in MODELS
        for value in (0.0, LAMBDA)
    ]


def damping(answers: Answers) -> Outcome:
    """Measure the effect of ACADO's Levenberg-Marquardt term, which draws controls to the previous plan."""
    rows: list[tuple[Cell, ...]] = []
    largest = 0.0
    for s in SMALL_SET:
        for value in (0.0, LAMBDA):
            means = [answers[Loop(scenario=s, cueing=m, damping=value)].spread()["mean"] for m in MODELS]
            rows.append((s, f"{value:g}", *(f"{mean:.2f}" for mean in means)))
            if value:
                before = [answers[Loop(scenario=s, cueing=m)].spread()["mean"] for m in MODELS]
                largest = max(largest, *(abs(a / b - 1.0) for a, b in zip(means, before, strict=True)))
    return Outcome(
        name="study-damping",
        kind="study",
        title="ACADO's regularisation does not explain the difference in iterations",
        section="D.1",
        text="Table D.1 names a Levenberg-Marquardt term of 1e-4, a tenth of the control weight.",
        claims=(
            Claim(
                text="It changes the mean iterations by half or more",
                holds=largest >= 0.5,
                figures=f"by at most {100 * largest:.0f} %",
            ),
        ),
        grids=(Grid(title="Mean changes per step", header=("signal", "λ", *MODELS), rows=tuple(rows)),),
        bears_on=bearing(COUNTED, largest >= 0.5, Bearing.EXPLAINS),
    )
