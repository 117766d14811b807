"""Every cueing algorithm on signals, laps and drives of one's own: the table of docs/which-cueing.md.

    python benchmarks/which_cueing.py [--drive FILE ...] [--random N] [--json FILE]

A case is hard where the best of the other algorithms has an error of more than .2 m/s², else easy: within
reach of the platform. An algorithm that breaks a hard limit is shown with an exclamation mark and never
counts as best. `--drive` adds recorded drives, low-passed at 5 Hz; `--random` adds as many random references,
with seeds that were never used for tuning.
"""

import argparse
import json
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np

import otolith
from otolith import files, registry
from otolith.core.frames import Dof
from otolith.cueing.mpc.settings import BLOCKS
from otolith.vehicle import Driver, drive, load_car, road

SIGNALS: Final = (
    *("sine-0.5", "sine-1", "sine-2", "combined", "combined-fast", "step-0.5", "step-1", "step-2"),
    "multisine:seed=7,amplitude=1.5,duration=20",
    "multisine:seed=11,amplitude=1.0,duration=20",
    "chirp:",
    "step:amplitude=1.5,start=2,end=4,duration=10",
    "sine:amplitude=1.0,frequency=0.3",
)
SHIPPED: Final = (
    "classical",
    "adaptive",
    "optimal",
    "optimal-nonlinear",
    "linear-mpc",
    "implicit-sensed",
    "implicit",
)
ALL: Final = (*SHIPPED, "implicit in blocks", "predictive")
LIVELY: Final = {f"predictive, liveliness {value:g}": value for value in (0.0, 0.25, 0.75, 1.0)}
BESIDE: Final = {
    "implicit in blocks": (-30, 7),
    "linear-mpc": (6, -11),
    "optimal": (6, -11),
    "implicit": (7, -4),
    "predictive, liveliness 0.75": (-4, 7),
    "predictive": (-24, -15),
}
HARD: Final = 0.2  # [m/s²] of the best shipped
LAP: Final = 100.0  # [s] of each lap
FIGURES: Final = ("rmse", "perceived", "correlation")


def cases(drives: Sequence[Path], random: int, folder: Path) -> dict[str, tuple[otolith.Wanted, Dof]]:
    """What is to be felt, and along which axis, by name."""
    found = {name: (otolith.Wanted(scenario=name), otolith.SURGE_PITCH) for name in SIGNALS}
    for speed in (80, 100, 120):
        path = folder / f"lap{speed}.csv"
        files.write_lap(drive(road("hockenheim").limited(speed / 3.6), load_car(), Driver()), path)
        for letter, dof in (("x", otolith.SURGE_PITCH), ("y", otolith.SWAY_ROLL)):
            found[f"lap {speed} {letter}"] = (otolith.Wanted(log=path, through="telban"), dof)
    for path in drives:
        for letter, dof in (("x", otolith.SURGE_PITCH), ("y", otolith.SWAY_ROLL)):
            found[f"{path.stem} {letter}"] = (otolith.Wanted(log=path, lowpass_hz=5.0), dof)
    rng = np.random.default_rng(20261129)
    for seed in range(5000, 5000 + random):
        amplitude = np.exp(rng.uniform(np.log(0.25), np.log(2.0)))
        text = f"multisine:seed={seed},amplitude={amplitude:.3f},duration=20"
        found[f"random {seed}"] = (otolith.Wanted(scenario=text), otolith.SURGE_PITCH)
    return found


def figures(wanted: otolith.Wanted, dof: Dof, platform: str) -> dict[str, dict[str, float]]:
    """Key figures of all algorithms on one case."""
    design = otolith.Design(platform=otolith.platform(platform), dofs=(dof,))
    blocked = replace(design, mpc=replace(design.mpc, horizon=sum(BLOCKS), blocks=BLOCKS))
    variants = {"implicit in blocks": ("implicit", blocked)} | {
        name: ("predictive", replace(design, liveliness=value)) for name, value in LIVELY.items()
    }
    scenario = wanted.along(design)
    scenario = replace(scenario, duration=min(scenario.duration, LAP))
    found = {}
    for name in (*ALL, *LIVELY):
        of, chosen = variants.get(name, (name, design))
        run = otolith.simulate(
            registry.make_cueing(of, chosen),
            registry.make_plant("ideal", design.platform),
            scenario,
            platform=design.platform,
            dofs=(dof.name,),
        )
        summary = otolith.summarise(run)
        found[name] = {
            "rmse": summary["rmse_per_pair"][dof.name],
            "perceived": summary["perceived_rmse"][dof.name],
            "correlation": summary["correlation"][dof.name],
            "travel": summary["travel_rms"][dof.name.split("-")[0]],
            "unwanted": summary["false_cues"][dof.name]["unwanted"]["duration_s"],
            "lag": summary["unwanted_cues"][dof.name]["lag"]["duration_s"],
            "rebound": summary["unwanted_cues"][dof.name]["rebound"]["duration_s"],
            "dose": summary["sickness_dose"][dof.name],
            "broken": summary["violations"],
            "step": summary["step_time_us"]["median"],
        }
    return found


def best(case: dict[str, dict[str, float]], figure: str, among: Sequence[str] = ALL[:-1]) -> float:
    """The best of a figure among the algorithms that kept all limits."""
    values = [case[name][figure] for name in among if not case[name]["broken"]]
    return max(values) if figure == "correlation" else min(values)


def mean_ratio(cases: Sequence[dict[str, dict[str, float]]], figure: str) -> float:
    """Geometric mean of the predictive algorithm's figure over the best of the others'."""
    return float(np.exp(np.mean([np.log(one["predictive"][figure] / best(one, figure)) for one in cases])))


def show(found: dict[str, dict[str, dict[str, float]]]) -> None:
    """Print the table, and means of hard and easy cases."""
    print("| case | best other | RMSE, of it | perceived, of the best | correlation | travel, of implicit |")
    print("|---|---|---|---|---|---|")
    for name, case in found.items():
        winner = min((n for n in ALL[:-1] if not case[n]["broken"]), key=lambda n: case[n]["rmse"])
        one = case["predictive"]
        print(
            f"| {name}{' !' if one['broken'] else ''} | {winner} {case[winner]['rmse']:.4f} "
            f"| {one['rmse']:.4f}, {one['rmse'] / best(case, 'rmse'):.3f} "
            f"| {one['perceived']:.4f}, {one['perceived'] / best(case, 'perceived'):.3f} "
            f"| {one['correlation']:.3f}, {one['correlation'] - best(case, 'correlation'):+.3f} "
            f"| {one['travel']:.3f} m, {one['travel'] / case['implicit']['travel']:.1f} |"
        )
    hard = {n: c for n, c in found.items() if best(c, "rmse") > HARD}
    easy = {n: c for n, c in found.items() if n not in hard}
    for label, some in (("all", found), ("hard", hard), ("easy", easy)):
        if some:
            ratios = [mean_ratio(list(some.values()), figure) for figure in ("rmse", "perceived")]
            first = sum(c["predictive"]["perceived"] <= best(c, "perceived") for c in some.values())
            rmse, perceived = ratios
            print(
                f"{label} {len(some)}: RMSE {rmse:.3f}, perceived {perceived:.3f} of the best other", end="; "
            )
            print(f"first in perceived RMSE on {first}")


def show_unwanted(found: dict[str, dict[str, dict[str, float]]]) -> None:
    """Print, over all cases together, how long cues were unwanted, lagged and rebounded, and the dose."""
    print("\n| all cases together | unwanted s | lag s | rebound s | dose, of implicit, in geometric means |")
    print("|---|---|---|---|---|")
    dose = _over_cases(found, "implicit", "dose")
    for name in ALL:
        sums = (sum(case[name][key] for case in found.values()) for key in ("unwanted", "lag", "rebound"))
        cells = " | ".join(f"{one:.1f}" for one in sums)
        print(f"| {name} | {cells} | {_over_cases(found, name, 'dose') / dose:.2f} |")


def draw(found: dict[str, dict[str, dict[str, float]]], path: Path) -> None:
    """Error against travel of every algorithm, each in geometric means over all cases."""
    figure, axes = plt.subplots(figsize=(7.0, 4.2), layout="constrained")
    names = [*ALL[:-1], *list(LIVELY)[:2], "predictive", *list(LIVELY)[2:]]
    at = {name: (_over_cases(found, name, "travel"), _over_cases(found, name, "rmse")) for name in names}
    others, knob = np.array([at[n] for n in ALL[:-1]]), np.array([at[n] for n in names[len(ALL) - 1 :]])
    axes.plot(*others.T, "o", color="0.45")
    axes.plot(*knob.T, "o-", color="tab:blue")
    for name in names:
        known = name in LIVELY
        axes.annotate(
            f"{LIVELY[name]:g}" if known else name,
            at[name],
            xytext=BESIDE.get(name, (6, 5)),
            textcoords="offset points",
            fontsize=8,
            color="tab:blue" if known or name == "predictive" else "0.25",
        )
    axes.set(xlabel="travel used (RMS) [m]", ylabel="error of the felt force (RMSE) [m/s²]")
    axes.set_xlim(0.0, None)
    axes.set_ylim(0.0, 1.12 * others[:, 1].max())
    axes.set_title("Geometric means over all cases; in blue the liveliness of predictive", fontsize=9)
    figure.savefig(path, dpi=140)


def _over_cases(found: dict[str, dict[str, dict[str, float]]], name: str, key: str) -> float:
    return float(np.exp(np.mean([np.log(case[name][key]) for case in found.values()])))


def _work(job: tuple[str, tuple[otolith.Wanted, Dof], str]) -> tuple[str, dict[str, dict[str, float]]]:
    name, (wanted, dof), platform = job
    return name, figures(wanted, dof, platform)


def main() -> None:
    """Run all, print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drive", type=Path, nargs="*", default=[])
    parser.add_argument("--random", type=int, default=0)
    parser.add_argument("--platform", default="thesis")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        jobs = [(n, c, chosen.platform) for n, c in cases(chosen.drive, chosen.random, Path(folder)).items()]
        first, *others = jobs
        found: dict[str, Any] = dict([_work(first)])  # compiles, before there are two that would
        with ProcessPoolExecutor(chosen.jobs) as pool:
            found |= dict(pool.map(_work, others))
    show(found)
    show_unwanted(found)
    if chosen.figure:
        draw(found, chosen.figure)
    if chosen.json:
        chosen.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
