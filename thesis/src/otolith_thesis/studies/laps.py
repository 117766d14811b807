"""How much gentler than ours the thesis's lap must have been."""

from typing import Final

import numpy as np

from otolith.core.arrays import Vec
from otolith_thesis.jobs import Answers
from otolith_thesis.laps import SAYS, Lap
from otolith_thesis.loop import Closed
from otolith_thesis.outcome import Bearing, Cell, Claim, Grid, Outcome
from otolith_thesis.published import published

SPEED: Final = 120  # [km/h]
SHARES: Final = (1.0, 0.5, 0.3)


def _lap(share: float) -> Lap:
    return Lap(SPEED, "implicit", share)


def size_jobs() -> list[Lap]:
    """Return the lap at 120 km/h, and shares of it."""
    return [_lap(share) for share in SHARES]


def _rms(values: Vec) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _printed_changes() -> float:
    return next(float(row["implicit"]) for row in published("table-6.4").rows if row["speed_kmh"] == SPEED)


def size(answers: Answers) -> Outcome:
    """Compare the error of a lap for several shares of its reference."""
    printed = {
        row["direction"]: float(row["implicit"])
        for row in published("table-6.5").rows
        if row["speed_kmh"] == SPEED
    }
    rows: list[tuple[Cell, ...]] = []
    for share in SHARES:
        one: Closed = answers[_lap(share)]
        wanted = [_rms(one.motion[pair].wanted) for pair in SAYS.values()]
        errors = [one.rmse[pair] for pair in SAYS.values()]
        rows.append((f"× {share:g}", *wanted, *errors, one.spread()["mean"]))
    whole, least = (answers[_lap(share)].rmse for share in (SHARES[0], SHARES[-1]))
    reached = all(least[pair] <= printed[way] <= whole[pair] for way, pair in SAYS.items())
    counts = sorted(answers[_lap(share)].spread()["mean"] for share in (SHARES[0], SHARES[-1]))
    counted = counts[0] <= _printed_changes() <= counts[1]
    return Outcome(
        name="study-lap-size",
        kind="study",
        title="Our lap asks for more than the thesis's platform was asked for",
        section="6.3",
        bears_on={
            "table-6.4": Bearing.EXPLAINS if counted else Bearing.EXCLUDED,
            "table-6.5": Bearing.EXPLAINS if reached else Bearing.EXCLUDED,
        },
        text=(
            "The car and its driver are ours, and use 3 and 4 m/s² wherever the track allows. The same lap, "
            "all of it made smaller, by the implicit MPC."
        ),
        claims=(
            Claim(
                text="The published errors lie between those of the whole lap and of 0.3 of it",
                holds=reached,
                figures="; ".join(
                    f"{way}: {whole[pair]:.4f}, {least[pair]:.4f}, published {printed[way]:.4f} m/s²"
                    for way, pair in SAYS.items()
                ),
            ),
        ),
        grids=(
            Grid(
                title="By share of the lap at 120 km/h",
                header=(
                    "lap",
                    *(f"reference RMS, {way} [m/s²]" for way in SAYS),
                    *(f"RMSE, {way} [m/s²]" for way in SAYS),
                    "mean changes",
                ),
                rows=tuple(rows),
            ),
        ),
    )
