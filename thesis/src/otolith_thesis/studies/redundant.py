"""Dagdelen's, Bruschetta's and Soyer's redundant simulators (section 2.4.2), as the thesis tells of them.

The thesis cites results of three machines that carry a hexapod on a rail or a tripod, without a number. Here
the algorithms run on `ultimate`, whose rail and tilt have the limits of eq. C.4, and each statement is tested
there.
"""

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from otolith import metrics, registry
from otolith.core.frames import SURGE_PITCH
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.several import Several
from otolith.loop import simulate
from otolith.platforms import load
from otolith.scenarios import scenario
from otolith_thesis.jobs import Answers
from otolith_thesis.outcome import Cell, Claim, Grid, Outcome

PLATFORM: Final = "ultimate"
SIGNALS: Final = ("step-0.5", "step-1", "step-2", "sine-0.5", "sine-1", "combined")
SHORT: Final = (1, 1, 2, 7, 12, 20)  # 0.43 s of 1.5 s
LNL, LNL_SHORT, NLL, NLL_SHORT = "LNL", "LNL, second 0.43 s", "NLL", "NLL, second 0.43 s"
ALONE, JOINT, SPLIT, LINEAR = "hexapod alone", "joint", "split at 2 Hz", "linear, hexapod alone"
VARIANTS: Final[dict[str, tuple[str, tuple[int, ...]]]] = {
    LINEAR: ("linear-mpc", ()),
    ALONE: ("predictive", ()),
    SPLIT: ("split", ()),
    JOINT: ("joint", ()),
    LNL: ("lnl", ()),
    LNL_SHORT: ("lnl", SHORT),
    NLL: ("nll", ()),
    NLL_SHORT: ("nll", SHORT),
}


@dataclass(frozen=True)
class Carried:
    """One algorithm on one signal."""

    variant: str
    signal: str

    @property
    def label(self) -> str:
        """Return a few words for the progress line."""
        return f"{self.variant}, {self.signal}"

    @property
    def cost(self) -> float:
        """Return the approximate duration [s]."""
        return 5.0

    def run(self) -> dict[str, Any]:
        """Close the loop; return error, felt error and effort."""
        name, blocks = VARIANTS[self.variant]
        platform = load(PLATFORM)
        cueing = registry.make_cueing(
            name, replace(Design(platform=platform, dofs=(SURGE_PITCH,)), second_blocks=blocks)
        )
        plant = registry.make_plant("ideal", platform)
        run = simulate(cueing, plant, scenario(self.signal), platform=platform, dofs=(SURGE_PITCH.name,))
        parts = cueing.parts if isinstance(cueing, Several) else (cueing,)
        return {
            "rmse": float(np.sqrt(np.mean((run.felt_force - run.reference_force)[:, 0] ** 2))),
            "changes": float(run.changes.mean()),
            "variables": sum(part.program.U.size for part in parts if isinstance(part, Mpc)),
            "microseconds": 1e6 * float(np.median(run.step_time)),
            "broken": sum(one.violations for one in metrics.excesses(run)),
        }


def jobs() -> list[Carried]:
    """Return all runs."""
    return [Carried(variant, signal) for variant in VARIANTS for signal in SIGNALS]


def study(answers: Answers) -> Outcome:
    """Test what the thesis tells of the three studies."""
    found = {
        variant: {signal: answers[Carried(variant, signal)] for signal in SIGNALS} for variant in VARIANTS
    }
    rows: list[tuple[Cell, ...]] = [
        (
            variant,
            *(f"{of[signal]['rmse']:.4f}" for signal in SIGNALS),
            f"{np.mean([one['changes'] for one in of.values()]):.2f}",
            int(of[SIGNALS[0]]["variables"]) or None,
            int(sum(one["broken"] for one in of.values())),
        )
        for variant, of in found.items()
    ]
    return Outcome(
        name="study-redundant",
        kind="study",
        title="Redundant simulators: what is told of Dagdelen, Bruschetta and Soyer, on one machine",
        section="2.4.2",
        text=(
            "The papers were not available, and the thesis prints no number of theirs. The machine is a "
            "hexapod on a rail with the limits of eq. C.4; the hexapod’s own travel and the lags are assumed "
            "(its file says which). Surge and pitch, ideal plant, no preview, one set of weights."
        ),
        claims=_claims(found),
        grids=(
            Grid(
                title="RMSE of the felt force [m/s²], and effort",
                header=("algorithm", *SIGNALS, "changes", "variables of the QPs", "limits broken"),
                rows=tuple(rows),
            ),
            Grid(
                title="The three studies",
                header=("study", "machine and method, by the thesis", "result, by the thesis", "here"),
                rows=_three(found),
            ),
        ),
    )


def _mean(of: dict[str, dict[str, Any]]) -> float:
    return float(np.mean([one["rmse"] for one in of.values()]))


def _better(a: dict[str, dict[str, Any]], b: dict[str, dict[str, Any]], what: str = "rmse") -> int:
    return sum(a[signal][what] < b[signal][what] for signal in SIGNALS)


def _claims(found: dict[str, dict[str, dict[str, Any]]]) -> tuple[Claim, ...]:
    n = len(SIGNALS)
    shorter = {equal: _better(found[short], found[equal]) for equal, short in PAIRS.items()}
    slower = _better(found[LNL], found[NLL], "changes")
    first = _better(found[JOINT], found[LNL])
    nonlinear = _better(found[JOINT], found[LINEAR])
    return (
        Claim(
            text="Soyer: both schemes track better when the second horizon is shorter",
            holds=min(shorter.values()) == n,
            figures=", ".join(f"{name} on {count} of {n} signals" for name, count in shorter.items()),
        ),
        Claim(
            text="Soyer: with equal horizons NLL needs more effort than LNL (changes of the working set)",
            holds=slower == n,
            figures=f"on {slower} of {n} signals",
        ),
        Claim(
            text="Bruschetta: nonlinear MPC over all carriers tracks better than linear MPC of the hexapod",
            holds=nonlinear == n,
            figures=f"on {nonlinear} of {n} signals; mean {_mean(found[JOINT]):.3f} and "
            f"{_mean(found[LINEAR]):.3f} m/s²",
        ),
        Claim(
            text="One problem over both carriers tracks better than two in turn (not in the thesis)",
            holds=first == n,
            figures=f"than LNL on {first} of {n} signals, than NLL on {_better(found[JOINT], found[NLL])}",
        ),
    )


PAIRS: Final = {LNL: LNL_SHORT, NLL: NLL_SHORT}


def _three(found: dict[str, dict[str, dict[str, Any]]]) -> tuple[tuple[Cell, ...], ...]:
    mean = {variant: f"{variant} {_mean(of):.3f} m/s²" for variant, of in found.items()}
    return (
        (
            "Dagdelen et al. 2009",
            "ULTIMATE, 8 degrees of freedom; linear, Young’s model, thresholds as constraints",
            "not all degrees of freedom, therefore sub-optimal",
            f"{mean[LINEAR]}; {mean[JOINT]}",
        ),
        (
            "Bruschetta, Maran & Beghi 2017",
            "9 degrees of freedom; nonlinear, Telban’s model, actuator lengths, ACADO with SQP-RTI",
            "improvements over the linear model",
            f"{mean[SPLIT]}; {mean[JOINT]}; {mean[LINEAR]}",
        ),
        (
            "Soyer, Olaru & Fang 2021",
            "ULTIMATE; rail and hexapod in turn, LNL and NLL",
            "shorter second horizon better and faster; with equal horizons NLL slower",
            "; ".join(mean[one] for one in (LNL, LNL_SHORT, NLL, NLL_SHORT)),
        ),
    )
