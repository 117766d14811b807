"""Legs in the controller against one limit per axis, on the same legs in the same run.

    python benchmarks/six_axis.py [table] [laps] [time] [nmpc] [hostile] [--jumps N] [--seed S] [--json FILE]

Without words, all parts run; `hostile` with 100,000 jumps of what is wanted, on eight machines each, takes
an hour, and can be done in parts with other seeds. *table*: errors along two axes, `six-axis` on `davsi`
against `davsi-4dof`, whose limits per axis the same legs keep in every combination: against `predictive`
there, and against the very same controller there, without rows for legs. *laps*: interventions of the
supervisor on twelve laps, with servos and legs. *time*: CPU time of a decision. *nmpc*: cost above the
optimum of the nonlinear problem, by IPOPT. *hostile*: random jumps of force and rate on machines that nobody
would build; counts decisions without an answer, and how far legs leave limits and rows, beside the bound that
is computed for what happens between nodes.
"""

import argparse
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

import otolith
from hostile_machines import hostile, of_legs
from otolith import files, registry
from otolith.core.frames import DOFS, SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.mpc.predictive import HOMING, TILT_RATE
from otolith.cueing.mpc.settings import MpcSettings
from otolith.cueing.mpc.six_axis import DAMPING, six_axis_settings
from otolith.cueing.mpc.washout_weights import constant
from otolith.cueing.prediction.simple import Decay
from otolith.interfaces import Command, Cueing, PlatformState, Reference, Status
from otolith.loop import Run, simulate
from otolith.perception import otoliths, sense
from otolith.plant import Ideal
from otolith.platforms import Platform, load
from otolith.qp.blocked import block_starts
from otolith.qp.engines import StructuredEngine
from otolith.scenarios import Scenario
from otolith.vehicle import Driver, drive, load_car, road
from rows import Row, as_lines, write_rows

FOUR: Final = (SURGE_PITCH, SWAY_ROLL)
SIX: Final = tuple(DOFS.values())
DAVSI, BOX = load("davsi"), load("davsi-4dof")
CASES: Final = {"sine-1": (10.0, 1 / 0.80), "step-2": (8.0, 1 / 0.965), "lap120": (30.0, 1.0)}  # [s], goals
LAPS: Final = range(120, 60, -5)  # [km/h] highest speeds of twelve laps
EVERY: Final = 10  # plant samples of 1 ms in a period
HOLD: Final = 8  # periods between two jumps
Vec = NDArray[np.float64]


def wanted_of(name: str, folder: Path) -> Scenario:
    """What is to be felt along both axes; vertical force and rates are zero."""
    if name == "lap120":
        return lap_at(120, folder, CASES[name][0])
    return horizontal(otolith.Wanted(scenario=name), CASES[name][0])


def lap_at(speed: int, folder: Path, duration: float = np.inf) -> Scenario:
    """What is to be felt on a lap with at most this speed [km/h], through Telban's otoliths."""
    path = folder / f"lap{speed}.csv"
    if not path.exists():
        files.write_lap(drive(road("hockenheim").limited(speed / 3.6), load_car(), Driver()), path)
    return horizontal(otolith.Wanted(log=path, through="telban"), duration)


def horizontal(given: otolith.Wanted, duration: float) -> Scenario:
    """The horizontal forces of what is given, for at most `duration` [s]."""
    scenario = given.along(Design(platform=BOX, dofs=FOUR))
    return replace(
        scenario,
        duration=min(scenario.duration, duration),
        specific_force=lambda t: scenario.specific_force(t) * [1.0, 1.0, 0.0],
        angular_rate=lambda t: np.zeros((len(t), 3)),
    )


def of_box() -> Cueing:
    """The controller of `six-axis` with limits per axis instead of legs, and weights for that reach."""
    square = HOMING / BOX.circle if BOX.circle is not None else 0.0
    washout = constant({"position": square**2, "velocity": DAMPING * square, "tilt_rate": TILT_RATE})
    settings = replace(six_axis_settings(MpcSettings()), washout=washout, engine=StructuredEngine)
    return Mpc(BOX, FOUR, replace(settings, iterations=1))


def named(name: str, platform: Platform, dofs: tuple[Dof, ...]) -> Callable[[], Cueing]:
    """Maker of an algorithm of the registry."""
    return lambda: registry.make_cueing(name, Design(platform=platform, dofs=dofs))


RIVALS: Final[dict[str, tuple[Callable[[], Cueing], Platform, tuple[Dof, ...]]]] = {
    "predictive, box": (named("predictive", BOX, FOUR), BOX, FOUR),
    "six-axis, box": (of_box, BOX, FOUR),
    "six-axis, legs, 4 DOF": (named("six-axis", DAVSI, FOUR), DAVSI, FOUR),
    "six-axis, legs, 6 DOF": (named("six-axis", DAVSI, SIX), DAVSI, SIX),
}


def run_of(cueing: Cueing, wanted: Scenario, platform: Platform, dofs: tuple[Dof, ...]) -> Run:
    """A run on the ideal plant, with the whole force at the reference point."""
    return simulate(
        cueing, Ideal(head=(0.0, 0.0, 0.0)), wanted, platform=platform, dofs=tuple(dof.name for dof in dofs)
    )


def figures(run: Run) -> dict[str, Any]:
    """Errors of one run, and what its legs did."""
    error = run.felt_force - run.reference_force
    felt = sense(otoliths.telban(), error, 1e-3, before=np.zeros(3))
    rmse, perceived = (np.sqrt(np.mean(part**2, axis=0)) for part in (error, felt))
    correlation = [np.corrcoef(run.felt_force[:, k], run.reference_force[:, k])[0, 1] for k in (0, 1)]
    beyond = of_legs(DAVSI.six_legs(), run)
    return {
        "rmse": rmse,
        "norm": float(np.hypot(rmse[0], rmse[1])),
        "perceived": perceived,
        "correlation": correlation,
        "unanswered": sum(status != "decided" for status in run.status),
        "relaxed": sum(solver == "infeasible" for solver in run.solver),
        "nodes": np.maximum(beyond[EVERY - 1 :: EVERY].max(axis=0), 0.0),
        "between": np.maximum(beyond.max(axis=0), 0.0),
        "us": 1e6 * run.step_time,
    }


def table(rows: list[Row]) -> None:
    """Print the table of errors."""
    with tempfile.TemporaryDirectory() as folder:
        for case, (_, goal) in CASES.items():
            wanted, found = wanted_of(case, Path(folder)), {}
            for rival, (make, platform, dofs) in RIVALS.items():
                found[rival] = f = figures(run_of(make(), wanted, platform, dofs))
                print(
                    f"{case:8}{rival:23} RMSE {f['rmse'][0]:.3f}/{f['rmse'][1]:.3f}, norm {f['norm']:.4f}, "
                    f"perceived {f['perceived'][0]:.3f}/{f['perceived'][1]:.3f}, "
                    f"correlation {f['correlation'][0]:.3f}/{f['correlation'][1]:.3f}, "
                    f"vertical {f['rmse'][2]:.3f} m/s2; legs beyond at nodes {f['nodes'].max():.1e}, "
                    f"between {f['between'].max():.1e}; {f['unanswered']} unanswered, {f['relaxed']} relaxed",
                    flush=True,
                )
            legs = found["six-axis, legs, 6 DOF"]["norm"]
            for rival in list(RIVALS)[:2]:
                what = f"{case}, RMSE, {rival} / legs"
                rows.append(
                    Row(what=what, before=found[rival]["norm"], now=legs, unit="m/s2", goal=round(goal, 3))
                )


def laps() -> None:
    """Print what the supervisor in front of the legs had to do on twelve laps."""
    with tempfile.TemporaryDirectory() as folder:
        for name, dofs in (("six-axis", SIX), ("predictive", FOUR)):
            total = 0
            for speed in LAPS:
                plant = registry.make_plant("hexapod", DAVSI)
                design = Design(platform=DAVSI, dofs=dofs)
                cueing = registry.make_cueing(name, design, dead_time=plant.dead_time)
                names, wanted = tuple(dof.name for dof in dofs), lap_at(speed, Path(folder))
                run = simulate(cueing, plant, wanted, platform=DAVSI, dofs=names)
                total += len(run.interventions)
                unanswered = sum(status != "decided" for status in run.status)
                why = Counter(str(one.reason) for one in run.interventions)
                print(
                    f"lap at {speed} km/h, {run.duration:.0f} s, {name}: {len(run.interventions)} "
                    f"interventions {dict(why)}, {unanswered} of {len(run.status)} without an answer",
                    flush=True,
                )
            print(f"twelve laps, {name}: {total} interventions", flush=True)


def times(rows: list[Row]) -> None:
    """Print the CPU time of a decision along the lap, all in turns."""
    with tempfile.TemporaryDirectory() as folder:
        wanted = wanted_of("lap120", Path(folder))
        rivals = {name: (make(), platform, dofs) for name, (make, platform, dofs) in RIVALS.items()}
        least: dict[str, Vec] = {}
        for _ in range(3):
            for name, (cueing, platform, dofs) in rivals.items():
                spent = 1e6 * run_of(cueing, wanted, platform, dofs).step_time
                least[name] = np.minimum(least.get(name, spent), spent)
    for name, spent in least.items():
        median, p99 = np.median(spent), np.percentile(spent, 99)
        print(f"{name:23} median {median:7.1f} us, p99 {p99:7.1f}, max {spent.max():8.1f}", flush=True)
    six = np.median(least["six-axis, legs, 6 DOF"])
    for name in list(RIVALS)[:3]:
        what = f"median of a decision, {name} / legs, 6 DOF"
        rows.append(Row(what=what, before=float(np.median(least[name])), now=float(six), unit="us", goal=0.1))
    tail = float(np.percentile(least["six-axis, legs, 6 DOF"], 99))
    rows.append(Row(what="6 DOF, median / p99", before=float(six), now=tail, unit="us", goal=round(1 / 3, 3)))


def nmpc(rows: list[Row]) -> None:
    """Print the cost of single steps above the optimum, along a step and a lap, and what both take."""
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        for case in ("step-2", "lap120"):
            found = []
            for one in gaps_along(wanted_of(case, Path(folder))):
                found.append(one)
                print(
                    f"  {case} at {one.period * 0.01:.2f} s: {one.gap:.1e}{' (jump)' if one.jumped else ''}",
                    flush=True,
                )
            gaps, off_jump = [one.gap for one in found], [one.gap for one in found if not one.jumped]
            print(
                f"{case}: cost above the optimum, median {np.median(gaps):.1e}, max {max(gaps):.1e}, "
                f"off jumps max {max(off_jump):.1e}; firm rows of a plan off by at most "
                f"{max(one.excess for one in found):.1e}",
                flush=True,
            )
            seconds += [(one.of_full, one.of_single) for one in found]
    full, single = np.median(seconds, axis=0)
    what = "median of a decision at these instants, nonlinear by IPOPT / six-axis"
    rows.append(Row(what=what, before=1e6 * float(full), now=1e6 * float(single), unit="us", goal=None))


@dataclass(frozen=True, kw_only=True)
class Gap:
    """One decision of `six-axis` beside the nonlinear optimum."""

    period: int
    gap: float  # of the cost, relative
    excess: float  # of firm rows
    jumped: bool  # whether what is wanted has just jumped
    of_full: float  # [s] of the nonlinear decision …
    of_single: float  # … and of this one, with Python's part


def made(name: str) -> Mpc:
    """An algorithm of the registry that is one MPC, with a prediction that remembers nothing."""
    cueing = registry.make_cueing(
        name, Design(platform=DAVSI, dofs=SIX, mpc=MpcSettings(prediction=Decay(1.0)))
    )
    if not isinstance(cueing, Mpc):
        raise TypeError(f"{name} is not one MPC")
    return cueing


def planned(mpc: Mpc) -> Vec:
    """The inputs of all blocks (M, nu) in the last plan."""
    inputs: Vec = mpc.program.plan[block_starts(mpc.settings.lengths)]
    return inputs


def gaps_along(wanted: Scenario) -> Iterator[Gap]:
    """What single steps cost, once a second and right after a jump."""
    single, full = made("six-axis"), made("six-axis-nmpc")
    state, plant = PlatformState(), Ideal(head=(0.0, 0.0, 0.0))
    for part in (single, full, plant):
        part.reset(state)
    steps = round(wanted.duration / single.period)
    force = wanted.specific_force(np.arange(float(steps)) * single.period + 1e-9)
    for k in range(steps):
        reference = Reference(specific_force=force[k])
        command, of_single = timed(single, state, reference)
        if np.abs(force[k]).max() > 0.0 and (k % 100 == 57 or k in (101, 102)):
            answer, of_full = timed(full, state, reference)
            if answer.outcome.status is Status.DECIDED:
                best, _ = full.engine.judge(planned(full))  # type: ignore[attr-defined]
                found, excess = full.engine.judge(planned(single))  # type: ignore[attr-defined]
                yield Gap(
                    period=k,
                    gap=(found - best) / best,
                    excess=excess,
                    jumped=k > 0 and bool(np.abs(force[max(0, k - 5) : k + 1] - force[k]).max() > 0.5),
                    of_full=of_full,
                    of_single=of_single,
                )
        state = plant.step(command, single.period)


def timed(cueing: Cueing, state: PlatformState, reference: Reference) -> tuple[Command, float]:
    """A decision, and the CPU time [s] of this thread that it took."""
    began = time.thread_time()
    return cueing.step(state, reference), time.thread_time() - began


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("parts", nargs="*", choices=["table", "laps", "time", "nmpc", "hostile", []])
    parser.add_argument("--jumps", type=int, default=100_000)
    parser.add_argument(
        "--seed", type=int, default=11, help="Of the jumps: parts of a long run differ in it."
    )
    parser.add_argument("--json", type=Path, help="File for the rows of ratios.")
    chosen = parser.parse_args()
    parts, rows = chosen.parts or ["table", "laps", "time", "nmpc", "hostile"], list[Row]()
    with threadpool_limits(limits=1):
        if "table" in parts:
            table(rows)
        if "laps" in parts:
            laps()
        if "time" in parts:
            times(rows)
        if "nmpc" in parts:
            nmpc(rows)
        if "hostile" in parts:
            hostile(chosen.jumps, chosen.seed)
    if rows:
        print("\n".join(as_lines(rows)))
    if chosen.json:
        write_rows(chosen.json, rows)


if __name__ == "__main__":
    main()
