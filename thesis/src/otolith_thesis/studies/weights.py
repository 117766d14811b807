"""Which states the washout weights act on, and the weight of the last stage."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from typing import Final

from otolith.cueing.mpc.washout_weights import PRESETS, WashoutWeight, constant
from otolith_thesis.jobs import Answers
from otolith_thesis.loop import Loop
from otolith_thesis.model_tables import ADAPTIVE_2
from otolith_thesis.outcome import Bearing, Claim, Grid, Outcome
from otolith_thesis.published import published
from otolith_thesis.studies.common import ERRORS, PAIR, bearing, cells, column, fit, rmse, signals

TERMINAL: Final = (0.0, 1.0, 10.0, 100.0)

# --- the states on which the washout weights of eq. 4.13 act

_SECOND: Final = ("tilt_rate", "tilt", "velocity")
_FOURTH: Final = ("position", "velocity", "tilt")
_RATE, _PLACE = PRESETS["printed"]


def _adaptive(
    first: str, second: str, *, in_degrees: bool = True, share: float = 1.0
) -> tuple[WashoutWeight, ...]:
    scale = _RATE.scale if in_degrees else _RATE.scale * 180.0 / pi  # |ω| in rad/s over w₅ = 3
    w1, w2, w3, w4 = _PLACE.coefficients
    at_share = (share * w1, share * w2, share * w3, share * w4)
    return (replace(_RATE, on=first, scale=scale), replace(_PLACE, on=second, coefficients=at_share))


READINGS: Final[dict[str, tuple[WashoutWeight, ...]]] = {
    **{f"{a}, {b}": _adaptive(a, b) for a in _SECOND for b in _FOURTH if a != b},
    "tilt_rate, position; ω in rad/s": _adaptive("tilt_rate", "position", in_degrees=False),
    "velocity, position; ω in rad/s": _adaptive("velocity", "position", in_degrees=False),
    # The change that brings the constant weights closest to Table 5.3, applied to the adaptive ones.
    "velocity, position × 1/10": _adaptive("velocity", "position", share=0.1),
}


def _weight_loops() -> dict[str, dict[str, Loop]]:
    return {
        name: {s: Loop(scenario=s, washout=weights, solver="structured") for s in ADAPTIVE_2.scenarios}
        for name, weights in READINGS.items()
    }


def weights_jobs() -> list[Loop]:
    """Return every reading on every signal of Table 5.7."""
    return [loop for loops in _weight_loops().values() for loop in loops.values()]


def weights(answers: Answers) -> Outcome:
    """Compare the states on which the adaptive weights of eqs. 4.12 and 4.13 may act."""
    printed = column("table-5.7")
    found = {name: rmse(answers, loops) for name, loops in _weight_loops().items()}
    fits = {name: fit(ours, printed) for name, ours in found.items()}
    order = sorted(fits, key=fits.__getitem__)
    travels = {name: _travel_fit(answers, loops) for name, loops in _weight_loops().items()}
    nearest = min(travels, key=travels.__getitem__)
    rows = [(name, f"{fits[name]:.3f}", f"{travels[name]:.3f}", *cells(found[name])) for name in order]
    return Outcome(
        name="study-weights",
        kind="study",
        title="Eq. 4.13: the first adaptive weight fits on the velocity better than on the tilt rate",
        section="4.1.2",
        text=(
            "Eq. 4.13 puts the two weights at the second and fourth place of the states, which in the order "
            "of eq. 4.9 are tilt and position; the text says tilt rate and position. Tried: pairs of states, "
            "and the polynomial's tilt rate in deg/s and in rad/s, against the column iMPC of Table 5.7. The "
            "preset `thesis-fit` is velocity and position, `printed` is tilt rate and position. The travels "
            "are those of the adaptive weights in Table 5.4."
        ),
        claims=(
            Claim(
                text="The printed reading (tilt rate, position) fits best",
                holds=order[0] == "tilt_rate, position",
                figures=f"{fits['tilt_rate, position']:.3f}; best: {order[0]}, {fits[order[0]]:.3f}",
            ),
            Claim(
                text="The reading that fits the errors best fits the travels best",
                holds=order[0] == nearest,
                figures=f"travels: {order[0]} {travels[order[0]]:.3f}; best: {nearest} "
                f"{travels[nearest]:.3f}, whose errors are at {fits[nearest]:.3f}",
            ),
        ),
        grids=(
            Grid(
                title="Fit to the errors (Table 5.7) and the travels (5.4), and RMSE [m/s²] by signal",
                header=("weights on", "fit, error", "fit, travel", *signals("table-5.7")),
                rows=(*rows, ("published", "", "", *cells(printed))),
            ),
        ),
        bears_on=bearing(["table-5.4", *ERRORS], order[0] == "velocity, position", Bearing.ADOPTED),
    )


def _travel_fit(answers: Answers, loops: Mapping[str, Loop]) -> float:
    printed = {row["scenario"]: row["travel"] for row in published("table-5.4").rows}
    ours = [answers[loop].travel[PAIR] for loop in loops.values()]
    return fit(ours, [printed[signal] for signal in loops])


# --- the constant weights of Table 5.3

_SCALES: Final = (1.0, 0.2, 0.1, 0.05, 0.02)
_CONSTANT: Final = [("tilt_rate", 1.0), ("tilt", 1.0), ("tilt_rate", 0.05), ("tilt", 0.05)] + [
    ("velocity", scale) for scale in _SCALES
]


def _constant_loops(on: str, scale: float) -> dict[str, Loop]:
    return {
        row["scenario"]: Loop(
            scenario=row["scenario"],
            washout=constant({on: row["tilt_rate"], "position": scale * row["position"]}),
            solver="structured",
        )
        for row in published("table-5.3").rows
    }


def constant_jobs() -> list[Loop]:
    """Return every reading on every signal of Table 5.3."""
    return [loop for on, scale in _CONSTANT for loop in _constant_loops(on, scale).values()]


def constant_weights(answers: Answers) -> Outcome:
    """Show that the tuned weights of Table 5.3 act on other states, or on another scale, than printed."""
    printed, travel = column("table-5.3", "rmse"), column("table-5.3", "travel")
    fits: dict[tuple[str, float], tuple[float, float]] = {}
    rows = []
    for on, scale in _CONSTANT:
        loops = _constant_loops(on, scale)
        ours = rmse(answers, loops)
        far = [answers[loop].travel[PAIR] for loop in loops.values()]
        fits[on, scale] = fit(ours, printed), fit(far, travel)
        rows.append((f"{on}, {scale:g} × position", *(f"{f:.3f}" for f in fits[on, scale]), *cells(ours)))
    best = min(fits, key=lambda key: sum(fits[key]))
    return Outcome(
        name="study-constant-weights",
        kind="study",
        title="Table 5.3: its weights fit on the velocity, and on the position at a tenth",
        section="5.2.4",
        text=(
            "One factor for all nine signals, against the table's errors and travels together. Why a "
            "tenth, the text does not say."
        ),
        claims=(
            Claim(
                text="The weights fit best on tilt rate and position, as the table says",
                holds=best == ("tilt_rate", 1.0),
                figures=f"fit of errors and travels {_two(fits['tilt_rate', 1.0])}; "
                f"best: {best[0]}, {best[1]:g} × position, {_two(fits[best])}",
            ),
        ),
        grids=(
            Grid(
                title="Fit to the errors and the travels of Table 5.3, and RMSE [m/s²] by signal",
                header=("weights on", "fit, error", "fit, travel", *signals("table-5.3")),
                rows=(*rows, ("published", "", "", *cells(printed))),
            ),
        ),
        bears_on=bearing(["table-5.3", "table-5.4", "table-c.6"], best == ("velocity", 0.1), Bearing.ADOPTED),
    )


def _two(pair: tuple[float, float]) -> str:
    return f"{pair[0]:.3f}, {pair[1]:.3f}"


# --- the terminal weight


def _terminal_loops(factor: float) -> dict[str, Loop]:
    return {s: Loop(scenario=s, solver="structured", terminal=factor) for s in ADAPTIVE_2.scenarios}


def terminal_jobs() -> list[Loop]:
    """Return four terminal weights on every signal."""
    return [loop for factor in TERMINAL for loop in _terminal_loops(factor).values()]


def terminal(answers: Answers) -> Outcome:
    """Measure how much of the difference the terminal weight, which is not printed, can explain."""
    printed = column("table-5.7")
    found = {factor: rmse(answers, _terminal_loops(factor)) for factor in TERMINAL}
    fits = {factor: fit(ours, printed) for factor, ours in found.items()}
    explains = min(fits.values()) < 0.5 * fits[1.0]
    return Outcome(
        name="study-terminal",
        kind="study",
        title="The terminal weight does not explain the difference",
        section="4.1.2",
        text="Eq. 3.1 ends with a terminal reference; its weight is not printed. Multiples of the stage's:",
        claims=(
            Claim(
                text="Some terminal weight halves the distance to Table 5.7",
                holds=explains,
                figures=", ".join(f"{value:.3f} at {factor:g}" for factor, value in fits.items()),
            ),
        ),
        grids=(
            Grid(
                title="Fit to Table 5.7 and RMSE [m/s²] by signal",
                header=("terminal weight", "fit", *signals("table-5.7")),
                rows=tuple((f"× {f:g}", f"{fits[f]:.3f}", *cells(found[f])) for f in TERMINAL),
            ),
        ),
        bears_on=bearing(["table-5.3", "table-5.4", *ERRORS], explains, Bearing.EXPLAINS),
    )
