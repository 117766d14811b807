"""A platform on a rail: hexapod alone, both jointly, in turn, and split, under the same limits and weights.

    python benchmarks/redundant.py [--json FILE] [--figure FILE] [--quick]

Every algorithm drives `ultimate` along one axis pair on steps, sines and a lap of Hockenheim, on the ideal
plant. Beside the errors stand those of the offline optimum, without and with the rail: no algorithm can do
better. The time is the thread CPU time of the QPs alone, the sum of both where there are two, the least of
three passes. After the lap nothing is wanted for a minute, and the rail's place at the end is printed.
`--quick` leaves out the lap.
"""

import argparse
import functools
import json
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from threadpoolctl import threadpool_limits

from otolith import files, metrics, registry
from otolith.core.arrays import Ints, Mat, Vec
from otolith.core.frames import SURGE_PITCH, SWAY_ROLL, Dof
from otolith.cueing.design import Design
from otolith.cueing.mpc.controller import Mpc
from otolith.cueing.optimum import optimum
from otolith.cueing.several import Several
from otolith.experiment import Wanted
from otolith.interfaces import Cueing
from otolith.loop import Run, simulate
from otolith.platforms import Platform, load
from otolith.qp.blocked import condense_blocked
from otolith.qp.engines import StructuredEngine, expand
from otolith.qp.problem import Status
from otolith.qp.stage import OnRequest, StageProblem, StageSolution
from otolith.scenarios import Scenario, scenario
from otolith.vehicle import Driver, drive, load_car, road

SHORT: Final = (1, 1, 2, 7, 12, 20)  # 0.43 s of the 1.5 s, the first six of the nine blocks
ALGORITHMS: Final = {
    "hexapod alone": ("predictive", ()),
    "joint": ("joint", ()),
    "lnl, equal horizons": ("lnl", ()),
    "lnl, second 0.43 s": ("lnl", SHORT),
    "nll, equal horizons": ("nll", ()),
    "nll, second 0.43 s": ("nll", SHORT),
    "split at 2 Hz": ("split", ()),
}
SIGNALS: Final = ("step-0.5", "step-1", "step-2", "sine-0.5", "sine-1", "combined")
PASSES: Final = 3
REST: Final = 60.0  # [s] after the lap
SMALL: Final = 0.02  # [m/s²] of the sines of the crossover, far below all limits
FREQUENCIES: Final = np.geomspace(0.3, 16.0, 15)  # [Hz]
LEAST: Final = 1e-3  # [m/s²] the figure shows smaller errors as this


class Timed:
    """The structured engine, called from Python, and the time of every solve by its kernel alone."""

    def __init__(self, problem: StageProblem, **settings: Any) -> None:
        self.inner = StructuredEngine(problem, **settings)
        self.memory, self.solver = self.inner.memory, self.inner._solver
        self.seconds: list[float] = []

    def run(self, start: Ints | None = None, hint: OnRequest | None = None) -> StageSolution:  # noqa: ARG002
        began = time.thread_time_ns()
        self.solver.kernels.solve(self.solver.vector)
        self.seconds.append(1e-9 * (time.thread_time_ns() - began))
        solution = self.solver.solution()
        return self.inner.exact() if solution.status is Status.LIMIT else solution

    def reset(self) -> None:
        self.inner.reset()
        self.seconds.clear()


@dataclass(frozen=True)
class Result:
    """What one algorithm did on one drive."""

    rmse: float
    changes: float  # mean per decision
    undecided: int
    broken: int
    residual: float
    qp: Vec  # (m,) [s] of the QPs of every decision
    rest: tuple[float, float]  # [m] places of rail and platform at the end


def parts_of(cueing: Cueing) -> list[Mpc]:
    """The MPCs of which an algorithm is made."""
    inner = getattr(cueing, "_inner", cueing)
    parts = inner.parts if isinstance(inner, Several) else (inner,)
    return [part for part in parts if isinstance(part, Mpc)]


@functools.cache
def made(name: str, dof: Dof) -> Cueing:
    """An algorithm on the platform, whose QPs are timed."""
    of, blocks = ALGORITHMS[name]
    design = Design(platform=load("ultimate"), dofs=(dof,), second_blocks=blocks)
    return registry.make_cueing(of, replace(design, mpc=replace(design.mpc, engine=Timed)))


def loop(name: str, dof: Dof, wanted: Scenario) -> Run:
    """One closed loop on the ideal plant."""
    platform = load("ultimate")
    plant = registry.make_plant("ideal", platform)
    return simulate(made(name, dof), plant, wanted, platform=platform, dofs=(dof.name,), plant_period=0.01)


def result(name: str, dof: Dof, wanted: Scenario, until: float) -> Result:
    """Run one algorithm on one drive; the error is that until a time [s]."""
    engines = [part.engine for part in parts_of(made(name, dof))]
    least = np.inf
    for _ in range(PASSES):
        run = loop(name, dof, wanted)
        taken = [np.array(engine.seconds) for engine in engines if isinstance(engine, Timed)]
        least = np.minimum(least, np.sum([one[-run.decisions :] for one in taken], axis=0))
    error = (run.felt_force - run.reference_force)[run.time <= until + 1e-9, dof.felt]
    base = 0.0 if run.base is None else run.base[-1, dof.translation]
    return Result(
        rmse=float(np.sqrt(np.mean(error**2))),
        changes=float(run.changes.mean()),
        undecided=run.decisions - run.status.count("decided"),
        broken=sum(one.violations for one in metrics.excesses(run)),
        residual=float(run.residual.max()),
        qp=np.asarray(least),
        rest=(float(base), float(run.pose[-1, dof.translation])),
    )


def drives(quick: bool, folder: Path) -> dict[str, tuple[Dof, Scenario, float]]:
    """What is wanted, along which pair, and until when [s], by name."""
    found = {name: (SURGE_PITCH, scenario(name), scenario(name).duration) for name in SIGNALS}
    if quick:
        return found
    path = folder / "lap120.csv"
    files.write_lap(drive(road("hockenheim").limited(120.0 / 3.6), load_car(), Driver()), path)
    for letter, dof in (("x", SURGE_PITCH), ("y", SWAY_ROLL)):
        lap = Wanted(log=path).along(Design(platform=load("ultimate"), dofs=(dof,)))
        found[f"lap 120 {letter}"] = (dof, then_rest(lap), lap.duration)
    return found


def then_rest(lap: Scenario) -> Scenario:
    """The lap, after which nothing is wanted for a minute."""
    return replace(
        lap,
        duration=round((lap.duration + REST) * 100.0) / 100.0,
        specific_force=functools.partial(_until, lap.specific_force, lap.duration),
        angular_rate=functools.partial(_until, lap.angular_rate, lap.duration),
    )


def _until(of: Callable[[Vec], Mat], end: float, t: Vec) -> Mat:
    """Values (n, 3) of a function of time until its end, zero after it."""
    values: Mat = of(np.minimum(t, end)) * (t < end)[:, None]
    return values


def best(dof: Dof, wanted: Scenario, until: float, platform: Platform) -> float:
    """The error of the offline optimum on a drive until a time [s]."""
    found = optimum(platform, (dof,), replace(wanted, duration=until), plant_period=0.01).run
    return float(np.sqrt(np.mean((found.felt_force - found.reference_force)[:, dof.felt] ** 2)))


def shares(cueing: Cueing, platform: Platform) -> Mat:
    """Amplitudes of the accelerations of rail, platform and tilt (F, 3) on small sines, relative to these."""
    found = []
    for f in FREQUENCIES:
        cycles = max(6.0, np.ceil(8.0 * f))
        run = simulate(
            cueing,
            registry.make_plant("ideal", platform),
            scenario(f"sine:amplitude={SMALL},frequency={f},duration={cycles / f}"),
            platform=platform,
            dofs=(SURGE_PITCH.name,),
            plant_period=0.01,
        )
        late = run.time > run.time[-1] - np.floor(cycles / 2) / f + 1e-9
        wave = np.exp(-2j * np.pi * f * run.time[late])
        of_base = np.zeros(len(run.time)) if run.base is None else run.base[:, 12]
        series = (of_base, run.acceleration[:, 0], -9.81 * np.sin(run.pose[:, 4]))
        found.append([2.0 * abs(np.mean(one[late] * wave)) / SMALL for one in series])
    return np.array(found)


def weighed(weight: float, lag: float) -> Platform:
    """The platform with another weight and lag [s] of its rail."""
    values = load("ultimate").model_dump()
    values["base"] |= {"weight": weight, "lag_s": lag}
    return Platform.model_validate(values)


def crossovers() -> None:
    """Print where the platform takes over from the rail, by weight and lag of the rail."""
    print("\ncrossover from rail to platform [Hz]")
    for weight, lag in ((1.0, 0.08), (100.0, 0.08), (1000.0, 0.08), (100.0, 0.04), (100.0, 0.16)):
        platform = weighed(weight, lag)
        cueing = registry.make_cueing("joint", Design(platform=platform))
        print(f"  joint, weight {weight:4g}, lag {lag:.2f} s {crossover(shares(cueing, platform)):8.2f}")
    print(f"  split at 2 Hz {crossover(shares(made('split at 2 Hz', SURGE_PITCH), load('ultimate'))):21.2f}")


def crossover(amplitudes: Mat) -> float:
    """The frequency [Hz] above which the platform's share is larger than the rail's; NaN if there is none."""
    ratio = np.log(amplitudes[:, 1] / amplitudes[:, 0])
    above = np.flatnonzero((ratio[1:] > 0.0) & (ratio[:-1] <= 0.0))
    if len(above) == 0:
        return float("nan")
    k = above[-1]
    share = -ratio[k] / (ratio[k + 1] - ratio[k])
    return float(np.exp((1.0 - share) * np.log(FREQUENCIES[k]) + share * np.log(FREQUENCIES[k + 1])))


def condition(name: str) -> float:
    """The condition number of the condensed Hessian of an algorithm's first QP, at rest."""
    (first, *_) = parts_of(made(name, SURGE_PITCH))
    of, memory = first.problem, first.engine.memory
    N, nu = of.settings.horizon, len(of.axes.axis)
    of.write(memory, np.zeros(3 * nu), np.zeros((N, nu)), np.zeros((N, len(of.channels))), None)
    blocks = of.settings.blocks
    return float(np.linalg.cond(condense_blocked(expand(of.structure, memory, blocks), blocks).H))


def table(results: dict[str, dict[str, Result]], optima: dict[str, tuple[float, float]]) -> None:
    """Print errors, times and counts."""
    names = list(results)
    print(f"{'RMSE [m/s2]':22}" + "".join(f"{name:>12}" for name in names))
    for k, label in enumerate(("optimum, no rail", "optimum, with rail")):
        print(f"{label:22}" + "".join(f"{optima[name][k]:12.4f}" for name in names))
    for algorithm in ALGORITHMS:
        print(f"{algorithm:22}" + "".join(f"{results[name][algorithm].rmse:12.4f}" for name in names))
    heads = ("QP median", "p99", "max us", "changes", "undecided", "broken", "certificate")
    print(f"\n{'':22}" + "".join(f"{head:>12}" for head in heads))
    for algorithm in ALGORITHMS:
        of = [results[name][algorithm] for name in names]
        qp = 1e6 * np.concatenate([one.qp for one in of])
        times = f"{np.median(qp):12.1f}{np.percentile(qp, 99):12.1f}{qp.max():12.0f}"
        changes, undecided = np.mean([one.changes for one in of]), sum(one.undecided for one in of)
        counts = f"{changes:12.2f}{undecided:12}{sum(one.broken for one in of):12}"
        print(f"{algorithm:22}{times}{counts}{max(one.residual for one in of):12.1e}")


def figure(errors: dict[str, dict[str, float]], optima: dict[str, tuple[float, float]], path: Path) -> None:
    """Draw the errors by drive and algorithm beside the optima."""
    names = list(errors)
    figure, axes = plt.subplots(figsize=(9.5, 4.8), layout="constrained")
    width, places = 0.8 / len(ALGORITHMS), np.arange(len(names))
    for k, algorithm in enumerate(ALGORITHMS):
        at = places + (k - (len(ALGORITHMS) - 1) / 2) * width
        axes.bar(at, [errors[name][algorithm] for name in names], width, label=algorithm)
    for k, (label, style) in enumerate((("optimum, no rail", "v"), ("optimum, with rail", "D"))):
        values = [max(optima[name][k], LEAST) for name in names]
        axes.plot(places, values, style, color=("white", "black")[k], markeredgecolor="black", label=label)
    axes.set_yscale("log")
    axes.set_ylim(LEAST, None)
    axes.set_ylabel("RMSE of the felt force [m/s²]")
    axes.set_xticks(places, names)
    figure.legend(ncols=5, fontsize=8, loc="outside upper center")
    figure.savefig(path, dpi=130)


def orderings(results: dict[str, dict[str, Result]]) -> None:
    """Count on how many drives what is claimed of the algorithms holds."""

    def fewer(a: str, b: str, what: str) -> str:
        better = sum(getattr(of[a], what) < getattr(of[b], what) for of in results.values())
        return f"{better} of {len(results)}"

    def faster(a: str, b: str) -> str:
        better = sum(np.mean(of[a].qp) < np.mean(of[b].qp) for of in results.values())
        return f"{better} of {len(results)}"

    print("\non how many drives")
    lnl, nll = "lnl, equal horizons", "nll, equal horizons"
    pairs = (("joint", lnl), (lnl, "hexapod alone"), ("joint", "hexapod alone"), ("joint", "split at 2 Hz"))
    for a, b in pairs:
        print(f"  {a} has a smaller error than {b}: {fewer(a, b, 'rmse')}")
    for short, equal in (("lnl, second 0.43 s", lnl), ("nll, second 0.43 s", nll)):
        print(f"  {short} has a smaller error than {equal}: {fewer(short, equal, 'rmse')}")
        print(f"  {short} is faster than {equal}: {faster(short, equal)}")
    print(f"  {nll} is slower than {lnl}: {faster(lnl, nll)}")
    for two in (lnl, "lnl, second 0.43 s"):
        print(f"  the QPs of {two} take less than that of joint: {faster(two, 'joint')}")


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--quick", action="store_true")
    chosen = parser.parse_args(arguments)
    platform = load("ultimate")
    results: dict[str, dict[str, Result]] = {}
    optima: dict[str, tuple[float, float]] = {}
    with threadpool_limits(limits=1), tempfile.TemporaryDirectory() as folder:
        for name, (dof, wanted, until) in drives(chosen.quick, Path(folder)).items():
            results[name] = {one: result(one, dof, wanted, until) for one in ALGORITHMS}
            grounded = platform.model_copy(update={"base": None})
            optima[name] = best(dof, wanted, until, grounded), best(dof, wanted, until, platform)
        table(results, optima)
        orderings(results)
        for name, of in results.items():
            if name.startswith("lap"):
                print(f"\n{name}, a minute after its end: rail and platform [mm]")
                for algorithm, one in of.items():
                    print(f"  {algorithm:22}{1e3 * one.rest[0]:10.3f}{1e3 * one.rest[1]:10.3f}")
        alone, both = condition("hexapod alone"), condition("joint")
        print(f"\ncondition of the Hessian: alone {alone:.1e}, joint {both:.1e}")
        crossovers()
    if chosen.json is not None:
        rows = [
            {"drive": name, "algorithm": algorithm, "rmse": one.rmse, "qp_us": 1e6 * float(np.mean(one.qp))}
            for name, of in results.items()
            for algorithm, one in of.items()
        ]
        chosen.json.write_text(json.dumps({"runs": rows, "optima": optima}, indent=1))
    if chosen.figure is not None:
        errors = {name: {one: of[one].rmse for one in ALGORITHMS} for name, of in results.items()}
        figure(errors, optima, chosen.figure)


if __name__ == "__main__":
    main()
