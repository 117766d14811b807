"""What an earlier lap is worth: `--road` on laps of another pace, and the share of the gap to the optimum.

    python benchmarks/road_preview.py [--platform NAME] [--json FILE]

Laps of Hockenheim by the virtual driver, at most 80, 100 and 120 km/h, the first 100 s of each through the
otolith of eq. 6.4, lengthwise (x) and sidewise (y). The road is foreseen from a lap 10 % slower, from the lap
itself (no driver drives twice alike: a bound), and from one a fifth slower. The gap is that between what
knows nothing of the road (`adaptive`) and the offline optimum, which knows it all.
"""

import argparse
import json
import tempfile
from dataclasses import replace
from pathlib import Path

import otolith
from otolith import files, registry
from otolith.core.frames import Dof
from otolith.cueing.optimum import optimum
from otolith.cueing.prediction import Oracle, Prediction, Road
from otolith.vehicle import Driver, drive, load_car, road

LASTS = 100.0  # [s]
SPEEDS = (80, 100, 120)  # [km/h]
EARLIER = {"10 % slower": 0.9, "the same": 1.0, "20 % slower": 0.8}


def lap(speed: float, folder: Path) -> Path:
    """A lap at most at this speed [km/h], driven once and kept."""
    path = folder / f"lap-{speed:g}.csv"
    if not path.exists():
        files.write_lap(drive(road("hockenheim").limited(speed / 3.6), load_car(), Driver()), path)
    return path


def error(wanted: otolith.Wanted, dof: Dof, platform: str, prediction: Prediction | None) -> float:
    """RMSE of the felt force [m/s²]; a broken limit ends the benchmark."""
    plain = otolith.Design(platform=otolith.platform(platform), dofs=(dof,))
    design = replace(plain, mpc=replace(plain.mpc, prediction=prediction))
    scenario = wanted.along(design)
    run = otolith.simulate(
        registry.make_cueing("predictive", design),
        registry.make_plant("ideal", design.platform),
        replace(scenario, duration=min(scenario.duration, LASTS)),
        platform=design.platform,
        dofs=(dof.name,),
        preview=design.preview,
    )
    summary = otolith.summarise(run)
    if summary["violations"]:
        raise SystemExit(f"{prediction} broke {summary['violations']} limits on {scenario.name}")
    return float(summary["rmse_per_pair"][dof.name])


def case(speed: int, dof: Dof, platform: str, folder: Path) -> dict[str, float]:
    """RMSE of every prediction on one lap and axis, and of the optimum."""
    wanted = otolith.Wanted(log=lap(speed, folder), through="telban")
    found = {"adaptive": error(wanted, dof, platform, None)}
    for name, factor in EARLIER.items():
        known = replace(wanted, road=lap(factor * speed, folder))
        found[name] = error(known, dof, platform, Road())
    found["oracle, 5 s"] = error(wanted, dof, platform, Oracle(time=5.0))
    design = otolith.Design(platform=otolith.platform(platform), dofs=(dof,))
    scenario = wanted.along(design)
    best = optimum(design.platform, (dof,), replace(scenario, duration=min(scenario.duration, LASTS)))
    found["optimum"] = float(otolith.summarise(best.run)["rmse_per_pair"][dof.name])
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--platform", default="thesis")
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    found: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for speed in SPEEDS:
            for letter, dof in (("x", otolith.SURGE_PITCH), ("y", otolith.SWAY_ROLL)):
                found[f"lap {speed} {letter}"] = case(speed, dof, chosen.platform, Path(folder))
    columns = list(next(iter(found.values())))
    print("| RMSE [m/s²]; share of the gap closed | " + " | ".join(columns) + " |")
    print("|---" * (len(columns) + 1) + "|")
    for name, row in found.items():
        gap = row["adaptive"] - row["optimum"]
        cells = [f"{row[c]:.3f}; {100.0 * (row['adaptive'] - row[c]) / gap:.0f} %" for c in columns[1:-1]]
        print(" | ".join([f"| {name}", f"{row['adaptive']:.3f}", *cells, f"{row['optimum']:.3f} |"]))
    for column in columns[1:-1]:
        shares = [(r["adaptive"] - r[column]) / (r["adaptive"] - r["optimum"]) for r in found.values()]
        print(f"{column}: {100.0 * sum(shares) / len(shares):.0f} % of the gap closed on average")
    if chosen.json is not None:
        chosen.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
