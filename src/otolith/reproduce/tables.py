"""One function per table: published rows in, the same rows with our numbers out.

A row keeps the published values under their own names and ours under `our_…`. Nothing is fitted: each
case is the thesis's, computed as printed, in the reading that `docs/results.md` explains.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

from otolith.core.frames import SURGE_PITCH, SWAY_ROLL
from otolith.metrics import excesses, tracking_rmse
from otolith.mpc.design import Design, explicit
from otolith.mpc.explicit import ExplicitSettings, explicit_problem
from otolith.mpc.model import BrakingRows
from otolith.mpqp import Law, enumerate_regions
from otolith.plant.ideal import without_lag
from otolith.platforms import PairLimits, load
from otolith.reproduce.published import published
from otolith.scenarios import scenario
from otolith.simulate import simulate

Row = dict[str, Any]
Tell = Callable[[str], None]

REACH_4_DOF: Final = 0.35  # [m] per axis, so that both stay inside the limit circle (section 4.2.1)
DEGREE: Final = math.pi / 180.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A published table with our numbers in it."""

    name: str
    title: str
    rows: list[Row]


def reproduce(name: str, tell: Tell) -> Table:
    """Compute one table of `TABLES`; `tell` is told each case as it begins."""
    title, rows = published(name)
    case = TABLES[name]
    done = []
    for row in rows:
        tell(", ".join(f"{key} {value}" for key, value in row.items() if key in _CASE_KEYS))
        done.append({**row, **case(row)})
    return Table(name=name, title=title, rows=done)


def _size(law: Law) -> Row:
    return {"our_regions": len(law), "our_seconds": law.seconds, "tolerance": law.tolerance}


def _law(settings: ExplicitSettings, limits: PairLimits | None = None) -> Law:
    thesis = load("thesis")
    return enumerate_regions(
        explicit_problem(limits or thesis.pair_limits(SURGE_PITCH), thesis.braking, settings)
    )


def _rmse(settings: ExplicitSettings, name: str, *laws: Law) -> float:
    """RMSE [m/s²] of the explicit controller alone on one scenario."""
    thesis = load("thesis")
    design = Design(platform=thesis, explicit=settings, stored_laws=laws)
    run = simulate(
        explicit(design), without_lag(), scenario(name), platform=thesis, pairs=(SURGE_PITCH.name,)
    )
    return float(tracking_rmse(run)[0])


def move_blocking(row: Row) -> Row:
    """Table 5.2: regions and closed-loop RMSE by horizon, with and without move blocking."""
    settings = ExplicitSettings(horizon=row["horizon"], block_from=row.get("block_from"))
    law = _law(settings)
    return {**_size(law), "our_rmse": _rmse(settings, "sine-2", law)}


def four_dof(row: Row) -> Row:
    """Table 5.8: the 4 DOF law is two independent laws; their product is the joint count."""
    thesis = load("thesis")
    settings = ExplicitSettings(
        horizon=row["horizon"], period=row["period"], block_from=row.get("block_from")
    )
    parts = [
        _law(settings, replace(thesis.pair_limits(pair), position=(-REACH_4_DOF, REACH_4_DOF)))
        for pair in (SURGE_PITCH, SWAY_ROLL)
    ]
    return {
        "our_parts": [len(part) for part in parts],
        "our_regions": math.prod(len(part) for part in parts),
        "our_seconds": sum(part.seconds for part in parts),
        "tolerance": parts[0].tolerance,
    }


def constraints(row: Row) -> Row:
    """Table C.1: fewer, more and tighter constraints, horizon 5 without blocking."""
    pi = replace(load("thesis").pair_limits(SURGE_PITCH), tilt_rate=math.pi * DEGREE)
    no_velocity = replace(pi, velocity=math.inf)
    position_only = replace(no_velocity, acceleration=math.inf)
    limits = {
        "states and a_tran": pi,
        "states and both inputs": replace(pi, tilt_acceleration=10.0 * DEGREE),
        "states but velocity, and a_tran": no_velocity,
        "states but velocity": position_only,
        "states but velocity, stringent": replace(
            position_only, tilt_rate=2.5 * DEGREE, position=(-0.4, 0.4)
        ),
    }[row["constraints"]]
    return _size(_law(ExplicitSettings(block_from=None), limits))


def braking(row: Row) -> Row:
    """Table C.2: RMSE without and with braking rows, blocked horizon 5."""
    return {
        "our_rmse_without": _rmse(ExplicitSettings(), row["scenario"]),
        "our_rmse_with": _rmse(ExplicitSettings(braking=BrakingRows.POSITION), row["scenario"]),
    }


def benchmark(row: Row) -> Row:
    """The controller of eq. C.4: wider limits, braking rows, tilt acceleration limited, weights of 0.1."""
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
        without_lag(),
        scenario(row["scenario"]),
        platform=platform,
        pairs=(SURGE_PITCH.name,),
    )
    return {
        **_size(design.laws[0]),
        "our_rmse": float(tracking_rmse(run)[0]),
        "our_travel": float(abs(run.pose[:, 0]).max()),
        "our_violations": sum(excess.violations for excess in excesses(run)),
    }


def weights(row: Row) -> Row:
    """Table C.3: weights of 0.1 on the first states, horizon 5 without blocking."""
    on = row["weighted"]
    state_weights = (0.1,) * on + (0.0,) * (4 - on)
    return _size(_law(ExplicitSettings(block_from=None, state_weights=state_weights)))


_CASE_KEYS: Final = ("horizon", "period", "block_from", "constraints", "scenario", "weighted")
TABLES: Final[dict[str, Callable[[Row], Row]]] = {
    "table-5.2": move_blocking,
    "table-5.8": four_dof,
    "table-c.1": constraints,
    "table-c.2": braking,
    "table-c.3": weights,
    "benchmark-c.2": benchmark,
}
